// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/label_runs.h"

#include <gtest/gtest.h>

#include <vector>

namespace ppc::testing_tools {

/// Runs that a stage hands on are those of its labels.
inline void expectRunsOf(const LabelImage& labels, const std::vector<LabelRun>& runs) {
  const std::vector<LabelRun> expected = labelRuns(labels);
  ASSERT_EQ(runs.size(), expected.size());
  for (std::size_t k = 0; k < runs.size(); ++k) {
    EXPECT_EQ(runs[k].label, expected[k].label);
    EXPECT_EQ(runs[k].begin, expected[k].begin);
    EXPECT_EQ(runs[k].end, expected[k].end);
  }
}

}  // namespace ppc::testing_tools
