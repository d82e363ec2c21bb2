// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <cstdint>
#include <vector>

namespace ppc {

/// @brief Splits labels into pieces that are connected in the image. Gaps of up to `gap_cols` columns or `gap_rows` rows are
/// bridged. @return for every new label the one that it was part of; index = label.
std::vector<std::int32_t> splitComponents(int gap_rows, int gap_cols, LabelImage& labels);

/// @brief The same where the runs of an image with `cols` columns are known (labelRuns()).
/// @param runs set to those of the new labels; no image is painted.
std::vector<std::int32_t> splitRuns(int cols, int gap_rows, int gap_cols, std::vector<LabelRun>& runs);

}  // namespace ppc
