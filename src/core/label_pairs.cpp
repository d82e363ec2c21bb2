// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/label_pairs.h"

namespace ppc {

void findTouching(const RowRuns& runs, int gap, std::size_t labels, LabelPairIndex& index,
                  std::vector<std::pair<std::int32_t, std::int32_t>>& pairs) {
  index.start(labels);
  const auto meet = [&](const LabelRun& a, const LabelRun& b) {
    if (a.label != b.label) index.find(a.label, b.label);
  };
  for (int r = 0; r < runs.rows(); ++r) {
    const LabelRun* const end = runs.end(r);
    for (const LabelRun* run = runs.begin(r); run != end; ++run) {
      for (const LabelRun* next = run + 1; next != end && next->begin <= run->end + gap; ++next) meet(*run, *next);
    }
    for (int back = 1; back <= std::min(r, gap + 1); ++back) {
      forEachOverlap(runs, r - back, r, [&](const LabelRun& above, const LabelRun& below, int, int) { meet(above, below); });
    }
  }
  pairs.clear();
  for (const LabelPairIndex::Entry& entry : index.entries()) pairs.emplace_back(entry.first, entry.second);
  std::sort(pairs.begin(), pairs.end());
}

}  // namespace ppc
