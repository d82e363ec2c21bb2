// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/score_scatter.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <utility>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr int kPoints = 20;  // of a part

// Sums of a part, points of which lie along b; a tells the part.
BeamSums partOf(double a, const std::vector<double>& errors) {
  BeamSums sums;
  for (int i = 0; i < kPoints; ++i) {
    const double b = (i + 0.5) / kPoints - 0.5;
    sums.w += 1.0;
    sums.wa += a;
    sums.wb += b;
    sums.waa += a * a;
    sums.wab += a * b;
    sums.wbb += b * b;
    sums.wh += errors[i];
    sums.wha += errors[i] * a;
    sums.whb += errors[i] * b;
    sums.whh += errors[i] * errors[i];
    ++sums.kept;
  }
  return sums;
}

// @param of makes the errors of a part.
ScoreScatter scatterOfParts(int parts, const std::function<std::vector<double>(int part)>& of) {
  std::vector<BeamSums> sums;
  BeamSums all;
  for (int k = 0; k < parts; ++k) {
    sums.push_back(partOf((k + 0.5) / parts - 0.5, of(k)));
    all += sums.back();
  }
  const auto step = stepOf(all);
  EXPECT_TRUE(step);
  return scatterOf(sums.data(), sums.data() + parts, all, step->x, (all.whh - step->gain) / (all.kept - 3));
}

std::vector<double> white(Normal& normal) {
  std::vector<double> errors(kPoints);
  for (double& error : errors) error = normal();
  return errors;
}

// The mean of many scatters.
ScoreScatter meanScatter(int parts, int runs, const std::function<std::vector<double>(int part, Normal& normal)>& of) {
  Normal normal(5);
  ScoreScatter mean;
  mean.inflation.setZero();
  mean.wide_inflation = 0.0;
  for (int run = 0; run < runs; ++run) {
    const ScoreScatter one = scatterOfParts(parts, [&](int part) { return of(part, normal); });
    mean.inflation += one.inflation / runs;
    mean.wide_inflation += one.wide_inflation / runs;
    mean.freedom = one.freedom;
    mean.wide_freedom = one.wide_freedom;
  }
  return mean;
}

TEST(ScoreScatter, IsThatOfIndependentErrorsForWhiteOnes) {
  for (const int parts : {10, 40}) {
    const ScoreScatter mean = meanScatter(parts, 2000, [](int, Normal& normal) { return white(normal); });
    EXPECT_NEAR(mean.inflation.trace() / 3.0, 1.0, 0.03) << parts;
    EXPECT_LT((mean.inflation - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 0.2) << parts;
    EXPECT_GT(mean.freedom, 0.4 * parts);
    EXPECT_LT(mean.freedom, 0.9 * parts);
    EXPECT_EQ(mean.wide_freedom > 0.0, parts == 40);
    EXPECT_NEAR(mean.wide_inflation, 1.0, 0.05) << parts;
  }
}

// Errors that a part shares move the plane along the normal and turn it from part to part, not across the parts.
TEST(ScoreScatter, TellsWhichWayErrorsGoTogether) {
  constexpr double kShared = 0.5;  // of the variance
  const ScoreScatter mean = meanScatter(40, 500, [](int, Normal& normal) {
    const double shared = std::sqrt(kShared) * normal();
    std::vector<double> errors = white(normal);
    for (double& error : errors) error = std::sqrt(1.0 - kShared) * error + shared;
    return errors;
  });
  // A = diag(waa, wbb, w) here: coordinates are a, b and the offset themselves.
  const double expected = 1.0 - kShared + kShared * kPoints;
  EXPECT_NEAR(mean.inflation(0, 0), expected, 0.15 * expected);
  EXPECT_NEAR(mean.inflation(1, 1), 1.0 - kShared, 0.15);
  EXPECT_NEAR(mean.inflation(2, 2), expected, 0.15 * expected);
}

TEST(ScoreScatter, GrowsWhereErrorsGoTogetherBeyondAPart) {
  std::vector<double> last(kPoints);
  const ScoreScatter mean = meanScatter(48, 500, [&last](int part, Normal& normal) {
    if (part % 4 == 0) last = white(normal);  // four parts have the same
    return last;
  });
  EXPECT_NEAR(mean.inflation.trace() / 3.0, 1.0, 0.2);
  EXPECT_NEAR(mean.wide_inflation, 4.0, 0.8);
}

TEST(ScoreScatter, FewPartsTellNothing) {
  Normal normal(2);
  for (const int parts : {1, 2, 5}) {
    const ScoreScatter scatter = scatterOfParts(parts, [&](int) { return white(normal); });
    EXPECT_EQ(scatter.inflation, Eigen::Matrix3d::Identity()) << parts;
    EXPECT_EQ(scatter.freedom, 0.0) << parts;
    EXPECT_EQ(inflationOf(scatter, CommonScatter()), Eigen::Matrix3d::Identity()) << parts;
  }
  const ScoreScatter exact = scatterOfParts(30, [](int) { return std::vector<double>(kPoints, 0.0); });
  EXPECT_EQ(exact.freedom, 0.0);
}

ScoreScatter known(double inflation, double freedom, double wide_inflation = 1.0, double wide_freedom = 0.0) {
  return {inflation * Eigen::Matrix3d::Identity(), freedom, wide_inflation, wide_freedom};
}

TEST(CommonScatter, SingleRegionsDoNotMoveIt) {
  std::vector<std::pair<float, float>> order;
  EXPECT_EQ(commonScatter({}, order).whole(), 1.0);
  EXPECT_EQ(commonScatter({known(50.0, 9.0)}, order).whole(), 1.0);  // tells too little
  EXPECT_EQ(commonScatter({known(3.0, 20.0), known(3.2, 20.0), known(1000.0, 40.0), known(2.8, 20.0)}, order).inflation,
            static_cast<double>(3.2F));
}

TEST(CommonScatter, GrowsBeyondChanceOnly) {
  std::vector<std::pair<float, float>> order;
  for (const double growth : {0.8, 1.2, 2.0}) {
    const std::vector<ScoreScatter> regions(5, known(2.0, 30.0, 2.0 * growth, 7.0));
    const CommonScatter common = commonScatter(regions, order);
    EXPECT_NEAR(common.growth, growth > 1.3 ? growth : 1.0, 1e-6);
    EXPECT_NEAR(common.whole(), common.growth * 2.0, 1e-6);
  }
}

TEST(ScoreScatter, ARegionThatTellsMuchIsTakenByItsOwn) {
  const CommonScatter common{3.0, 1.0};
  EXPECT_NEAR(inflationOf(known(1.0, 0.0), common)(0, 0), 3.0, 1e-12);
  const double some = inflationOf(known(6.0, 8.0), common)(1, 1), much = inflationOf(known(6.0, 1000.0), common)(2, 2);
  EXPECT_NEAR(some, 4.5 * (1.0 + 4.0 * 8.0 / (16.0 * 12.0)), 1e-12);
  EXPECT_NEAR(much, 6.0, 0.05);
  EXPECT_NEAR(inflationOf(known(6.0, 1000.0), {3.0, 2.0})(0, 0), 2.0 * much, 1e-9);
}

}  // namespace
}  // namespace ppc
