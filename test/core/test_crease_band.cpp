// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/crease_band.h"

#include "patch_plane_clustering/core/crease_meetings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace ppc {
namespace {

std::set<int> take(PixelSet& set) {
  std::set<int> pixels;
  set.takeFours([&](int pixel, int which) {
    for (int k = 0; k < 4; ++k) {
      const bool fresh = (which >> k & 1) == 0 || pixels.insert(pixel + k).second;
      EXPECT_TRUE(fresh);
    }
  });
  return pixels;
}

TEST(PixelSet, HasWhatWasAddedOnce) {
  std::mt19937 random(1);
  PixelSet set;
  set.resize(1000);
  for (int trial = 0; trial < 100; ++trial) {
    std::set<int> expected;
    for (int k = 0; k < trial; ++k) {
      const auto first = static_cast<int>(random() % 969U);
      const auto which = static_cast<std::uint32_t>(random() & random());
      for (int i = 0; i < 32; ++i) {
        if ((which >> i & 1U) != 0) expected.insert(first + i);
      }
      set.add(first, which);
    }
    EXPECT_EQ(take(set), expected);
    EXPECT_TRUE(take(set).empty());
  }
}

// Stretches of few labels, so that they meet often.
LabelImage randomImage(int rows, int cols, std::mt19937& random) {
  LabelImage labels{rows, cols, {}};
  for (int i = 0; i < rows * cols; ++i) {
    const bool above = i >= cols && random() % 2 != 0, before = i > 0 && random() % 5 != 0;
    const auto any = static_cast<std::int32_t>(random() % 4U);
    labels.labels.push_back(above ? labels.labels[i - cols] : before ? labels.labels.back() : any);
  }
  return labels;
}

using Pixels = std::map<std::pair<std::int32_t, std::int32_t>, std::set<int>>;

// Plainly, pixel by pixel.
Pixels bandsPlainly(const LabelImage& labels, int smallest, int reach) {
  Pixels bands;
  for (int r = 0; r < labels.rows; ++r) {
    for (int c = 0; c < labels.cols; ++c) {
      for (const auto& [dr, dc] : {std::pair(0, 1), std::pair(1, 0)}) {
        if (r < dr || c < dc) continue;
        const std::int32_t a = labels.labels[(r - dr) * labels.cols + c - dc], b = labels.labels[r * labels.cols + c];
        const auto small = [&](std::int32_t label) {
          return std::count(labels.labels.begin(), labels.labels.end(), label) < smallest;
        };
        if (a == b || a == 0 || b == 0 || small(a) || small(b)) continue;
        std::set<int>& band = bands[{std::min(a, b), std::max(a, b)}];
        for (const int sign : {-1, 1}) {
          for (int k = sign < 0 ? 1 : 0; k < (sign < 0 ? reach + 1 : reach); ++k) {
            const int row = r + sign * k * dr, col = c + sign * k * dc, i = row * labels.cols + col;
            if (row < 0 || row >= labels.rows || col < 0 || col >= labels.cols) break;
            if (labels.labels[i] != a && labels.labels[i] != b) break;
            band.insert(i);
          }
        }
      }
    }
  }
  return bands;
}

TEST(CreaseBand, HasThePixelsOnBothSidesOfAllMeetings) {
  std::mt19937 random(2);
  CreaseMeetings meetings;
  for (int trial = 0; trial < 100; ++trial) {
    const LabelImage labels = randomImage(1 + trial % 20, 1 + trial % 43, random);
    const int smallest = trial % 3 == 0 ? 40 : 1, reach = 1 + trial % CreaseBand::kMaxReach;
    findCreaseMeetings(labelRuns(labels), labels.rows, labels.cols, 4, smallest, meetings);
    Pixels found;
    PixelSet set;
    set.resize(labels.rows * labels.cols);
    for (const CreaseMeetings::Pair& pair : meetings.pairs) {
      CreaseBand band(labels, pair.first, pair.second, reach, set);
      for (int m = pair.begin; m < pair.end; ++m) {
        const auto [pixel, columns] = meetings.places[m];
        if (columns == 0) {
          band.addAlongRow(pixel);
        } else {
          band.addAlongColumns(pixel, columns);
        }
      }
      EXPECT_TRUE(found.emplace(std::pair(pair.first, pair.second), take(set)).second);
    }
    EXPECT_EQ(found, bandsPlainly(labels, smallest, reach));
  }
}

}  // namespace
}  // namespace ppc
