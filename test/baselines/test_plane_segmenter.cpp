// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/baselines/plane_segmenter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

namespace ppc {
namespace {

constexpr int kRows = 120, kCols = 160;

// A camera that looks along x at two walls that meet at a right angle straight ahead, 3 m away, with noise of 2 mm; every
// 50th pixel is invalid.
BeamGrid corner() {
  std::mt19937 random(7);
  std::normal_distribution<float> noise(0.0F, 0.002F);
  std::vector<float> x, y, z;
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kCols; ++c) {
      const float v = 0.4F * (1.0F - static_cast<float>(2 * r) / static_cast<float>(kRows));
      const float u = 0.6F * (1.0F - static_cast<float>(2 * c) / static_cast<float>(kCols));
      const float length = std::sqrt(1.0F + u * u + v * v);
      const bool valid = (r * kCols + c) % 50 != 0;
      const float range = 3.0F / (1.0F + std::abs(u)) * length + noise(random);  // x + |y| = 3
      const float scale = valid ? range / length : std::nanf("");
      x.push_back(scale);
      y.push_back(scale * u);
      z.push_back(scale * v);
    }
  }
  return beamGridFromPoints(kRows, kCols, x, y, z);
}

class EveryMethod : public testing::TestWithParam<std::string> {};

TEST_P(EveryMethod, FindsTheTwoWallsOfACorner) {
  const Segmentation result = segmentWith(*makeSegmenter(GetParam()), corner(), Config());
  ASSERT_GE(result.regions.size(), 2U);
  // Normals of windows blur the crease, and only PCL's multi-plane method has nothing that would take those points back.
  const double share = GetParam() == "pcl_multi_plane" ? 0.65 : 0.85;
  // Left (y > 0): normal (-1, -1, 0) / sqrt 2; right: (-1, 1, 0) / sqrt 2; both at 3 / sqrt 2.
  for (const std::size_t k : {0U, 1U}) {
    const PlanarRegion& region = result.regions[k];
    const double side = region.centroid.y() > 0.0 ? 1.0 : -1.0;
    EXPECT_GT(region.plane.normal.dot(Eigen::Vector3d(-1.0, -side, 0.0).normalized()), std::cos(0.03));
    EXPECT_NEAR(region.plane.d, -3.0 / std::sqrt(2.0), 0.02);
    EXPECT_GT(region.points, share * kRows * kCols / 2);
    EXPECT_LT(region.points, 1.02 * kRows * kCols / 2);
  }
  EXPECT_LT(result.regions[0].centroid.y() * result.regions[1].centroid.y(), 0.0);
}

TEST_P(EveryMethod, LabelsNoPixelWithoutAMeasurement) {
  const BeamGrid grid = corner();
  const LabelImage labels = makeSegmenter(GetParam())->label(grid, Config(), nullptr);
  ASSERT_EQ(labels.rows, kRows);
  ASSERT_EQ(labels.cols, kCols);
  ASSERT_EQ(labels.labels.size(), static_cast<std::size_t>(kRows * kCols));
  int wrong = 0;
  for (int i = 0; i < grid.size(); ++i) wrong += !grid.valid(i) && labels.labels[i] != 0 ? 1 : 0;
  EXPECT_EQ(wrong, 0);
}

TEST_P(EveryMethod, GivesTheSameLabelsTwice) {
  const BeamGrid grid = corner();
  const auto method = makeSegmenter(GetParam());
  const LabelImage first = method->label(grid, Config(), nullptr);
  EXPECT_EQ(first.labels, method->label(grid, Config(), nullptr).labels);
  EXPECT_EQ(first.labels, makeSegmenter(GetParam())->label(grid, Config(), nullptr).labels);
}

TEST_P(EveryMethod, FindsNothingInAnImageWithoutMeasurements) {
  const std::vector<float> none(static_cast<std::size_t>(kRows * kCols), std::nanf(""));
  const BeamGrid grid = beamGridFromPoints(kRows, kCols, none, none, none);
  const Segmentation result = segmentWith(*makeSegmenter(GetParam()), grid, Config());
  EXPECT_TRUE(result.regions.empty());
  EXPECT_TRUE(result.polygons.empty());
  EXPECT_EQ(result.valid_points, 0);
}

TEST_P(EveryMethod, FindsNoRegionInImagesThatAreTooSmall) {
  for (const auto& [rows, cols] : std::vector<std::pair<int, int>>{{1, 40}, {40, 1}, {2, 2}}) {
    std::vector<float> x, y, z;
    for (int i = 0; i < rows * cols; ++i) {
      x.push_back(2.0F);
      y.push_back(0.01F * static_cast<float>(i % cols));
      z.push_back(0.01F * static_cast<float>(i / cols));
    }
    const BeamGrid grid = beamGridFromPoints(rows, cols, x, y, z);
    EXPECT_EQ(segmentWith(*makeSegmenter(GetParam()), grid, Config()).regions.size(), 0U) << rows << " x " << cols;
  }
}

TEST_P(EveryMethod, ReportsItsStages) {
  const Segmentation result = segmentWith(*makeSegmenter(GetParam()), corner(), Config());
  ASSERT_GE(result.stages.size(), 3U);
  for (const auto& [name, ms] : result.stages) EXPECT_GE(ms, 0.0) << name;
  EXPECT_EQ(result.stages.back().first, "polygons");
}

INSTANTIATE_TEST_SUITE_P(PlaneSegmenter, EveryMethod, testing::ValuesIn(segmenterNames()),
                         [](const testing::TestParamInfo<std::string>& each) { return each.param; });

TEST(MakeSegmenter, AnUnknownNameListsTheKnownOnes) {
  try {
    makeSegmenter("magic");
    FAIL() << "no exception";
  } catch (const std::invalid_argument& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("'magic'"), std::string::npos);
    for (const auto& name : segmenterNames()) EXPECT_NE(what.find(name), std::string::npos) << name;
  }
}

TEST(MethodParameters, AreWithinTheirRanges) {
  for (const std::string& name : segmenterNames()) {
    const auto method = makeSegmenter(name);
    for (const MethodParameter& each : method->parameters()) {
      EXPECT_LE(each.min, each.value) << name << " " << each.name;
      EXPECT_GE(each.max, each.value) << name << " " << each.name;
      EXPECT_THROW(method->setParameter(each.name, each.max + 1.0), std::invalid_argument);
      EXPECT_THROW(method->setParameter(each.name, std::nan("")), std::invalid_argument);
    }
    EXPECT_THROW(method->setParameter("no_such", 1.0), std::invalid_argument);
    EXPECT_EQ(method->parameters().empty(), name == "ppc");
  }
}

TEST(MethodParameters, ChangeTheResult) {
  const BeamGrid grid = corner();
  for (const auto& [name, parameter] :
       std::vector<std::pair<std::string, std::string>>{{"region_growing", "point_distance"},

                                                        {"pcl_region_growing", "smoothness"},
                                                        {"pcl_region_growing", "half_window"},
                                                        {"pcl_multi_plane", "angle"},
                                                        {"pcl_multi_plane", "distance"},
                                                        {"ransac", "distance"}}) {
    const auto method = makeSegmenter(name);
    const std::vector<std::int32_t> before = method->label(grid, Config(), nullptr).labels;
    for (const MethodParameter& each : method->parameters()) {
      if (each.name == parameter) {
        method->setParameter(parameter, each.min);
        break;
      }
    }
    EXPECT_NE(method->label(grid, Config(), nullptr).labels, before) << name << " " << parameter;
  }
}

}  // namespace
}  // namespace ppc
