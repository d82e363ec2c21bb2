// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/label_pairs.h"
#include "patch_plane_clustering/core/moments.h"

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace ppc {

/// @brief Two labels that may be one.
struct JoinCandidate {
  double misfit;  ///< how far they are from that
  double most;    ///< misfit up to which they are one
  LabelPair pair;

  bool operator<(const JoinCandidate& other) const {
    return std::pair(misfit / most, pair) < std::pair(other.misfit / other.most, other.pair);
  }
};

/// @brief Joins labels, those that are most alike first, each time with the sums of what has been joined before.
/// @param candidates sorted by this. @param misfitOf misfitOf(sum, sum): of two labels' sums, as of the candidates.
/// @param sums of the labels; the lower label of what is joined gets all.
/// @param names set to the label that each is part of now. @param planes of labels that others have joined are set anew.
template <typename F>
void joinLabels(const F& misfitOf, std::vector<JoinCandidate>& candidates, std::vector<Moments>& sums,
                std::vector<std::int32_t>& names, std::vector<Eigen::Vector3d>& planes) {
  std::sort(candidates.begin(), candidates.end());
  names.resize(planes.size());
  std::iota(names.begin(), names.end(), 0);
  const auto nameOf = [&](std::int32_t label) {
    while (names[label] != label) label = names[label];
    return label;
  };
  for (const JoinCandidate& candidate : candidates) {
    const std::int32_t a = nameOf(candidate.pair.first), b = nameOf(candidate.pair.second);
    if (a == b || misfitOf(sums[a], sums[b]) > candidate.most) continue;
    const std::int32_t kept = std::min(a, b), joined = std::max(a, b);
    names[joined] = kept;
    sums[kept] += sums[joined];
    planes[kept] = fitPlane(sums[kept]).a;
  }
  for (std::size_t label = 0; label < names.size(); ++label) names[label] = nameOf(static_cast<std::int32_t>(label));
}

}  // namespace ppc
