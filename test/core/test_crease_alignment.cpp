// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/crease_alignment.h"

#include "patch_plane_clustering/core/crease_lanes.h"

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
    LabelImage again = labels;
    CreaseMeetings meetings;
    findCreaseMeetings(labelRuns(labels), labels.rows, labels.cols, planes.size(), smallest, meetings);
    const JudgedImage image{grid, Eigen::Vector3d::Zero(), kNoise, kTolerance, smallest};
    alignCreases(image, planes, meetings, memory, labels);
    // With memory as left.
    alignCreases(image, planes, meetings, memory, again, 2);
    EXPECT_EQ(again.labels, labels.labels);
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

// Plainly: ranges at which a beam meets the planes, compared in double precision.
TEST(CreaseLanes, CompareRangesWithoutDividing) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const auto vector = [&] { return Eigen::Vector3d(any(random), any(random), any(random)); };
  int apart = 0, open = 0, farther = 0;
  for (int trial = 0; trial < 500; ++trial) {
    BeamGrid grid = forwardBeams(2, 4, 0.1);
    grid.origin_x = grid.origin_y = grid.origin_z = std::vector<float>(8);
    const Eigen::Vector3d center = vector(), a = Eigen::Vector3d(0.4, 0.1, 0.1) + 0.2 * vector();
    const Eigen::Vector3d b = trial % 2 == 0 ? Eigen::Vector3d(a + 0.02 * vector()) : vector();
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3f origin = 0.1F * vector().cast<float>();
      grid.origin_x[i] = origin.x(), grid.origin_y[i] = origin.y(), grid.origin_z[i] = origin.z();
      const double range = (1.0 - a.dot(grid.origin(i).cast<double>() - center)) / a.dot(grid.direction(i).cast<double>());
      grid.range[i] = i == 3 ? 0.0F : static_cast<float>(range + 0.1 * any(random));
    }
    const int pixels[kLanes] = {6, 1, 3, 4};
    const LaneMask of_first = {-1, 0, -1, 0};
    const Lanes variance = {0.001F, 0.002F, 0.001F, 0.001F};
    const CreaseLanes planes(a, b, center);
    const BeamLanes beams(grid, pixels, firstLanes(4));
    const CreaseLanes::Heights heights = planes.heightsAt(beams.origin_x, beams.origin_y, beams.origin_z);
    const auto found = planes.compare(beams, heights, variance, of_first, 1, 1.5, 2.5);
    for (int k = 0; k < kLanes; ++k) {
      const auto rangeTo = [&](const Eigen::Vector3d& plane) {
        return (1.0 - plane.dot(grid.origin(pixels[k]).cast<double>() - center)) /
               plane.dot(grid.direction(pixels[k]).cast<double>());
      };
      const double first = rangeTo(a), second = rangeTo(b), difference = first - second, sigma = std::sqrt(variance[k]);
      const double residual = std::abs(grid.range[pixels[k]] - (of_first[k] != 0 ? second : first));
      const bool met = grid.valid(pixels[k]) && first > 0.0 && second > 0.0;
      EXPECT_EQ(found.apart[k] != 0, met && std::abs(difference) > sigma);
      EXPECT_EQ(found.open[k] != 0, met && std::abs(difference) < 1.5 * sigma && residual < 2.5 * sigma);
      EXPECT_EQ(found.first_farther[k] != 0, met && difference > 0.0);
      apart += found.apart[k] != 0, open += found.open[k] != 0, farther += found.first_farther[k] != 0;
    }
  }
  for (const int count : {apart, open, farther}) EXPECT_GT(count, 100);
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
