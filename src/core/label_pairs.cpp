// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/label_pairs.h"

#include <array>

namespace ppc {
namespace {

// Tells most of what has come before from what has not: runs of two rows meet as those of the rows before did. Labels that
// meet themselves count, too, so that hardly ever anything is new.
class RecentMeetings {
 public:
  bool isNew(std::int32_t a, std::int32_t b) {
    const std::uint64_t key = static_cast<std::uint64_t>(a) << 32U | static_cast<std::uint32_t>(b);
    std::uint64_t& kept = keys_[(static_cast<std::uint32_t>(a) * 29U + static_cast<std::uint32_t>(b)) % kKept];
    if (kept == key) return false;
    kept = key;
    return true;
  }

 private:
  static constexpr std::uint32_t kKept = 512;
  std::array<std::uint64_t, kKept> keys_{};  // no label is 0
};

}  // namespace

void findTouching(const RowRuns& runs, int gap, std::size_t labels, LabelPairIndex& index,
                  std::vector<std::pair<std::int32_t, std::int32_t>>& pairs) {
  index.start(labels);
  RecentMeetings recent;
  const auto meet = [&](const LabelRun& a, const LabelRun& b) {
    if (recent.isNew(a.label, b.label) && a.label != b.label) index.find(a.label, b.label);
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
