// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/score_scatter.h"

#include "patch_plane_clustering/core/weighted_median.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

namespace ppc {
namespace {

constexpr int kWide = 4;  // parts
constexpr double kLeastFreedom = 4.0, kTellingFreedom = 10.0;
constexpr double kPriorFreedom = 8.0;  // of errors that are independent, and of what regions have in common
constexpr double kLeastGrowth = 1.3;

// Scatter of scores in coordinates in which the equations are the identity.
class Scatter {
 public:
  void add(const Eigen::Vector3d& score, const Eigen::Matrix3d& equations) {
    scores_ += score * score.transpose();
    const double squares = (equations * equations).trace() / 3.0;
    expected_ += equations.trace() / 3.0 - squares;
    shares_ += squares;
  }

  double freedom() const { return shares_ > 0.0 ? std::max(0.0, 1.0 / shares_ - 1.0) : 0.0; }
  Eigen::Matrix3d over(double variance) const { return scores_ / (variance * expected_); }
  bool tells() const { return freedom() >= kLeastFreedom && expected_ > 0.0; }

 private:
  Eigen::Matrix3d scores_ = Eigen::Matrix3d::Zero();
  double expected_ = 0.0, shares_ = 0.0;
};

double meanOf(const ScoreScatter& scatter) { return scatter.inflation.trace() / 3.0; }

}  // namespace

ScoreScatter scatterOf(const BeamSums* begin, const BeamSums* end, const BeamSums& all, const Eigen::Vector3d& step,
                       double variance) {
  ScoreScatter result;
  if (static_cast<double>(end - begin) <= kLeastFreedom) return result;
  const Eigen::LLT<Eigen::Matrix3d> root(equationsOf(all));
  if (root.info() != Eigen::Success || !(variance > 0.0)) return result;
  const Eigen::Matrix3d to_unit = root.matrixL().solve(Eigen::Matrix3d::Identity());
  Scatter parts, wide;
  Eigen::Vector3d wide_score = Eigen::Vector3d::Zero();
  Eigen::Matrix3d wide_equations = Eigen::Matrix3d::Zero();
  for (const BeamSums* part = begin; part != end; ++part) {
    const Eigen::Matrix3d equations = equationsOf(*part);
    const Eigen::Vector3d score = to_unit * (rightOf(*part) - equations * step);
    const Eigen::Matrix3d unit = to_unit * equations * to_unit.transpose();
    parts.add(score, unit);
    wide_score += score;
    wide_equations += unit;
    if ((part - begin) % kWide == kWide - 1 || part + 1 == end) {
      wide.add(wide_score, wide_equations);
      wide_score.setZero();
      wide_equations.setZero();
    }
  }
  if (parts.tells()) {
    result.inflation = parts.over(variance);
    result.freedom = parts.freedom();
  }
  if (wide.tells()) {
    result.wide_inflation = wide.over(variance).trace() / 3.0;
    result.wide_freedom = wide.freedom();
  }
  return result;
}

CommonScatter commonScatter(const std::vector<ScoreScatter>& regions, std::vector<std::pair<float, float>>& order) {
  CommonScatter common;
  const auto medianOf = [&](auto&& value, auto&& weight) {
    order.assign(1, {1.0F, static_cast<float>(kPriorFreedom)});
    for (const ScoreScatter& region : regions) {
      if (weight(region) > 0.0) order.emplace_back(static_cast<float>(value(region)), static_cast<float>(weight(region)));
    }
    return static_cast<double>(weightedMedian(order));
  };
  common.inflation =
      medianOf(meanOf, [](const ScoreScatter& region) { return region.freedom >= kTellingFreedom ? region.freedom : 0.0; });
  const double growth = medianOf([](const ScoreScatter& region) { return region.wide_inflation / meanOf(region); },
                                 [](const ScoreScatter& region) { return region.wide_freedom; });
  if (growth > kLeastGrowth) common.growth = growth;
  return common;
}

Eigen::Matrix3d inflationOf(const ScoreScatter& own, const CommonScatter& common) {
  const double freedom = kPriorFreedom + own.freedom;
  const Eigen::Matrix3d mean =
      (kPriorFreedom * common.inflation * Eigen::Matrix3d::Identity() + own.freedom * own.inflation) / freedom;
  // As far as it is an estimate, its inverse is too large on average: that of three parameters by freedom / (freedom - 4).
  const double too_large = 1.0 + 4.0 * own.freedom / (freedom * (freedom - 4.0));
  return common.growth * too_large * mean;
}

}  // namespace ppc
