// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/label_reunion.h"

#include "patch_plane_clustering/core/label_joining.h"
#include "patch_plane_clustering/core/whole_tolerance.h"

#include <algorithm>
#include <cstddef>

namespace ppc {
namespace {

constexpr double kMostMisfit = 0.7;
constexpr int kFewestPoints = 6;  // of each label

// Of the planes of two labels as wholes.
double misfitOf(const Moments& a, const Moments& b, const NoiseModel& noise, const CoplanarityTolerance& tolerance) {
  const Moments& small = a.n < b.n ? a : b;
  const PlaneFit joint = fitPlane(a + b), fit_a = fitPlane(a), fit_b = fitPlane(b);
  const double range = small.mean().norm(), sigma = noise.sigmaOf(small, range);
  CoplanarityTolerance local = tolerance.forNoise(sigma);
  local.inflation = tolerance.inflationOf(small.n);
  return misfit(joint.chi2 - fit_a.chi2 - fit_b.chi2, small.n / (sigma * sigma), std::min(small.radius(), kMaxWholeRadius),
                leastSecantSquared(joint, fit_a, fit_b, range), local);
}

// Whether two labels met when labels were merged last.
bool haveMet(const std::vector<MeetingGroup>& met, std::int32_t a, std::int32_t b) {
  const std::uint64_t key = Meeting::keyOf(a, b);
  const auto found = std::lower_bound(met.begin(), met.end(), key,
                                      [](const MeetingGroup& group, std::uint64_t k) { return group.key < k; });
  return found != met.end() && found->key == key;
}

}  // namespace

void reuniteLabels(int rows, int cols, const CellShares& shares, const NoiseModel& noise,
                   const CoplanarityTolerance& tolerance, const std::vector<MeetingGroup>& met, std::int32_t merged,
                   ReunionMemory& memory, LabelPieces& pieces, std::vector<LabelRun>& runs,
                   std::vector<Eigen::Vector3d>& planes) {
  const std::size_t count = planes.size();
  memory.has_region.assign(count, 0);
  for (std::size_t piece = 1; piece < pieces.names.size(); ++piece) {
    if (pieces.names[piece] != 0) memory.has_region[pieces.whole[piece]] = 1;
  }
  cutAtRows(runs, rows, cols, memory.rows);
  findTouching(memory.rows, 0, count, memory.index, memory.touching);
  memory.candidates.clear();
  for (const auto& [a, b] : memory.touching) {
    if ((memory.has_region[a] & memory.has_region[b]) == 0) continue;
    if (b >= merged || haveMet(met, a, b)) continue;
    const Moments &first = shares.sums[a], &second = shares.sums[b];
    if (std::min(first.n, second.n) < kFewestPoints) continue;
    const double m = misfitOf(first, second, noise, tolerance);
    if (m <= kMostMisfit) memory.candidates.push_back({m, kMostMisfit, {a, b}});
  }
  if (memory.candidates.empty()) return;
  memory.sums = shares.sums;
  joinLabels([&](const Moments& a, const Moments& b) { return misfitOf(a, b, noise, tolerance); }, memory.candidates,
             memory.sums, memory.names, planes);
  for (std::int32_t& label : pieces.whole) label = memory.names[label];
  renameRuns(memory.names, runs);
}

}  // namespace ppc
