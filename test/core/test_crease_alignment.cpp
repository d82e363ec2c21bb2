// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/crease_alignment.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr double kSigma = 0.04;
const NoiseModel kNoise(SensorModel{kSigma, kSigma, 100.0, 0.0}, 1.0);
const CoplanarityTolerance kTolerance{0.005, 0.005, 1.0};

// Two surfaces, their labels 1 and 2, and their planes.
struct Scene {
  BeamGrid grid = forwardBeams(60, 120, 0.005);
  LabelImage truth;
  std::vector<Eigen::Vector3d> planes;

  Scene(const std::vector<Surface>& surfaces, const std::vector<Plane>& of_label) {
    truth = scan(surfaces, grid);
    addNoise(grid, kSigma);
    planes.push_back(Eigen::Vector3d::Zero());
    for (const Plane& plane : of_label) planes.push_back(plane.normal / plane.d);
  }

  LabelImage aligned(LabelImage labels, int smallest = 3) const {
    CreaseMemory memory;
    alignCreases(grid, planes, Eigen::Vector3d::Zero(), kNoise, kTolerance, smallest, memory, labels);
    return labels;
  }

  int wrong(const LabelImage& labels) const {
    int count = 0;
    for (std::size_t i = 0; i < labels.labels.size(); ++i) count += labels.labels[i] != truth.labels[i] ? 1 : 0;
    return count;
  }
};

// Labels of every point within some columns of the border, by which of the two planes it is nearer to.
LabelImage byDistance(const Scene& scene, const std::vector<Plane>& of_label, int reach) {
  LabelImage labels = scene.truth;
  for (int r = 0; r < labels.rows; ++r) {
    for (int c = 0; c < labels.cols; ++c) {
      const int i = scene.grid.index(r, c), first = scene.grid.index(r, std::max(0, c - reach));
      const int last = scene.grid.index(r, std::min(labels.cols - 1, c + reach));
      if (scene.truth.labels[first] == scene.truth.labels[last]) continue;
      const Eigen::Vector3d p = scene.grid.point(i).cast<double>();
      labels.labels[i] = std::abs(of_label[0].signedDistance(p)) <= std::abs(of_label[1].signedDistance(p)) ? 1 : 2;
    }
  }
  return labels;
}

Plane planeOf(const Eigen::Vector3d& normal, double d) { return {normal.normalized(), d / normal.norm()}; }

TEST(AlignCreases, DrawsTheBorderWhereThePlanesMeet) {
  for (const double turn : {0.2, 0.4, 0.7}) {
    const Eigen::Vector3d left(-1.0, turn, 0.1), right(-1.0, -turn, 0.1);
    const std::vector<Plane> planes = {planeOf(left, -3.0), planeOf(right, -3.0)};
    for (const bool box : {false, true}) {  // seen from within a corner, or from outside of an edge
      const auto both = [&](const Eigen::Vector3d& o, const Eigen::Vector3d& u) {
        return std::pair(planes[0].rangeAlong(o, u), planes[1].rangeAlong(o, u));
      };
      const auto seen = [=](int which) {
        return [=](const Eigen::Vector3d& o, const Eigen::Vector3d& u) {
          const auto [a, b] = both(o, u);
          return ((a < b) != box) == (which == 0) ? (which == 0 ? a : b) : kNoHit;
        };
      };
      const Scene scene({seen(0), seen(1)}, planes);
      ASSERT_GT(countOf(scene.truth, 1), 1000);
      ASSERT_GT(countOf(scene.truth, 2), 1000);
      const LabelImage ragged = byDistance(scene, planes, 5);
      ASSERT_GT(scene.wrong(ragged), 40);
      // What remains are points beyond 2.5 standard deviations from the right plane, or where the planes are apart.
      EXPECT_LT(scene.wrong(scene.aligned(ragged)), scene.wrong(ragged) / 3) << turn << (box ? " box" : " corner");
    }
  }
}

// Nothing tells where a picture on a wall ends but its own points; an edge in front of a wall neither.
TEST(AlignCreases, LeavesStepsAsTheyAre) {
  for (const double ahead : {0.02, 0.06, 0.3}) {
    const Plane back = planeOf({-1.0, 0.0, 0.0}, -3.0), front = planeOf({-1.0, 0.0, 0.0}, -3.0 + ahead);
    const auto left = [](const Eigen::Vector3d& p) { return p.y() > 0.0; };
    const auto right = [](const Eigen::Vector3d& p) { return p.y() <= 0.0; };
    const Scene scene({surfaceOf({back, left}), surfaceOf({front, right})}, {back, front});
    EXPECT_EQ(scene.wrong(scene.aligned(scene.truth)), 0) << ahead;
  }
}

TEST(AlignCreases, RegionsThatAreTooSmallTakeNoPart) {
  const std::vector<Plane> planes = {planeOf({-1.0, 1.0, 0.0}, -3.0), planeOf({-1.0, -1.0, 0.0}, -3.0)};
  const Scene scene({[&](const auto& o, const auto& u) { return std::min(planes[0].rangeAlong(o, u), 100.0); },
                     [&](const auto& o, const auto& u) { return std::min(planes[1].rangeAlong(o, u), 100.0); }},
                    planes);
  const LabelImage ragged = byDistance(scene, planes, 5);
  const int smaller = std::min(countOf(ragged, 1), countOf(ragged, 2));
  EXPECT_EQ(scene.aligned(ragged, smaller + 1).labels, ragged.labels);
  EXPECT_NE(scene.aligned(ragged, smaller).labels, ragged.labels);
}

}  // namespace
}  // namespace ppc
