// SPDX-License-Identifier: BSD-3-Clause
// The kernels that all times are compared with do the work that they claim to do: against sums and eigenvectors in double
// precision, written plainly.
#include "floor.h"

#include "patch_plane_clustering/sim/scanner.h"

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>
#include <cmath>

namespace ppc::bench {
namespace {

struct Reference {
  int n = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  Eigen::Vector3d eigenvalues = Eigen::Vector3d::Zero();
};

Reference reference(const RangeImage& image, int patch_row, int patch_col) {
  std::vector<Eigen::Vector3d> points;
  for (int r = patch_row * kFloorPatch; r < std::min(image.rows, (patch_row + 1) * kFloorPatch); ++r) {
    for (int c = patch_col * kFloorPatch; c < std::min(image.cols, (patch_col + 1) * kFloorPatch); ++c) {
      const float range = image.ranges[static_cast<std::size_t>(r) * image.cols + c];
      if (!isValidRange(range, image.range_min, image.range_max)) continue;
      const double bearing = image.bearing(c);
      const Eigen::Vector3d in_plane(range * std::cos(bearing), range * std::sin(bearing), 0.0);
      points.push_back(Eigen::AngleAxisd(image.tilts[r], Eigen::Vector3d::UnitY()) * in_plane);
    }
  }
  Reference out;
  out.n = static_cast<int>(points.size());
  if (points.empty()) return out;
  for (const auto& p : points) out.mean += p / out.n;
  for (const auto& p : points) out.covariance += (p - out.mean) * (p - out.mean).transpose() / out.n;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(out.covariance);
  out.eigenvalues = solver.eigenvalues();
  out.normal = solver.eigenvectors().col(0);
  if (out.normal.dot(out.mean) > 0.0) out.normal = -out.normal;
  return out;
}

class Floor : public ::testing::Test {
 protected:
  Floor() {
    sim::ScannerOptions options;
    options.motion.lines_per_pass = 60;  // not a multiple of a patch, as 1081 beams are not
    options.errors = sim::ErrorModel::dataSheet(1.0);
    image_ = sim::Scanner(sim::makeScene("office", 3), options, 3).sweep(0).image;
    sumPatches(image_.ranges, floorGeometry(image_), sums_);
    fitPatches(sums_, planes_);
  }

  template <typename Check>
  void forEachPatch(const Check& check) const {
    for (int r = 0; r < sums_.rows; ++r) {
      for (int c = 0; c < sums_.cols; ++c) check(static_cast<std::size_t>(r * sums_.cols + c), reference(image_, r, c));
    }
  }

  RangeImage image_;
  FloorSums sums_;
  FloorPlanes planes_;
};

TEST_F(Floor, CoversTheImageWithPatches) {
  EXPECT_EQ(sums_.rows, 8);
  EXPECT_EQ(sums_.cols, 136);
  float points = 0.0F;
  for (const float n : sums_.n) points += n;
  int valid = 0;
  for (const float range : image_.ranges) valid += isValidRange(range, image_.range_min, image_.range_max) ? 1 : 0;
  EXPECT_EQ(static_cast<int>(points), valid);
  EXPECT_GT(valid, 50000);
}

TEST_F(Floor, SumsGiveMeanAndCovariance) {
  forEachPatch([&](std::size_t i, const Reference& expected) {
    ASSERT_EQ(sums_.n[i], static_cast<float>(expected.n)) << "patch " << i;
    if (expected.n == 0) return;
    const double n = sums_.n[i];
    const Eigen::Vector3d local(sums_.x[i] / n, sums_.y[i] / n, sums_.z[i] / n);
    const Eigen::Vector3d origin(sums_.origin_x[i], sums_.origin_y[i], sums_.origin_z[i]);
    EXPECT_LT((origin + local - expected.mean).norm(), 1e-5) << "patch " << i;
    Eigen::Matrix3d covariance;
    covariance << sums_.xx[i], sums_.xy[i], sums_.xz[i], sums_.xy[i], sums_.yy[i], sums_.yz[i], sums_.xz[i], sums_.yz[i],
        sums_.zz[i];
    covariance = covariance / n - local * local.transpose();
    EXPECT_LT((covariance - expected.covariance).norm(), 1e-6 + 1e-4 * expected.covariance.norm()) << "patch " << i;
  });
}

TEST_F(Floor, FitsAreThoseOfDoublePrecision) {
  int compared = 0;
  forEachPatch([&](std::size_t i, const Reference& expected) {
    const Eigen::Vector3d normal(planes_.normal_x[i], planes_.normal_y[i], planes_.normal_z[i]);
    if (expected.n < 3) {
      EXPECT_EQ(normal, Eigen::Vector3d::Zero());
      return;
    }
    // Where the two smallest eigenvalues are close, any direction between their vectors is as good.
    if (expected.eigenvalues[0] > 0.2 * expected.eigenvalues[1]) return;
    if (expected.eigenvalues[1] < 1e-3 * expected.eigenvalues[2]) return;
    ++compared;
    EXPECT_LT(normal.cross(expected.normal).norm(), 0.01 * M_PI / 180.0) << "patch " << i;
    const double d = expected.normal.dot(expected.mean);
    EXPECT_NEAR(std::abs(planes_.d[i]), std::abs(d), 1e-3) << "patch " << i;
    if (d < -0.01) {  // else the patch lies almost along the beams, and either side may look towards the sensor
      EXPECT_GT(normal.dot(expected.normal), 0.0) << "patch " << i;
    }
    EXPECT_NEAR(planes_.variance[i], expected.eigenvalues[0], 1e-7 + 1e-3 * expected.eigenvalues[0]) << "patch " << i;
  });
  EXPECT_GT(compared, 400);
}

TEST_F(Floor, PatchesWithoutMeasurementHaveNoPlane) {
  std::fill(image_.ranges.begin(), image_.ranges.end(), std::numeric_limits<float>::quiet_NaN());
  sumPatches(image_.ranges, floorGeometry(image_), sums_);
  fitPatches(sums_, planes_);
  for (std::size_t i = 0; i < sums_.n.size(); ++i) {
    EXPECT_EQ(sums_.n[i], 0.0F);
    EXPECT_EQ(planes_.normal_x[i], 0.0F);
    EXPECT_EQ(planes_.d[i], 0.0F);
  }
}

}  // namespace
}  // namespace ppc::bench
