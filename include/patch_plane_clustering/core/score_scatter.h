// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_fit.h"

#include <Eigen/Core>
#include <utility>
#include <vector>

namespace ppc {

/// @brief How much more the scores of a fit scatter than those of independent errors. A score is what a part of the region
/// pulls the plane by: the sum of its weighted errors and of their moments.
struct ScoreScatter {
  /// Covariance of the step x over that for independent errors, in coordinates in which the latter is the identity: those of
  /// L^T x, for the equations A = L L^T.
  Eigen::Matrix3d inflation = Eigen::Matrix3d::Identity();
  double freedom = 0.0;         ///< degrees of freedom of the inflation; 0: the parts do not tell it
  double wide_inflation = 1.0;  ///< mean of its diagonal for parts four times as large: more, if errors go together that far
  double wide_freedom = 0.0;    ///< likewise
};

/// @brief The sandwich estimator of a covariance, with parts as clusters (Huber 1967, Liang & Zeger 1986), scaled by what
/// the fit takes off the scores. What all parts share, as the same errors in all lines, does not show. Thread-safe.
/// @param begin,end sums of the parts of a region in the order of the image, about one plane. @param all their sum.
/// @param step that minimises the squares of them all. @param variance of the errors that it leaves [m^2].
ScoreScatter scatterOf(const BeamSums* begin, const BeamSums* end, const BeamSums& all, const Eigen::Vector3d& step,
                       double variance);

/// @brief What the regions of an image have in common: medians, which single ones that are no planes do not move.
struct CommonScatter {
  double inflation = 1.0;
  double growth = 1.0;  ///< of the inflation from parts to parts four times as large; 1 if it is no more than chance

  double whole() const { return inflation * growth; }
};

/// @param order working memory.
CommonScatter commonScatter(const std::vector<ScoreScatter>& regions, std::vector<std::pair<float, float>>& order);

/// @brief The inflation of a region, from its own scatter as far as that tells and from the common one, with the growth and
/// with what its inverse is too large by; in the coordinates of its own. Where errors are a line's, the common one is that
/// of wide regions and more than narrow ones have, which tell nothing themselves: they err on the safe side.
Eigen::Matrix3d inflationOf(const ScoreScatter& own, const CommonScatter& common);

}  // namespace ppc
