// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/moments.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>
#include <Eigen/QR>

namespace ppc {
namespace {

using testing_tools::Normal;

struct Point {
  Eigen::Vector3d p;
  double weight;
};

Moments sum(const std::vector<Point>& points) {
  Moments m;
  for (const Point& q : points) m.add(q.p.x(), q.p.y(), q.p.z(), q.weight);
  return m;
}

double misfit(const std::vector<Point>& points, const Eigen::Vector3d& a) {
  double chi2 = 0.0;
  for (const Point& q : points) chi2 += q.weight * std::pow(1.0 - a.dot(q.p), 2);
  return chi2;
}

// A bundle of `side` x `side` beams, 10 mrad apart, measured on the plane a . p = 1 with range noise sigma; w = (r /
// sigma)^2.
std::vector<Point> patch(const Eigen::Vector3d& a, double sigma, Normal& normal, double turn = 0.0, int side = 5) {
  std::vector<Point> points;
  for (int i = 0; i < side * side; ++i) {
    const Eigen::Vector3d u = Eigen::Vector3d(1.0, turn + 0.01 * (i % side), 0.01 * (i / side)).normalized();
    const double range = 1.0 / a.dot(u), error = sigma * normal();
    points.push_back({(range + error) * u, range * range / (sigma * sigma)});
  }
  return points;
}

TEST(Moments, SumsMatchHandComputedValues) {
  Moments m;
  m.add(1.0, 2.0, 3.0, 2.0);
  m.add(-1.0, 0.0, 4.0, 0.5);
  EXPECT_DOUBLE_EQ(m.xx, 2.5);
  EXPECT_DOUBLE_EQ(m.xy, 4.0);
  EXPECT_DOUBLE_EQ(m.xz, 4.0);
  EXPECT_DOUBLE_EQ(m.yy, 8.0);
  EXPECT_DOUBLE_EQ(m.yz, 12.0);
  EXPECT_DOUBLE_EQ(m.zz, 26.0);
  EXPECT_DOUBLE_EQ(m.w, 2.5);
  EXPECT_EQ(m.n, 2);
  EXPECT_TRUE(m.mean().isApprox(Eigen::Vector3d(0.6, 1.6, 3.2)));
  m.scale(2.0);
  EXPECT_DOUBLE_EQ(m.xx, 5.0);
  EXPECT_DOUBLE_EQ(m.z, 16.0);
  EXPECT_DOUBLE_EQ(m.w, 5.0);
  EXPECT_EQ(m.n, 2);
}

TEST(Moments, AddAndSubtract) {
  Moments a, b;
  a.add(1.0, 2.0, 3.0, 1.0);
  b.add(4.0, -1.0, 2.0, 3.0);
  const Moments both = a + b;
  EXPECT_DOUBLE_EQ(both.xy, 2.0 - 12.0);
  EXPECT_DOUBLE_EQ(both.w, 4.0);
  EXPECT_EQ(both.n, 2);
  Moments back = both;
  back -= b;
  EXPECT_DOUBLE_EQ(back.yz, a.yz);
  EXPECT_DOUBLE_EQ(back.x, a.x);
  EXPECT_EQ(back.n, 1);
}

TEST(FitPlane, RecoversPlanesWithoutNoiseAtEveryDistance) {
  for (const double d : {0.1, 0.3, 1.0, 3.0, 10.0, 30.0}) {
    const Eigen::Vector3d towards = Eigen::Vector3d(-1.0, 0.4, 0.2).normalized();
    Moments m;
    for (int i = 0; i < 25; ++i) {
      const Eigen::Vector3d u = Eigen::Vector3d(1.0, 0.005 * (i % 5), 0.005 * (i / 5)).normalized();
      const Eigen::Vector3d p = -d / towards.dot(u) * u;
      m.add(p.x(), p.y(), p.z(), p.squaredNorm());
    }
    const PlaneFit fit = fitPlane(m);
    EXPECT_NEAR(fit.distance(), d, 1e-5 * d);
    EXPECT_LT((fit.normal() - towards).norm(), 1e-4) << d;
    EXPECT_LT(fit.chi2, 1e-8 * m.w) << d;
  }
}

TEST(FitPlane, AgreesWithABruteForceSolution) {
  Normal normal(3);
  const std::vector<Point> points = patch({0.3, 0.05, -0.02}, 0.01, normal, 0.0, 12);
  Eigen::MatrixX3d rows(points.size(), 3);
  Eigen::VectorXd right(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    rows.row(static_cast<Eigen::Index>(i)) = std::sqrt(points[i].weight) * points[i].p.transpose();
    right[static_cast<Eigen::Index>(i)] = std::sqrt(points[i].weight);
  }
  const Eigen::Vector3d a = rows.colPivHouseholderQr().solve(right);
  const PlaneFit fit = fitPlane(sum(points));
  EXPECT_LT((fit.a - a).norm(), 1e-5 * a.norm());
  EXPECT_NEAR(fit.chi2, misfit(points, a), 1e-4 * fit.chi2);
}

TEST(FitPlane, ChiSquareOfASumIsThatOfAllPoints) {
  Normal normal(5);
  std::vector<Point> all = patch({0.3, 0.0, 0.0}, 0.01, normal);
  const Moments a = sum(all);
  const std::vector<Point> other = patch({0.31, 0.03, 0.0}, 0.01, normal, 0.05);
  all.insert(all.end(), other.begin(), other.end());
  const Moments b = sum(other);
  const PlaneFit joint = fitPlane(a + b);
  EXPECT_NEAR(joint.chi2, misfit(all, joint.a), 1e-5 * joint.chi2);
  EXPECT_GE(joint.chi2, fitPlane(a).chi2 + fitPlane(b).chi2);
  const Eigen::Vector3d elsewhere(0.29, 0.01, 0.02);
  EXPECT_NEAR(chiSquare(a + b, elsewhere), misfit(all, elsewhere), 1e-5 * misfit(all, elsewhere));
}

// White noise: n - 3 degrees of freedom, and 3 for the conditions that two patches lie on one plane.
TEST(FitPlane, WhiteNoiseIsChiSquareDistributed) {
  Normal normal(7);
  constexpr int kTrials = 3000;
  double per_freedom = 0.0, square = 0.0, excess = 0.0;
  for (int t = 0; t < kTrials; ++t) {
    const Moments a = sum(patch({0.33, 0.1, 0.0}, 0.01, normal));
    const Moments b = sum(patch({0.33, 0.1, 0.0}, 0.01, normal, 0.05));
    const double chi2 = fitPlane(a).chi2;
    per_freedom += chi2 / 22.0 / kTrials;
    square += chi2 * chi2 / kTrials;
    excess += (fitPlane(a + b).chi2 - chi2 - fitPlane(b).chi2) / kTrials;
  }
  EXPECT_NEAR(per_freedom, 1.0, 0.02);                                      // four standard deviations
  EXPECT_NEAR(square - std::pow(22.0 * per_freedom, 2), 44.0, 0.1 * 44.0);  // variance: twice the degrees of freedom
  EXPECT_NEAR(excess, 3.0, 0.15);
}

TEST(FitPlane, PointsThatDetermineNoPlaneGiveFiniteFits) {
  const std::vector<std::vector<Point>> cases{{{{3.0, 0.0, 0.0}, 1.0}},
                                              {{{3.0, 0.0, 0.0}, 1.0}, {{3.0, 0.1, 0.0}, 1.0}, {{3.0, 0.2, 0.0}, 1.0}},
                                              {{{0.0, 0.0, 2.0}, 1.0}}};
  for (const auto& points : cases) {
    const PlaneFit fit = fitPlane(sum(points));
    EXPECT_TRUE(fit.a.allFinite());
    EXPECT_NEAR(fit.a.norm(), 1.0 / points[0].p.norm(), 1e-3);  // the smallest solution: frontal
    EXPECT_LT(fit.chi2, 1e-6);
  }
  const PlaneFit none = fitPlane(Moments());
  EXPECT_TRUE(none.a.allFinite());
  EXPECT_EQ(none.chi2, 0.0);
}

}  // namespace
}  // namespace ppc
