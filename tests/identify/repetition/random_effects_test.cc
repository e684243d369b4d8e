#include "identify/repetition/random_effects.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "identify/repetition/distributions.h"
#include "identify/uncertainty/uncertainty.h"
#include "tests/expect_error.h"

namespace clothid {
namespace {

RandomEffects Pool(const Eigen::VectorXd& y, const Eigen::VectorXd& s) {
  return PoolRepetitions(y, s, Eigen::VectorXd::Zero(y.size()));
}

struct Trials {
  Eigen::VectorXd log_ratios, deviations;
};

// Thirteen trials of a vaccine (Colditz et al. 1994; dat.bcg of the R package metafor): cases and others, of those
// treated and of the rest.
Trials Bcg() {
  Eigen::Matrix<double, 13, 4> counts;
  counts << 4, 119, 11, 128, 6, 300, 29, 274, 3, 228, 11, 209, 62, 13536, 248, 12619, 33, 5036, 47, 5761, 180, 1361,
      372, 1079, 8, 2537, 10, 619, 505, 87886, 499, 87892, 29, 7470, 45, 7232, 17, 1699, 65, 1600, 186, 50448, 141,
      27197, 5, 2493, 3, 2338, 27, 16886, 29, 17825;
  const Eigen::ArrayXd a = counts.col(0), c = counts.col(2);
  const Eigen::ArrayXd treated = a + counts.col(1).array(), rest = c + counts.col(3).array();
  return {(a / treated * rest / c).log(), (a.inverse() - treated.inverse() + c.inverse() - rest.inverse()).sqrt()};
}

TEST(RandomEffectsTest, GivesThePublishedNumbersOfThirteenTrials) {
  const Trials trials = Bcg();
  const RandomEffects result = Pool(trials.log_ratios, trials.deviations);
  EXPECT_NEAR(result.tau * result.tau, 0.313243258, 1e-7);  // metafor iterates to 1e-5
  EXPECT_NEAR(std::pow(result.tau_paule_mandel, 2), 0.3181, 5e-5);
  EXPECT_NEAR(result.q, 152.2330, 5e-5);
  EXPECT_LT(result.p_value, 1e-4);
  EXPECT_NEAR(std::pow(result.tau_lower95, 2), 0.1197, 5e-5);
  EXPECT_NEAR(std::pow(result.tau_upper95, 2), 1.1115, 5e-5);
  // Hartung and Knapp.
  EXPECT_NEAR(result.mean, -0.714532342, 1e-7);
  EXPECT_NEAR(result.mean - result.mean_half_width, -1.108443714, 1e-7);
  EXPECT_NEAR(result.mean + result.mean_half_width, -0.320620971, 1e-7);
  EXPECT_NEAR(1.0 - std::pow(result.typical_std / result.scatter(), 2), 0.9222, 5e-5);  // I^2
  EXPECT_TRUE(result.varies());
}

TEST(RandomEffectsTest, TauIsTheMaximumOfTheRestrictedLikelihood) {
  std::mt19937_64 generator(3);
  std::normal_distribution<double> normal;
  for (int set = 0; set < 20; ++set) {
    Eigen::VectorXd y(4), s(4);
    for (int r = 0; r < 4; ++r) {
      s[r] = 0.1 * std::exp(0.8 * normal(generator));
      y[r] = 0.15 * normal(generator) + s[r] * normal(generator);
    }
    // Restricted: the likelihood of the contrasts y_r - y_1, whose covariance is diagonal and a constant.
    const auto log_likelihood = [&](double tau2) {
      Eigen::MatrixXd covariance = Eigen::MatrixXd::Constant(3, 3, s[0] * s[0] + tau2);
      covariance.diagonal().array() += s.tail(3).array().square() + tau2;
      const Eigen::VectorXd contrasts = y.tail(3).array() - y[0];
      const Eigen::VectorXd solved = covariance.inverse() * contrasts;
      return -0.5 * std::log(covariance.determinant()) - 0.5 * contrasts.dot(solved);
    };
    double best = 0.0;
    constexpr double kStep = 2e-5;
    for (double tau2 = 0.0; tau2 < 1.0; tau2 += kStep) {
      if (log_likelihood(tau2) > log_likelihood(best)) best = tau2;
    }
    EXPECT_NEAR(std::pow(Pool(y, s).tau, 2), best, 1.5 * kStep) << set;
  }
}

TEST(RandomEffectsTest, IsClosedFormWhereAllDeviationsAreEqual) {
  const Eigen::Vector4d y(1.0, 1.3, 0.9, 1.6), s = Eigen::Vector4d::Constant(0.1);
  const double variance = (y.array() - y.mean()).square().sum() / 3.0;
  const RandomEffects result = Pool(y, s);
  EXPECT_NEAR(result.tau, std::sqrt(variance - 0.01), 1e-12);
  EXPECT_NEAR(result.tau_paule_mandel, result.tau, 1e-12);
  EXPECT_NEAR(result.scatter(), std::sqrt(variance), 1e-12);
  EXPECT_NEAR(result.typical_std, 0.1, 1e-12);
  EXPECT_NEAR(result.mean, y.mean(), 1e-12);
  EXPECT_NEAR(result.mean_half_width, 3.182446 * std::sqrt(variance / 4.0), 1e-6);
  EXPECT_NEAR(result.next_half_width, 4.302653 * std::sqrt(variance - 0.01 + variance / 4.0), 1e-6);
  EXPECT_NEAR(std::pow(result.tau_lower95, 2), std::max(0.0, 3.0 * variance / 9.348404 - 0.01), 1e-6);
  EXPECT_NEAR(std::pow(result.tau_upper95, 2), 3.0 * variance / 0.2157953 - 0.01, 1e-5);
}

TEST(RandomEffectsTest, InventsNoScatterWhereTheDeviationsExplainAll) {
  const Eigen::Vector4d y(1.0, 1.01, 0.99, 1.0), s = Eigen::Vector4d::Constant(0.1);
  const RandomEffects result = Pool(y, s);
  EXPECT_EQ(result.tau, 0.0);
  EXPECT_EQ(result.tau_paule_mandel, 0.0);
  EXPECT_EQ(result.tau_lower95, 0.0);
  EXPECT_FALSE(result.varies());
  // Never less than what the deviations leave, though the estimates are closer by chance.
  EXPECT_NEAR(result.mean_std, 0.05, 1e-12);
  for (const LeftOutEstimate& left_out : result.left_out) EXPECT_TRUE(left_out.fits);
}

TEST(RandomEffectsTest, PoolsEqualEstimates) {
  const RandomEffects result = Pool(Eigen::Vector3d::Constant(2.0), Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(result.tau, 0.0);
  EXPECT_EQ(result.tau_upper95, 0.0);
  EXPECT_NEAR(result.mean, 2.0, 1e-12);
  EXPECT_EQ(result.p_value, 1.0);
}

TEST(RandomEffectsTest, TwoRecordingsHaveNoNextSpecimen) {
  const RandomEffects result = Pool(Eigen::Vector2d(1.0, 2.0), Eigen::Vector2d(0.1, 0.1));
  EXPECT_NEAR(result.tau, std::sqrt(0.5 - 0.01), 1e-12);
  EXPECT_NEAR(result.mean_half_width, 12.706205 * 0.5, 1e-5);
  EXPECT_TRUE(std::isnan(result.next_half_width));
  EXPECT_TRUE(std::isnan(result.left_out[0].deviation));
  EXPECT_EQ(result.left_out[0].mean, 2.0);
  EXPECT_TRUE(result.varies());
}

TEST(RandomEffectsTest, OneRecordingIsItself) {
  const RandomEffects result = PoolRepetitions(Eigen::VectorXd::Constant(1, 3.0), Eigen::VectorXd::Constant(1, 0.2),
                                               Eigen::VectorXd::Constant(1, 0.1));
  EXPECT_EQ(result.mean, 3.0);
  EXPECT_EQ(result.mean_std, 0.2);
  EXPECT_EQ(result.common_error, 0.1);
  EXPECT_TRUE(std::isnan(result.tau));
  EXPECT_TRUE(std::isnan(result.mean_half_width));
  EXPECT_FALSE(result.varies());
}

TEST(RandomEffectsTest, ACommonErrorWidensWithoutScattering) {
  const Eigen::Vector4d y(1.0, 1.3, 0.9, 1.6), s(0.1, 0.2, 0.1, 0.3), b(0.4, 0.5, 0.6, 0.7);
  const RandomEffects without = Pool(y, s), with = PoolRepetitions(y, s, b);
  EXPECT_EQ(with.tau, without.tau);
  EXPECT_EQ(with.mean, without.mean);
  EXPECT_EQ(with.p_value, without.p_value);
  EXPECT_NEAR(with.common_error, without.weights.dot(b), 1e-15);
  const double common = kNormal95 * with.common_error;
  EXPECT_NEAR(with.mean_half_width, std::hypot(without.mean_half_width, common), 1e-12);
  EXPECT_NEAR(with.next_half_width, std::hypot(without.next_half_width, common), 1e-12);
}

TEST(RandomEffectsTest, LeavesEachOut) {
  Eigen::VectorXd y(6), s(6);
  y << 1.0, 1.05, 0.95, 1.02, 0.97, 2.0;
  s << 0.05, 0.05, 0.06, 0.05, 0.04, 0.05;
  const RandomEffects result = Pool(y, s), others = Pool(y.head(5), s.head(5));
  EXPECT_EQ(result.left_out[5].mean, others.mean);
  const double variance =
      others.tau * others.tau + 0.0025 + 1.0 / (s.head(5).array().square() + others.tau * others.tau).inverse().sum();
  EXPECT_NEAR(result.left_out[5].deviation, (2.0 - others.mean) / std::sqrt(variance), 1e-12);
  EXPECT_FALSE(result.left_out[5].fits);
  for (int r = 0; r < 5; ++r) EXPECT_TRUE(result.left_out[r].fits) << r;
}

TEST(RandomEffectsTest, DoesNotDependOnUnitAndOrigin) {
  const Eigen::Vector4d y(1.0, 1.3, 0.9, 1.6), s(0.1, 0.2, 0.1, 0.3), b(0.4, 0.5, 0.6, 0.7);
  const RandomEffects one = PoolRepetitions(y, s, b);
  const RandomEffects other = PoolRepetitions((1e-6 * y.array() + 2e-6).matrix(), 1e-6 * s, 1e-6 * b);
  EXPECT_NEAR(other.tau, 1e-6 * one.tau, 1e-15);
  EXPECT_NEAR(other.mean, 1e-6 * one.mean + 2e-6, 1e-15);
  EXPECT_NEAR(other.next_half_width, 1e-6 * one.next_half_width, 1e-14);
  EXPECT_NEAR(other.left_out[3].deviation, one.left_out[3].deviation, 1e-6);
}

TEST(RandomEffectsTest, RefusesWhatIsNoEstimate) {
  const Eigen::Vector2d one(1.0, 1.0);
  ExpectError([&] { PoolRepetitions(one, Eigen::Vector2d(1.0, 0.0), one); }, ErrorKind::kUsage,
              {"standard deviations > 0"});
  ExpectError([&] { PoolRepetitions(one, Eigen::Vector2d(1.0, NAN), one); }, ErrorKind::kUsage,
              {"standard deviations > 0"});
  ExpectError([&] { PoolRepetitions(one, one, Eigen::Vector2d(0.0, -1.0)); }, ErrorKind::kUsage,
              {"common errors >= 0"});
  ExpectError([&] { PoolRepetitions(one, Eigen::Vector3d::Ones(), one); }, ErrorKind::kUsage, {"of every recording"});
  ExpectError([&] { PoolRepetitions({}, {}, {}); }, ErrorKind::kUsage, {"of every recording"});
}

// How often what is said holds, over sets of recordings whose estimates scatter by `tau` and by their own `s`.
struct Coverage {
  int mean = 0, next = 0, tau = 0, varies = 0;
};

Coverage Simulate(int num_sets, int num_recordings, double tau, double s) {
  std::mt19937_64 generator(1);
  std::normal_distribution<double> normal;
  Coverage coverage;
  for (int set = 0; set < num_sets; ++set) {
    Eigen::VectorXd y(num_recordings);
    for (double& estimate : y) estimate = tau * normal(generator) + s * normal(generator);
    const RandomEffects result = Pool(y, Eigen::VectorXd::Constant(num_recordings, s));
    coverage.mean += std::abs(result.mean) <= result.mean_half_width;
    coverage.next += std::abs(tau * normal(generator) - result.mean) <= result.next_half_width;
    coverage.tau += result.tau_lower95 <= tau && tau <= result.tau_upper95;
    coverage.varies += result.varies();
  }
  return coverage;
}

TEST(RandomEffectsTest, FiveRecordingsThatScatterAreCovered) {
  const Coverage coverage = Simulate(4000, 5, 0.1, 0.02);
  EXPECT_NEAR(coverage.mean / 4000.0, 0.95, 0.012);
  EXPECT_NEAR(coverage.next / 4000.0, 0.95, 0.015);
  EXPECT_NEAR(coverage.tau / 4000.0, 0.95, 0.012);
  EXPECT_GE(coverage.varies / 4000.0, 0.97);
}

TEST(RandomEffectsTest, ScatterIsNotInvented) {
  const Coverage coverage = Simulate(4000, 5, 0.0, 0.02);
  EXPECT_NEAR(coverage.varies / 4000.0, 0.05, 0.012);
  EXPECT_NEAR(coverage.tau / 4000.0, 0.975, 0.01);  // the lower end is 0 in all but one of forty
  EXPECT_GE(coverage.mean / 4000.0, 0.95);
}

}  // namespace
}  // namespace clothid
