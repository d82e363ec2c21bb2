// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/quadratic_fit.h"

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace ppc {
namespace {

// A group of noisy samples of z = 0.05 s^2 + 0.03 s t - 0.1 t^2 in a frame turned against the axes, about a plane of its
// own.
struct Group {
  SurfaceSamples samples;
  std::vector<float> columns;  // of the samples
  std::vector<Eigen::Vector3d> points;
  std::vector<double> weights;
};

const Eigen::Matrix3d kFrame = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
const Eigen::Vector3d kOrigin(3.0, -1.0, 0.5);

Group makeGroup(unsigned seed, int n, double s0, double t0, double width) {
  Group group;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> inside(-0.5 * width, 0.5 * width), weight(5e3, 2e4);
  std::normal_distribution<double> noise(0.0, 0.01);
  const auto surface = [](double s, double t) { return 0.05 * s * s + 0.03 * s * t - 0.1 * t * t; };
  SurfaceSamples& samples = group.samples;
  samples.center = kOrigin + kFrame * Eigen::Vector3d(s0, t0, surface(s0, t0));
  samples.normal = kFrame * Eigen::Vector3d(-0.1 * s0 - 0.03 * t0, 0.2 * t0 - 0.03 * s0, 1.0).normalized();
  const auto size = static_cast<std::size_t>((n + 3) / 4 * 4);
  group.columns.resize(SurfaceSamples::kColumns * size);
  samples.place(group.columns.data(), size);
  for (int i = 0; i < static_cast<int>(size); ++i) {
    const double s = s0 + inside(random), t = t0 + inside(random);
    const Eigen::Vector3d p = kOrigin + kFrame * Eigen::Vector3d(s, t, surface(s, t) + noise(random)) - samples.center;
    samples.x[i] = static_cast<float>(p.x());
    samples.y[i] = static_cast<float>(p.y());
    samples.z[i] = static_cast<float>(p.z());
    samples.height[i] = static_cast<float>(samples.normal.dot(p));
    samples.weight[i] = i < n ? static_cast<float>(weight(random)) : 0.0F;
    if (i >= n) continue;
    ++samples.used;
    group.points.push_back(samples.center + p);
    group.weights.push_back(samples.weight[i]);
  }
  return group;
}

struct Reference {
  double chi2 = 0.0;
  Eigen::VectorXd coefficients;
};

// Weighted least squares of the first `terms` terms, row by row.
Reference solvePlainly(const std::vector<const Group*>& groups, const Eigen::Vector3d& origin, int terms) {
  std::vector<Eigen::VectorXd> rows;
  std::vector<double> heights;
  for (const Group* group : groups) {
    for (std::size_t i = 0; i < group->points.size(); ++i) {
      const Eigen::Vector3d p = kFrame.transpose() * (group->points[i] - origin);
      Eigen::Matrix<double, 6, 1> row;
      row << 1.0, p.x(), p.y(), p.x() * p.x(), p.x() * p.y(), p.y() * p.y();
      const double root = std::sqrt(group->weights[i]);
      rows.push_back(root * row.head(terms));
      heights.push_back(root * p.z());
    }
  }
  Eigen::MatrixXd a(rows.size(), terms);
  for (std::size_t i = 0; i < rows.size(); ++i) a.row(static_cast<Eigen::Index>(i)) = rows[i];
  const Eigen::VectorXd b = Eigen::Map<const Eigen::VectorXd>(heights.data(), a.rows());
  Reference reference;
  reference.coefficients = a.colPivHouseholderQr().solve(b);
  reference.chi2 = (a * reference.coefficients - b).squaredNorm();
  return reference;
}

void expectAsPlainly(const QuadraticFit& fit, const std::vector<const Group*>& groups, const Eigen::Vector3d& origin) {
  const Reference plane = solvePlainly(groups, origin, 3), quadratic = solvePlainly(groups, origin, 6);
  EXPECT_NEAR(fit.plane_chi2, plane.chi2, 1e-5 * plane.chi2);
  EXPECT_NEAR(fit.quadratic_chi2, quadratic.chi2, 1e-5 * plane.chi2);
  EXPECT_NEAR(fit.hessian(0, 0), 2.0 * quadratic.coefficients[3], 1e-4);
  EXPECT_NEAR(fit.hessian(0, 1), quadratic.coefficients[4], 1e-4);
  EXPECT_NEAR(fit.hessian(1, 1), 2.0 * quadratic.coefficients[5], 1e-4);
  double weight = 0.0;
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Group* group : groups) {
    for (std::size_t i = 0; i < group->points.size(); ++i) {
      const Eigen::Vector2d p = (kFrame.transpose() * (group->points[i] - origin)).head<2>();
      weight += group->weights[i];
      scatter += group->weights[i] * p * p.transpose();
    }
  }
  EXPECT_NEAR(fit.weight, weight, 1e-6 * weight);
  EXPECT_LT((fit.scatter - scatter / weight).norm(), 1e-5 * fit.scatter.norm());
}

TEST(QuadraticFit, OneGroupIsFittedAsRowByRow) {
  for (const int n : {6, 7, 63, 64, 65, 500}) {
    SCOPED_TRACE(n);
    const Group group = makeGroup(static_cast<unsigned>(n), n, 0.0, 0.0, 2.0);
    const QuadraticFit fit = fitQuadratic(sumQuadratic(group.samples, kFrame.col(0), kFrame.col(1)));
    expectAsPlainly(fit, {&group}, group.samples.center);
    EXPECT_LE(fit.quadratic_chi2, fit.plane_chi2);
  }
}

// The sums of groups on planes of their own, moved to one origin and one base, add.
TEST(QuadraticFit, GroupsTogetherAreFittedAsRowByRow) {
  const Group large = makeGroup(1, 800, -0.7, 0.3, 2.0), small = makeGroup(2, 90, 1.6, 0.8, 0.3);
  const Eigen::Vector3d s = kFrame.col(0), t = kFrame.col(1);
  QuadraticSums both = sumQuadraticAbout(kOrigin, large.samples, s, t);
  expectAsPlainly(fitQuadratic(both), {&large}, kOrigin);
  both += sumQuadraticAbout(kOrigin, small.samples, s, t);
  EXPECT_EQ(both.used, 890);
  expectAsPlainly(fitQuadratic(both), {&large, &small}, kOrigin);
}

// What the best surface leaves of some of the samples is no more than what it leaves of all.
TEST(QuadraticFit, SomeOfTheSamplesLeaveNoMoreThanAll) {
  const Eigen::Vector3d s = kFrame.col(0), t = kFrame.col(1);
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Group a = makeGroup(seed, 700, -0.7, 0.3, 2.0), b = makeGroup(seed + 100, 300, 1.6, 0.8, 0.5);
    const auto left = [&](int of_groups) {
      QuadraticSums both = sumQuadraticAbout(kOrigin, a.samples, s, t, of_groups);
      return fitQuadratic(both += sumQuadraticAbout(kOrigin, b.samples, s, t, of_groups));
    };
    const QuadraticFit all = left(1), some = left(8);
    EXPECT_LT(some.quadratic_chi2, all.quadratic_chi2);
    EXPECT_GT(some.quadratic_chi2, 0.03 * all.quadratic_chi2);
    EXPECT_NEAR(some.weight, all.weight / 8.0, 0.05 * all.weight);
  }
}

TEST(QuadraticFit, TooFewSamplesGiveNone) {
  const Group few = makeGroup(3, 5, 0.0, 0.0, 1.0), one_place = makeGroup(4, 20, 0.0, 0.0, 0.0);
  for (const Group* group : {&few, &one_place}) {
    const SurfaceSamples& samples = group->samples;
    if (group == &one_place) std::fill_n(samples.x, 3 * samples.size, 0.0F);  // y and z follow
    const QuadraticFit fit = fitQuadratic(sumQuadratic(samples, kFrame.col(0), kFrame.col(1)));
    EXPECT_EQ(fit.weight, 0.0);
    EXPECT_EQ(fit.plane_chi2, 0.0);
    EXPECT_EQ(fit.hessian.norm(), 0.0);
  }
}

}  // namespace
}  // namespace ppc
