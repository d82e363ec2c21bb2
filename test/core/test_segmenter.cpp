// SPDX-License-Identifier: BSD-3-Clause
// What PPC must find in single surfaces and small scenes.
#include "patch_plane_clustering/core/segmenter.h"

#include "analytic_scenes.h"
#include "patch_plane_clustering/core/connected_pieces.h"
#include "patch_plane_clustering/core/region_statistics.h"
#include "patch_plane_clustering/core/segmentation_memory.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <map>
#include <string>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr double kStep = 0.25 * kDegree;

const auto kLeft = [](const Eigen::Vector3d& p) { return p.y() > 0.0; };
const auto kRight = [](const Eigen::Vector3d& p) { return p.y() <= 0.0; };

Segmentation segmented(const BeamGrid& grid) { return segment(grid, Config()); }

// Share of the pixels with `truth` that have the label most of them have.
double share(const LabelImage& truth, std::int32_t of, const LabelImage& labels, std::int32_t& label) {
  std::vector<int> votes;
  for (std::size_t i = 0; i < truth.labels.size(); ++i) {
    if (truth.labels[i] != of) continue;
    if (labels.labels[i] >= static_cast<int>(votes.size())) votes.resize(static_cast<std::size_t>(labels.labels[i]) + 1, 0);
    ++votes[labels.labels[i]];
  }
  const auto most = std::max_element(votes.begin(), votes.end());
  label = static_cast<std::int32_t>(most - votes.begin());
  return static_cast<double>(*most) / countOf(truth, of);
}

// Every surface of the truth is one region of its own.
void expectRegions(const LabelImage& truth, int count, const Segmentation& result, double least) {
  EXPECT_EQ(result.regions.size(), static_cast<std::size_t>(count));
  std::vector<std::int32_t> found;
  for (std::int32_t of = 1; of <= count; ++of) {
    std::int32_t label = 0;
    EXPECT_GT(share(truth, of, result.labels, label), least) << "surface " << of;
    EXPECT_GT(label, 0) << "surface " << of;
    EXPECT_EQ(std::count(found.begin(), found.end(), label), 0) << "surface " << of;
    found.push_back(label);
  }
}

TEST(Segmenter, RecoversAPlaneExactlyWithoutNoise) {
  for (const double d : {0.1, 0.3, 1.0, 3.0, 10.0, 30.0}) {
    const Eigen::Vector3d normal = Eigen::Vector3d(-1.0, 0.2, -0.1).normalized();
    BeamGrid grid = forwardBeams(90, 120, kStep);
    scan({wall(normal, -d)}, grid);
    const Segmentation result = segmented(grid);
    ASSERT_EQ(result.regions.size(), 1U) << d;
    const PlanarRegion& region = result.regions[0];
    EXPECT_EQ(region.points, grid.size()) << d;
    EXPECT_LT((region.plane.normal - normal).norm(), 1e-5) << d;
    EXPECT_NEAR(region.plane.d, -d, 1e-5 * d) << d;
    EXPECT_LT(region.rms, 1e-6 * d + 1e-7) << d;
  }
}

TEST(Segmenter, FindsBothWallsOfACrease) {
  for (const double angle : {90.0, 150.0}) {  // between the walls, on the side of the sensor
    const double half = 0.5 * angle * kDegree;
    const Eigen::Vector3d left(-std::sin(half), -std::cos(half), 0.0), right(-std::sin(half), std::cos(half), 0.0);
    BeamGrid grid = forwardBeams(120, 200, kStep);
    const double d = -3.0 * std::sin(half);
    const LabelImage truth = scan({surfaceOf({{left, d}, kLeft}), surfaceOf({{right, d}, kRight})}, grid);
    addNoise(grid, 0.01);
    const Segmentation result = segmented(grid);
    expectRegions(truth, 2, result, 0.98);
    std::int32_t label_left = 0, label_right = 0;
    share(truth, 1, result.labels, label_left);
    share(truth, 2, result.labels, label_right);
    ASSERT_EQ(result.regions.size(), 2U);
    EXPECT_LT((result.regions[label_left - 1].plane.normal - left).norm(), 0.002) << angle;
    EXPECT_LT((result.regions[label_right - 1].plane.normal - right).norm(), 0.002) << angle;
    // A pixel may be wrong only where the walls are within three sigma of each other.
    int wrong = 0;
    for (int i = 0; i < grid.size(); ++i) {
      if (result.labels.labels[i] != (truth.labels[i] == 1 ? label_left : label_right)) {
        const double beyond = 2.0 * std::abs(grid.point(i).y()) * std::abs(std::cos(half));
        wrong += beyond > 3.0 * 0.01 + 0.02 ? 1 : 0;
      }
    }
    EXPECT_LT(wrong, 0.005 * grid.size()) << angle;
  }
}

// A wall and a face of some six columns that meet at a slanted corner: no pixel of one turns the plane of the other.
TEST(Segmenter, ANarrowFaceEndsAtTheCrease) {
  Config config;
  config.min_size = 350;
  const Plane wide{Eigen::Vector3d(-1.0, 0.0, 0.0), -2.5};
  const Eigen::Vector3d normal = Eigen::Vector3d(-0.9, -0.4, 0.1).normalized();
  const Plane narrow{normal, normal.dot(Eigen::Vector3d(2.5, 0.2, 0.0))};
  constexpr int kImages = 20;
  int wrong = 0, points = 0;
  double degrees = 0.0;
  for (int image = 0; image < kImages; ++image) {
    BeamGrid grid = forwardBeams(90, 120, kStep);
    const LabelImage truth = scanFaces({{wide, [](const Eigen::Vector3d& p) { return p.y() < 0.25; }},
                                        {narrow, [](const Eigen::Vector3d& p) { return p.y() < 0.27; }}},
                                       grid);
    points += countOf(truth, 2);
    addNoise(grid, 0.02, 0.0, 0.0, static_cast<std::uint64_t>(image));
    const Segmentation result = segment(grid, config);
    ASSERT_EQ(result.regions.size(), 2U) << image;
    for (int i = 0; i < grid.size(); ++i) wrong += result.labels.labels[i] != truth.labels[i] ? 1 : 0;
    degrees += std::acos(std::min(1.0, result.regions[1].plane.normal.dot(normal))) / kDegree;
  }
  ASSERT_GT(points, 400 * kImages);
  ASSERT_LT(points, 700 * kImages);
  EXPECT_LT(wrong, 110 * kImages);
  EXPECT_LT(degrees, 1.1 * kImages);
}

TEST(Segmenter, SeparatesAStep) {
  BeamGrid grid = forwardBeams(120, 200, kStep);
  const LabelImage truth =
      scan({surfaceOf({{-Eigen::Vector3d::UnitX(), -2.95}, kLeft}), surfaceOf({{-Eigen::Vector3d::UnitX(), -3.0}, kRight})},
           grid);
  addNoise(grid, 0.01);
  const Segmentation result = segmented(grid);
  expectRegions(truth, 2, result, 0.98);
  ASSERT_EQ(result.regions.size(), 2U);
  std::int32_t label = 0;
  share(truth, 1, result.labels, label);
  EXPECT_NEAR(result.regions[label - 1].plane.d, -2.95, 0.001);
  EXPECT_NEAR(result.regions[2 - label].plane.d, -3.0, 0.001);
}

TEST(Segmenter, AFineSensorTellsASmallStep) {
  for (const double noise : {0.0, 0.0005, 0.001}) {
    BeamGrid grid = forwardBeams(120, 200, kStep);
    const LabelImage truth = scan(
        {surfaceOf({{-Eigen::Vector3d::UnitX(), -0.993}, kLeft}), surfaceOf({{-Eigen::Vector3d::UnitX(), -1.0}, kRight})},
        grid);
    addNoise(grid, noise);
    expectRegions(truth, 2, segmented(grid), 0.98);
  }
}

TEST(Segmenter, SeesAWallThroughAWindow) {
  const auto front = [](const Eigen::Vector3d& p) {
    return std::abs(p.y()) < 1.2 && std::abs(p.z()) < 0.8 && !(std::abs(p.y()) < 0.4 && std::abs(p.z()) < 0.3);
  };
  const auto behind = [](const Eigen::Vector3d& p) { return std::abs(p.y()) < 0.75 && std::abs(p.z()) < 0.55; };
  BeamGrid grid = forwardBeams(400, 560, 0.5 * kStep);  // the wall behind is cut by the window on all sides
  const LabelImage truth = scan(
      {surfaceOf({{-Eigen::Vector3d::UnitX(), -2.5}, front}), surfaceOf({{-Eigen::Vector3d::UnitX(), -3.5}, behind})}, grid);
  addNoise(grid, 0.005);
  const Segmentation result = segmented(grid);
  expectRegions(truth, 2, result, 0.98);
  ASSERT_EQ(result.polygons.size(), 2U);
  EXPECT_EQ(result.polygons[0].id, 1);
  EXPECT_EQ(result.polygons[0].holes.size(), 1U);
  EXPECT_NEAR(result.polygons[0].area, 2.4 * 1.6 - 0.8 * 0.6, 0.02 * 3.36);
  EXPECT_TRUE(result.polygons[1].holes.empty());
  EXPECT_NEAR(result.polygons[1].area, 0.8 * 0.6 * std::pow(3.5 / 2.5, 2), 0.02 * 0.94);  // what shows through the window
}

// It stands off by less than the noise of a range: a patch alone cannot tell to which of the two it belongs.
TEST(Segmenter, FindsAPictureOnTheWallBelowTheNoise) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const auto picture = [](const Eigen::Vector3d& p) { return std::abs(p.y()) < 0.5 && std::abs(p.z()) < 0.35; };
    BeamGrid grid = forwardBeams(200, 320, kStep);
    const LabelImage truth =
        scan({surfaceOf({{-Eigen::Vector3d::UnitX(), -2.97}, picture}), wall({-1.0, 0.0, 0.0}, -3.0)}, grid);
    addNoise(grid, 0.04, 0.0, 0.0, seed);
    const Segmentation result = segmented(grid);
    expectRegions(truth, 2, result, 0.8);
    ASSERT_EQ(result.regions.size(), 2U) << seed;
    EXPECT_NEAR(result.regions[0].plane.d, -3.0, 0.003) << seed;
    EXPECT_NEAR(result.regions[1].plane.d, -2.97, 0.006) << seed;
  }
}

TEST(Segmenter, AColumnIsNoPlane) {
  for (const double noise : {0.0, 0.001, 0.003, 0.005, 0.01}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      BeamGrid grid = forwardBeams(120, 160, kStep);
      const LabelImage truth = scan({column(1.3, 0.0, 0.3)}, grid);
      if (noise > 0.0) addNoise(grid, noise, 0.0, 0.0, seed);
      ASSERT_GT(countOf(truth, 1), 5000);
      const Segmentation result = segmented(grid);
      EXPECT_TRUE(result.regions.empty()) << "noise " << noise << ", seed " << seed;
      EXPECT_TRUE(result.polygons.empty()) << "noise " << noise << ", seed " << seed;
      EXPECT_EQ(result.valid_points, countOf(truth, 1));
    }
  }
}

// As points go to the nearest plane, its two halves and the strips at its limbs look flatter than they are.
TEST(Segmenter, AThinColumnInMuchNoiseIsHardlyEverAPlane) {
  double points = 0.0, labelled = 0.0;
  for (int seed = 1; seed <= 10; ++seed) {
    BeamGrid grid = forwardBeams(240, 200, 0.5 * kStep);
    const LabelImage truth = scan({column(1.3, 0.0, 0.2)}, grid);
    addNoise(grid, 0.04, 0.0, 0.0, seed);
    points += countOf(truth, 1);
    labelled += grid.size() - countOf(segmented(grid).labels, 0);
  }
  EXPECT_LT(labelled, 0.1 * points);  // strips at limbs; three quarters if halves at wide angles were no fan
}

// It comes in narrow strips that turn little, each and against each other.
TEST(Segmenter, ATankIsNoPlaneForAFineSensor) {
  for (const double noise : {0.0, 0.0005, 0.001, 0.002}) {
    BeamGrid grid = forwardBeams(120, 160, kStep);
    scan({column(2.0, 0.0, 1.0)}, grid);
    addNoise(grid, noise);
    EXPECT_TRUE(segmented(grid).regions.empty()) << "noise " << noise;
  }
}

TEST(Segmenter, AColumnInFrontOfAWallLeavesTheWall) {
  BeamGrid grid = forwardBeams(160, 240, kStep);
  LabelImage truth = scan({wall({-1.0, 0.0, 0.0}, -4.0), column(2.5, 0.0, 0.5)}, grid);
  addNoise(grid, 0.01);
  for (std::int32_t& label : truth.labels) label = label == 1 ? 1 : 0;
  splitComponents(0, 0, truth);  // the column parts the wall
  const Segmentation result = segmented(grid);
  expectRegions(truth, 2, result, 0.98);
  for (const PlanarRegion& region : result.regions) EXPECT_NEAR(region.plane.d, -4.0, 0.002);
}

TEST(Segmenter, APictureOnAWallIsARegion) {
  const auto picture = [](const Eigen::Vector3d& p) { return std::abs(p.y()) < 0.3 && std::abs(p.z()) < 0.25; };
  BeamGrid grid = forwardBeams(160, 240, kStep);
  const LabelImage truth =
      scan({wall({-1.0, 0.0, 0.0}, -2.0), surfaceOf({{-Eigen::Vector3d::UnitX(), -1.97}, picture})}, grid);
  addNoise(grid, 0.005);
  const Segmentation result = segmented(grid);
  expectRegions(truth, 2, result, 0.95);
  ASSERT_EQ(result.regions.size(), 2U);
  EXPECT_NEAR(result.regions[1].plane.d, -1.97, 0.001);
}

TEST(Segmenter, ABowedWallIsOneRegion) {
  BeamGrid grid = forwardBeams(160, 220, kStep);  // 3 m wide at 3 m
  scan({relief([](double y) { return 3.0 - 0.005 * (1.0 - std::pow(y / 1.5, 2)); })}, grid);
  addNoise(grid, 0.01);
  const Segmentation result = segmented(grid);
  ASSERT_EQ(result.regions.size(), 1U);
  EXPECT_GT(result.regions[0].points, 0.98 * grid.size());
}

// A room of six faces. Beyond +-90 deg the lines see the other side: floor, ceiling and back wall come in parts.
struct BoxRoom {
  BeamGrid grid = toBeamGrid(noddingScan(361, 541, -45.0 * kDegree, 45.0 * kDegree, 135.0 * kDegree));
  LabelImage truth;
  int faces = 0;

  BoxRoom() {
    const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
    truth = scan({wall(-x, -3.0), wall(x, -1.5), wall(-y, -2.0), wall(y, -2.2), wall(-z, -1.2), wall(z, -1.0)}, grid);
    addNoise(grid, 0.01);
    splitComponents(0, 0, truth);
    faces = renumberBySize(grid, 350, truth);
  }
};

TEST(Segmenter, ABoxRoomHasSixFacesAlsoTowardsThePoles) {
  const BoxRoom room;
  EXPECT_GE(room.faces, 6);
  expectRegions(room.truth, room.faces, segmented(room.grid), 0.95);
}

TEST(Segmenter, ARoomKeepsItsFacesWithoutAnyOneOfTheLaterSteps) {
  const BoxRoom room;
  for (const char* name :
       {"clear_strays", "thin_standing_lines", "thin_smooth_noise", "noise_by_surface", "avoid_range_limit", "refine",
        "second_pass", "split_regions", "settle_borders", "settle_low_steps", "refit_regions", "dissolve_regions",
        "align_creases", "trim_regions", "extend_regions", "fill_holes"}) {
    SCOPED_TRACE(name);
    Config config;
    setConfigField(config, name, 0.0);
    expectRegions(room.truth, room.faces, segment(room.grid, config), 0.85);
  }
}

// Pixels of the wall or the pane that are not of the region with most of it.
int strayPixels(const LabelImage& truth, const LabelImage& found) {
  int stray = 0;
  for (const std::int32_t face : {1, 2}) {
    std::map<std::int32_t, int> count;
    for (std::size_t i = 0; i < truth.labels.size(); ++i) {
      if (truth.labels[i] == face) ++count[found.labels[i]];
    }
    int most = 0;
    for (const auto& [label, n] : count) most = label > 0 ? std::max(most, n) : most;
    stray += countOf(truth, face) - most;
  }
  return stray;
}

TEST(Segmenter, APaneThatNoiseHidesFromSinglePointsHasItsBorder) {
  for (const double depth : {0.025, 0.03}) {
    BeamGrid grid = forwardBeams(160, 240, 0.004);
    const LabelImage truth = scanPaneBehind(depth, grid);
    addNoise(grid, 0.04);
    Config config;
    const LabelImage with = segment(grid, config).labels;
    config.threads = 4;
    EXPECT_EQ(segment(grid, config).labels.labels, with.labels);
    config.settle_low_steps = false;
    const LabelImage without = segment(grid, config).labels;
    EXPECT_LT(strayPixels(truth, with), 0.9 * strayPixels(truth, without)) << depth;
  }
}

TEST(Segmenter, IdsRunByDescendingSizeAndSameInputGivesSameOutput) {
  const auto narrow = [](const Eigen::Vector3d& p) { return p.y() > 0.6; };
  BeamGrid grid = forwardBeams(120, 200, kStep);
  scan({surfaceOf({{-Eigen::Vector3d::UnitX(), -2.5}, narrow}), wall({-1.0, 0.0, 0.0}, -3.0)}, grid);
  addNoise(grid, 0.01);
  const Segmentation first = segmented(grid), second = segmented(grid);
  EXPECT_EQ(first.labels.labels, second.labels.labels);
  ASSERT_EQ(first.regions.size(), 2U);
  for (std::size_t k = 0; k < first.regions.size(); ++k) {
    EXPECT_EQ(first.regions[k].id, static_cast<int>(k) + 1);
    EXPECT_EQ(first.regions[k].points, countOf(first.labels, first.regions[k].id));
    EXPECT_EQ(first.regions[k].plane.d, second.regions[k].plane.d);
  }
  EXPECT_GT(first.regions[0].points, first.regions[1].points);
  ASSERT_EQ(first.stages.size(), second.stages.size());
  for (std::size_t k = 0; k < first.stages.size(); ++k) EXPECT_EQ(first.stages[k].first, second.stages[k].first);
}

TEST(Segmenter, AWallWithMissingPixelsIsOneRegion) {
  const std::vector<std::function<bool(int, int, Normal&)>> patterns{
      [](int r, int c, Normal&) { return (r + c) % 2 == 0; },  // checker
      [](int r, int, Normal&) { return r % 3 == 0; },          // rows
      [](int, int, Normal& n) { return n.uniform() < 0.4; }};  // dropouts
  for (std::size_t k = 0; k < patterns.size(); ++k) {
    BeamGrid grid = forwardBeams(120, 160, kStep);
    scan({wall({-1.0, 0.2, 0.0}, -3.0)}, grid);
    addNoise(grid, 0.01);
    Normal normal(11);
    int valid = grid.size();
    for (int i = 0; i < grid.size(); ++i) {
      if (!patterns[k](i / grid.cols, i % grid.cols, normal)) continue;
      grid.range[i] = kNoRange;
      --valid;
    }
    const Segmentation result = segmented(grid);
    EXPECT_EQ(result.valid_points, valid);
    ASSERT_EQ(result.regions.size(), 1U) << k;
    EXPECT_GT(result.regions[0].points, 0.97 * valid) << k;
  }
}

TEST(Segmenter, ImagesOfAnyShapeAreSegmented) {
  for (const auto& [rows, cols] : std::vector<std::pair<int, int>>{{1, 400}, {400, 1}, {3, 3}, {1, 1}, {2, 5}, {121, 163}}) {
    for (const int k : {2, 4, 7, 64}) {
      BeamGrid grid = forwardBeams(rows, cols, kStep);
      scan({wall({-1.0, 0.0, 0.0}, -3.0)}, grid);
      Config config;
      config.patch_size = k;
      config.min_size = 3;
      const Segmentation result = segment(grid, config);
      EXPECT_EQ(result.labels.labels.size(), grid.range.size());
      EXPECT_EQ(result.valid_points, grid.size());
      if (rows * cols > 1000) {  // the last rows and columns too
        EXPECT_EQ(countOf(result.labels, 1), grid.size()) << k;
      }
      BeamGrid empty = forwardBeams(rows, cols, kStep);
      const Segmentation none = segment(empty, config);
      EXPECT_EQ(none.valid_points, 0);
      EXPECT_TRUE(none.regions.empty());
      EXPECT_EQ(countOf(none.labels, 0), grid.size());
    }
  }
}

TEST(Segmenter, EveryAdditionCanBeSwitchedOff) {
  BeamGrid grid = toBeamGrid(noddingScan(300, 240, -30.0 * kDegree, 30.0 * kDegree, 100.0 * kDegree));
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY();
  scan({wall(-x, -3.0), wall({-1.0, -0.1, 0.0}, -3.0), wall(-y, -2.0), wall(y, -2.2)}, grid);
  addNoise(grid, 0.01);
  const auto stages = [&](const Config& config) {
    std::string names;
    for (const StageTime& stage : segment(grid, config).stages) names += stage.first + " ";
    return names;
  };
  const auto labels = [&](const char* name) {
    Config config;
    config.merge = config.refine = false;  // these make good for the others here
    setConfigField(config, name, 0.0);
    return clusterPatches(grid, config).labels;
  };
  const std::vector<std::int32_t> all = labels("merge");
  for (const char* name : {"equal_angle", "running_plane", "noise_aware"}) EXPECT_NE(labels(name), all) << name;
  Config plain;
  EXPECT_NE(stages(plain).find("merging"), std::string::npos);
  plain.merge = plain.refine = false;
  EXPECT_EQ(stages(plain).find("merging"), std::string::npos);
  EXPECT_EQ(stages(plain).find("refinement"), std::string::npos);
}

TEST(Segmenter, WithoutMergingANoisyWallIsInMorePieces) {
  BeamGrid grid = forwardBeams(120, 160, kStep);
  scan({wall({-1.0, 0.0, 0.0}, -3.0)}, grid);
  addNoise(grid, 0.03);
  Config config;
  config.similarity_threshold = 0.7;  // so that noise alone parts the wall
  config.refine = false;
  const std::size_t merged = segment(grid, config).regions.size();
  config.merge = false;
  EXPECT_GT(segment(grid, config).regions.size(), merged);
}

TEST(Segmenter, DropsRegionsBelowTheMinimumSize) {
  const auto picture = [](const Eigen::Vector3d& p) { return std::abs(p.y()) < 0.2 && std::abs(p.z()) < 0.2; };
  BeamGrid grid = forwardBeams(120, 160, kStep);
  scan({surfaceOf({{-Eigen::Vector3d::UnitX(), -1.5}, picture}), wall({-1.0, 0.0, 0.0}, -3.0)}, grid);
  addNoise(grid, 0.01);
  Config config;
  const Segmentation all = segment(grid, config);
  ASSERT_EQ(all.regions.size(), 2U);
  const int size = all.regions[1].points;
  config.min_size = size;
  EXPECT_EQ(segment(grid, config).regions.size(), 2U);
  config.min_size = size + 1;
  const Segmentation one = segment(grid, config);
  EXPECT_EQ(one.regions.size(), 1U);
  EXPECT_EQ(countOf(one.labels, 2), 0);
}

TEST(Segmenter, KeepsSmallerFacesOfAFineSensor) {
  const auto picture = [](const Eigen::Vector3d& p) { return std::abs(p.y()) < 0.04 && std::abs(p.z()) < 0.04; };
  for (const auto& [sigma, regions] : {std::pair(0.001, 2U), std::pair(0.01, 1U)}) {
    BeamGrid grid = forwardBeams(240, 320, kStep);
    const LabelImage truth =
        scan({surfaceOf({{-Eigen::Vector3d::UnitX(), -1.8}, picture}), wall({-1.0, 0.0, 0.0}, -3.0)}, grid);
    EXPECT_GT(countOf(truth, 1), smallestRegion(Config(), grid.size(), 0.001));
    EXPECT_LT(countOf(truth, 1), smallestRegion(Config(), grid.size()));
    addNoise(grid, sigma);
    EXPECT_EQ(segmented(grid).regions.size(), regions) << sigma;
  }
}

// Bit for bit: labels, planes, covariances, polygons.
void expectSame(const Segmentation& found, const Segmentation& expected) {
  EXPECT_EQ(found.labels.rows, expected.labels.rows);
  EXPECT_EQ(found.labels.cols, expected.labels.cols);
  EXPECT_EQ(found.labels.labels, expected.labels.labels);
  EXPECT_EQ(found.valid_points, expected.valid_points);
  EXPECT_EQ(found.regions_without_polygon, expected.regions_without_polygon);
  EXPECT_EQ(found.stages.size(), expected.stages.size());
  ASSERT_EQ(found.regions.size(), expected.regions.size());
  for (std::size_t k = 0; k < expected.regions.size(); ++k) {
    EXPECT_EQ(found.regions[k].plane.normal, expected.regions[k].plane.normal);
    EXPECT_EQ(found.regions[k].plane.d, expected.regions[k].plane.d);
    EXPECT_EQ(found.regions[k].covariance, expected.regions[k].covariance);
    EXPECT_EQ(found.regions[k].rms, expected.regions[k].rms);
  }
  ASSERT_EQ(found.polygons.size(), expected.polygons.size());
  for (std::size_t k = 0; k < expected.polygons.size(); ++k) {
    EXPECT_EQ(found.polygons[k].id, expected.polygons[k].id);
    EXPECT_EQ(found.polygons[k].outer, expected.polygons[k].outer);
    EXPECT_EQ(found.polygons[k].holes, expected.polygons[k].holes);
    EXPECT_EQ(found.polygons[k].area, expected.polygons[k].area);
  }
}

// Images of other sizes and with other settings in between leave nothing behind.
TEST(Segmenter, MemoryOfOneImageDoesNotChangeTheNext) {
  ClusteringMemory memory;
  Segmentation result;
  for (const auto& [rows, cols, patch_size] :
       std::vector<std::array<int, 3>>{{120, 160, 4}, {200, 240, 4}, {200, 240, 6}, {7, 9, 4}, {1, 50, 3}, {120, 160, 4}}) {
    BeamGrid grid = forwardBeams(rows, cols, 0.004);
    scan({wall({-1.0, 0.1, 0.0}, -3.0), wall({0.0, -1.0, 0.0}, -0.3), wall({0.0, 0.0, 1.0}, -0.2)}, grid);
    addNoise(grid, 0.01);
    Config config;
    config.patch_size = patch_size;
    config.threads = patch_size == 6 ? 2 : 1;
    segment(grid, config, memory, result);
    SCOPED_TRACE(std::to_string(rows) + " x " + std::to_string(cols));
    expectSame(result, segment(grid, config));
  }
}

TEST(Segmenter, DoesNotDependOnTheNumberOfThreads) {
  BeamGrid grid = forwardBeams(200, 240, 0.004);
  scan({wall({-1.0, 0.1, 0.0}, -3.0), wall({0.0, -1.0, 0.0}, -0.8), wall({0.0, 0.0, 1.0}, -0.6),
        wall({-1.0, -0.6, 0.1}, -2.8)},
       grid);
  addNoise(grid, 0.01);
  Config config;
  const Segmentation one = segment(grid, config);
  EXPECT_GE(one.regions.size(), 3U);
  for (const int threads : {2, 4, 7}) {
    config.threads = threads;
    SCOPED_TRACE(std::to_string(threads) + " threads");
    expectSame(segment(grid, config), one);
  }
}

}  // namespace
}  // namespace ppc
