// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/border_settlement.h"

#include "analytic_scenes.h"
#include "patch_plane_clustering/core/clustering.h"
#include "patch_plane_clustering/core/connected_pieces.h"
#include "run_checks.h"

#include <gtest/gtest.h>

#include <functional>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

const CoplanarityTolerance kTolerance{0.005, 0.005, 1.0};
const NoiseModel kNoise(SensorModel{0.01, 0.01, 10.0, 0.0}, 1.0);
constexpr int kSmallest = 100;

// Two walls that meet at right angles in the middle of the image, 3 m away: label 1 to the left, 2 to the right.
struct Corner {
  BeamGrid grid = forwardBeams(60, 80, 0.005);
  LabelImage truth, piece_labels;
  LabelPieces pieces;

  Corner() {
    truth = scan({wall({-1.0, 1.0, 0.0}, -3.0 / std::sqrt(2.0)), wall({-1.0, -1.0, 0.0}, -3.0 / std::sqrt(2.0))}, grid);
    addNoise(grid, 0.01);
    if (truth.labels[0] != 1) {
      for (std::int32_t& label : truth.labels) label = 3 - label;
    }
  }

  // Makes labels(row, col) the labels before, and pieces of them, each named by itself.
  void start(const std::function<std::int32_t(int, int)>& labels) {
    piece_labels = truth;
    for (int i = 0; i < grid.size(); ++i) piece_labels.labels[i] = labels(i / grid.cols, i % grid.cols);
    pieces.runs = labelRuns(piece_labels);
    SplitMemory memory;
    splitRuns(grid.cols, 0, 0, memory, pieces.runs, pieces.whole);
    paintRuns(pieces.runs, piece_labels);
    pieces.names.resize(pieces.whole.size());
    for (std::size_t k = 0; k < pieces.names.size(); ++k) pieces.names[k] = static_cast<std::int32_t>(k);
  }

  std::int32_t pieceAt(int row, int col) const { return piece_labels.labels[grid.index(row, col)]; }

  // Settles with the true planes of the labels 1 and 2, and that of the wall to the right for any other.
  LabelImage settle(std::vector<std::int32_t>* whole = nullptr) const {
    PatchGrid cells = makePatchGrid(grid, 4, true);
    weighPatches(kNoise, cells);
    LabelImage wholes = piece_labels;
    for (std::int32_t& label : wholes.labels) label = pieces.whole[label];
    std::vector<Eigen::Vector3d> planes = labelPlanes(shareCells(grid, cells, kNoise, truth));
    planes.resize(10, planes[2]);
    LabelImage out = wholes;
    BorderMemory memory;
    std::vector<std::int32_t> of_pieces;
    settleBorders(grid, cells, shareCells(grid, cells, kNoise, wholes), planes, kNoise, kTolerance, pieces, kSmallest, 0, 0,
                  memory, out, of_pieces);
    expectRunsOf(out, memory.settled);
    LabelImage of_three = wholes;
    settleBorders(grid, cells, shareCells(grid, cells, kNoise, wholes), planes, kNoise, kTolerance, pieces, kSmallest, 0, 0,
                  memory, of_three, of_pieces, 3);
    EXPECT_EQ(of_three.labels, out.labels);
    expectRunsOf(out, memory.settled);
    if (whole != nullptr) *whole = of_pieces;
    return out;
  }
};

TEST(SettleBorders, MovesTheBorderOfTwoRegionsToTheirCrease) {
  Corner corner;
  corner.start([](int, int c) { return c < 45 ? 1 : 2; });
  std::vector<std::int32_t> whole;
  const LabelImage out = corner.settle(&whole);
  int wrong = 0;
  for (int i = 0; i < corner.grid.size(); ++i) wrong += whole[out.labels[i]] != corner.truth.labels[i] ? 1 : 0;
  EXPECT_LT(wrong, corner.grid.rows);  // less than a pixel a row; before, five
}

TEST(SettleBorders, WhatWasNoRegionStaysNone) {
  Corner corner;
  corner.start([](int, int c) { return c < 45 ? 1 : 2; });
  corner.pieces.names[corner.pieceAt(0, 79)] = 0;  // a strip of something curved, say
  std::vector<std::int32_t> whole;
  const LabelImage out = corner.settle(&whole);
  EXPECT_EQ(out.labels[corner.grid.index(30, 70)], 0);
  EXPECT_EQ(whole[out.labels[corner.grid.index(30, 20)]], 1);
  EXPECT_EQ(whole[out.labels[corner.grid.index(30, 43)]], 1);  // though the strip's plane explains it better
}

TEST(SettleBorders, WhatWasNoRegionKeepsItsPoints) {
  Corner corner;
  corner.start([](int, int c) { return c < 35 ? 1 : 2; });
  corner.pieces.names[corner.pieceAt(0, 0)] = 0;
  const LabelImage out = corner.settle();
  EXPECT_EQ(out.labels[corner.grid.index(30, 20)], 0);
  EXPECT_GT(out.labels[corner.grid.index(30, 70)], 0);
  EXPECT_EQ(out.labels[corner.grid.index(30, 37)], out.labels[corner.grid.index(30, 70)]);
}

TEST(SettleBorders, WhatGrowsFromWhatBendsIsNoRegionEither) {
  for (const int width : {8, 30}) {
    Corner corner;  // beside a strip of something curved, which its plane explains better
    corner.start([&](int, int c) { return c < width ? 1 : 2; });
    corner.pieces.names[corner.pieceAt(0, 79)] = 0;
    const LabelImage out = corner.settle();
    EXPECT_EQ(out.labels[corner.grid.index(30, 4)] != 0, width == 30);
    EXPECT_EQ(countOf(out, 0) == corner.grid.size(), width == 8);
  }
}

TEST(SettleBorders, WhatBendsDropsNoPointsOfARegion) {
  Corner corner;  // as before; but a region with points on the wall to the right has some on that to the left
  corner.start([](int r, int c) { return c < 8 ? 1 : r < 24 && (c < 14 || r < 8) ? 3 : 2; });
  std::vector<std::int32_t> whole;
  const LabelImage taken = corner.settle(&whole);
  ASSERT_EQ(whole[taken.labels[corner.grid.index(15, 10)]], 1);  // while nothing bends
  corner.pieces.names[corner.pieceAt(59, 79)] = 0;
  const LabelImage out = corner.settle(&whole);
  EXPECT_EQ(out.labels[corner.grid.index(40, 4)], 0);
  EXPECT_EQ(whole[out.labels[corner.grid.index(4, 60)]], 3);
  EXPECT_EQ(out.labels[corner.grid.index(15, 10)], out.labels[corner.grid.index(4, 60)]);
}

TEST(SettleBorders, ASoftEdgeOfWhatBendsIsNoRegion) {
  Corner corner;
  corner.start([](int, int c) { return c < 8 ? 1 : c < 60 ? 2 : 3; });
  corner.pieces.names[corner.pieceAt(30, 30)] = 0;
  EXPECT_GT(corner.settle().labels[corner.grid.index(30, 70)], 0);
  corner.pieces.names[corner.pieceAt(30, 70)] = corner.pieceAt(30, 4);
  EXPECT_EQ(corner.settle().labels[corner.grid.index(30, 70)], 0);
}

TEST(SettleBorders, AScrapDoesNotGrowIntoARegion) {
  Corner corner;
  const auto scrap = [](int r, int c) { return r >= 26 && r < 34 && c >= 40 && c < 46 ? 2 : 1; };  // 48 points
  corner.start(scrap);
  const LabelImage small = corner.settle();
  EXPECT_EQ(small.labels[corner.grid.index(30, 43)], 0);
  EXPECT_GT(small.labels[corner.grid.index(30, 20)], 0);
  corner.start([&](int r, int c) { return r >= 20 ? scrap(26 + (r - 20) / 5, c) : 1; });  // the same shape of 240 points
  std::vector<std::int32_t> whole;
  const LabelImage large = corner.settle(&whole);
  EXPECT_EQ(whole[large.labels[corner.grid.index(40, 43)]], 2);
}

TEST(SettleBorders, AScrapTakesNothingThoughItsLabelHasARegionElsewhere) {
  Corner corner;
  const auto scrap = [](int r, int c) { return r >= 28 && r < 32 && c >= 48 && c < 54; };  // 24 points
  corner.start([&](int r, int c) { return c >= 70 || scrap(r, c) ? 2 : 1; });
  const LabelImage out = corner.settle();
  EXPECT_EQ(out.labels[corner.grid.index(30, 50)], 0);
  EXPECT_LE(countOf(out, 0), 24);
}

TEST(SettleBorders, ARegionIsNotLostToACurvedPieceOfItsLabel) {
  Corner corner;  // the piece to the right is curved; a sliver of another label parts it from the region
  corner.start([](int, int c) { return c < 40 ? 1 : c < 56 ? 2 : c < 58 ? 1 : 2; });
  corner.pieces.names[corner.pieceAt(0, 79)] = 0;
  const LabelImage out = corner.settle();
  EXPECT_GT(out.labels[corner.grid.index(30, 48)], 0);
  EXPECT_EQ(out.labels[corner.grid.index(30, 70)], 0);
}

TEST(SettleBorders, ASoftEdgeStaysWithItsPlane) {
  Corner corner;  // the strip is wider than what competes
  corner.start([](int, int c) { return c < 40 ? 1 : c < 60 ? 3 : 2; });
  corner.pieces.names[corner.pieceAt(0, 50)] = corner.pieceAt(0, 79);
  const LabelImage out = corner.settle();
  EXPECT_GT(out.labels[corner.grid.index(30, 50)], 0);
  EXPECT_EQ(out.labels[corner.grid.index(30, 50)], out.labels[corner.grid.index(30, 70)]);
  EXPECT_NE(out.labels[corner.grid.index(30, 50)], out.labels[corner.grid.index(30, 20)]);
}

// Whichever comes first: a plane may be the soft edge of another one by now.
TEST(SettleBorders, SoftEdgesGetTheirPlanesOwnNames) {
  Corner corner;
  corner.start([](int, int c) { return c < 40 ? 1 : c < 53 ? 3 : c < 66 ? 2 : 4; });
  const std::int32_t left = corner.pieceAt(30, 46), middle = corner.pieceAt(30, 60), right = corner.pieceAt(30, 73);
  for (const auto& [from, to] : {std::pair(left, right), std::pair(right, left)}) {
    corner.pieces.names[from] = middle;
    corner.pieces.names[middle] = to;
    corner.pieces.names[to] = to;
    const LabelImage out = corner.settle();
    const auto label = [&](std::int32_t piece) {
      return out.labels[corner.grid.index(30, piece == left ? 46 : piece == right ? 73 : 60)];
    };
    EXPECT_GT(label(from), 0);
    EXPECT_EQ(label(middle), label(to));
    EXPECT_NE(label(from), label(to));
  }
}

TEST(SettleBorders, LeavesAnImageWithoutLabelsAlone) {
  Corner corner;
  corner.start([](int, int) { return 0; });
  EXPECT_EQ(countOf(corner.settle(), 0), corner.grid.size());
}

}  // namespace
}  // namespace ppc
