// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <cstdint>
#include <vector>

namespace ppc {

/// @brief Working memory of splitRuns(), which one image after the other may use.
struct SplitMemory {
  struct Run {  ///< pixels of one label in a row, gaps bridged
    std::int32_t label;
    int row, begin, end;  ///< columns
    int left, right;      ///< runs of the label beside it in its row
    int first_above;      ///< the label's first run in the nearest row above that has any within reach
    int above;            ///< its last one there that begins no farther right, or the first one
    int parent;           ///< of the run's piece: never a later run
  };
  struct Stretch {  ///< pixels without a gap
    int begin, end, run;
  };
  struct LatestRow {       ///< what is known of a label while rows are read
    int row, first, last;  ///< runs
    int first_above;
  };

  std::vector<LatestRow> latest;  ///< of each label
  std::vector<Run> runs;
  std::vector<Stretch> stretches;
  std::vector<std::int32_t> names;  ///< of each run that others have been joined to: its piece
};

/// @brief Splits labels into pieces that are connected in the image. Gaps of up to `gap_cols` columns or `gap_rows` rows are
/// bridged. @return for every new label the one that it was part of; index = label.
std::vector<std::int32_t> splitComponents(int gap_rows, int gap_cols, LabelImage& labels);

/// @brief The same where the runs of an image with `cols` columns are known (labelRuns()).
/// @param runs set to those of the new labels; no image is painted. @param whole set to what each new label was part of.
void splitRuns(int cols, int gap_rows, int gap_cols, SplitMemory& memory, std::vector<LabelRun>& runs,
               std::vector<std::int32_t>& whole);

}  // namespace ppc
