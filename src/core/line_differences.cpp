// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/line_differences.h"

#include <Eigen/SparseCholesky>
#include <algorithm>

namespace ppc {
namespace {

constexpr int kRounds = 5;       // of weighing anew
constexpr double kRobust = 3.0;  // a difference off by so many standard deviations counts half

}  // namespace

std::vector<double> solveDifferences(const std::vector<LineDifference>& differences, int count, double error, bool robust) {
  Eigen::VectorXd solved = Eigen::VectorXd::Zero(count);
  for (int round = 0; round < (robust ? kRounds : 1); ++round) {
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(static_cast<std::size_t>(count) + 9 * differences.size());
    Eigen::VectorXd right = Eigen::VectorXd::Zero(count);
    for (int k = 0; k < count; ++k) entries.emplace_back(k, k, 1.0 / std::max(1e-12, error * error));
    for (const LineDifference& d : differences) {
      const double rest =
          solved[d.line] - d.before * solved[d.line - d.reach] - d.after * solved[d.line + d.reach] - d.value;
      const double trust = round > 0 ? 1.0 / (1.0 + rest * rest / (kRobust * kRobust * d.variance)) : 1.0;
      const double weight = trust / d.variance;
      const double factors[3] = {-d.before, 1.0, -d.after};
      for (int i = 0; i < 3; ++i) {
        right[d.line + (i - 1) * d.reach] += weight * factors[i] * d.value;
        for (int j = 0; j < 3; ++j) {
          entries.emplace_back(d.line + (i - 1) * d.reach, d.line + (j - 1) * d.reach, weight * factors[i] * factors[j]);
        }
      }
    }
    Eigen::SparseMatrix<double> normal(count, count);
    normal.setFromTriplets(entries.begin(), entries.end());
    solved = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(normal).solve(right);
  }
  return {solved.data(), solved.data() + count};
}

}  // namespace ppc
