// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/label_reunion.h"

#include "analytic_scenes.h"
#include "patch_plane_clustering/core/clustering.h"

#include <gtest/gtest.h>

#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

const CoplanarityTolerance kTolerance{0.005, 0.005, 1.0};
const NoiseModel kNoise(SensorModel{0.01, 0.01, 10.0, 0.0}, 1.0);
constexpr int kMiddle = 40;  // column of the border between the labels 1 and 2

// A wall 3 m away as two labels of a piece each, whose right part lies deeper by `step` [m].
struct Halves {
  BeamGrid grid = forwardBeams(60, 80, 0.005);
  CellShares shares;
  LabelPieces pieces;
  std::vector<LabelRun> runs;
  std::vector<Eigen::Vector3d> planes;
  std::vector<MeetingGroup> met;
  std::int32_t merged = 3;

  explicit Halves(double step, int gap = 0) {
    scan({wall({-1.0, 0.0, 0.0}, -3.0)}, grid);
    addNoise(grid, 0.01);
    LabelImage labels;
    labels.rows = grid.rows;
    labels.cols = grid.cols;
    labels.labels.resize(static_cast<std::size_t>(grid.size()));
    for (int i = 0; i < grid.size(); ++i) {
      const int col = i % grid.cols;
      if (col >= kMiddle) grid.range[i] += static_cast<float>(step);
      labels.labels[i] = col < kMiddle ? 1 : col < kMiddle + gap ? 0 : 2;
    }
    PatchGrid cells = makePatchGrid(grid, 4, true);
    weighPatches(kNoise, cells);
    shares = shareCells(grid, cells, kNoise, labels);
    planes = labelPlanes(shares);
    runs = labelRuns(labels);
    pieces.runs = runs;
    pieces.whole = pieces.names = {0, 1, 2};
  }

  // Whether both halves have become one label everywhere.
  bool reunite() {
    ReunionMemory memory;
    reuniteLabels(grid.rows, grid.cols, shares, kNoise, kTolerance, met, merged, memory, pieces, runs, planes);
    const bool joined = pieces.whole[2] == 1;
    for (const LabelRun& run : runs) EXPECT_EQ(run.label == 2, !joined && run.begin % grid.cols >= kMiddle);
    return joined;
  }
};

TEST(ReuniteLabels, MakesOneOfWhatHasOnePlaneAndTouchesSince) {
  Halves halves(0.0);
  const PlaneFit both = fitPlane(halves.shares.sums[1] + halves.shares.sums[2]);
  EXPECT_TRUE(halves.reunite());
  EXPECT_TRUE(halves.planes[1].isApprox(both.a, 1e-12));
}

TEST(ReuniteLabels, LeavesAStepAndWhatDoesNotTouch) {
  EXPECT_FALSE(Halves(0.02).reunite());
  EXPECT_FALSE(Halves(0.0, 1).reunite());
}

TEST(ReuniteLabels, LeavesWhatWasJudgedOrSplitOrBends) {
  Halves judged(0.0);
  judged.met.push_back({Meeting::keyOf(1, 2), 0, 1, false});
  EXPECT_FALSE(judged.reunite());
  Halves split(0.0);
  split.merged = 2;
  EXPECT_FALSE(split.reunite());
  Halves bent(0.0);
  bent.pieces.names[2] = 0;
  EXPECT_FALSE(bent.reunite());
}

}  // namespace
}  // namespace ppc
