#include "identify/repetition/random_effects.h"

#include <algorithm>
#include <cmath>

#include "identify/repetition/distributions.h"
#include "identify/repetition/monotone_root.h"
#include "identify/uncertainty/uncertainty.h"
#include "sim/base/error.h"

namespace clothid {
namespace {

constexpr double kOutside = 0.05;  // of intervals and tests

// The estimates, and what follows from a tau^2.
class Estimates {
 public:
  Estimates(const Eigen::VectorXd& y, const Eigen::VectorXd& s) : y_(y), squared_(s.array().square()) {}

  Eigen::Index size() const { return y_.size(); }
  Eigen::VectorXd Weights(double tau2) const { return (squared_.array() + tau2).inverse(); }
  double Mean(double tau2) const { return Weights(tau2).dot(y_) / Weights(tau2).sum(); }

  // sum w_r (y_r - m)^2
  double Q(double tau2) const { return Weights(tau2).dot(SquaredDistances(tau2)); }

  // The restricted log-likelihood, and twice its derivative by tau^2.
  double LogLikelihood(double tau2) const {
    const Eigen::VectorXd w = Weights(tau2);
    return 0.5 * (w.array().log().sum() - std::log(w.sum()) - Q(tau2));
  }
  double Score(double tau2) const {
    const Eigen::VectorXd w = Weights(tau2);
    return w.cwiseAbs2().dot(SquaredDistances(tau2)) - w.sum() + w.squaredNorm() / w.sum();
  }

  // Beyond it Score and Q - (R - 1) are negative: w_r <= 1/tau^2, W - sum w_r^2/W >= (R - 1) min w_r.
  double LargestTau2() const {
    double tau2 = squared_.maxCoeff() + (y_.array() - y_.mean()).square().sum();
    while (Score(tau2) > 0.0 || Q(tau2) > static_cast<double>(size() - 1)) tau2 *= 2.0;
    return tau2;
  }

 private:
  Eigen::VectorXd SquaredDistances(double tau2) const { return (y_.array() - Mean(tau2)).square(); }

  Eigen::VectorXd y_, squared_;
};

// The likelihood may have more than one maximum: every descending zero of the score between steps of a factor, and 0.
double RestrictedTau2(const Estimates& estimates) {
  constexpr int kSteps = 120;
  constexpr double kFactor = 1.25;
  const double largest = estimates.LargestTau2();
  double best = 0.0, best_likelihood = estimates.LogLikelihood(0.0), below = 0.0;
  for (int step = kSteps; step >= 0; --step) {
    const double above = largest / std::pow(kFactor, step);
    if (estimates.Score(below) > 0.0 && estimates.Score(above) <= 0.0) {
      const double root = MonotoneRoot([&](double tau2) { return estimates.Score(tau2); }, below, above);
      const double likelihood = estimates.LogLikelihood(root);
      if (likelihood > best_likelihood) {
        best = root;
        best_likelihood = likelihood;
      }
    }
    below = above;
  }
  return best;
}

// The tau^2 at which Q falls to where `excess` of it is zero; 0 where it is there already.
template <typename Excess>
double Tau2OfQ(const Estimates& estimates, const Excess& excess) {
  const auto at = [&](double tau2) { return excess(estimates.Q(tau2)); };
  if (!(at(0.0) > 0.0)) return 0.0;
  double high = estimates.LargestTau2();
  while (at(high) > 0.0) high *= 2.0;
  return MonotoneRoot(at, 0.0, high);
}

void SetScatter(const Estimates& estimates, RandomEffects* result) {
  const auto degrees = static_cast<int>(estimates.size() - 1);
  const auto tau_above = [&](double share) {
    return std::sqrt(Tau2OfQ(estimates, [&](double q) { return share - ChiSquareAbove(q, degrees); }));
  };
  result->tau = std::sqrt(RestrictedTau2(estimates));
  result->tau_lower95 = tau_above(0.5 * kOutside);
  result->tau_upper95 = tau_above(1.0 - 0.5 * kOutside);
  result->tau_paule_mandel = std::sqrt(Tau2OfQ(estimates, [&](double q) { return q - degrees; }));
  result->q = estimates.Q(0.0);
  result->p_value = ChiSquareAbove(result->q, degrees);
  const Eigen::VectorXd w = estimates.Weights(0.0);
  result->typical_std = std::sqrt(degrees * w.sum() / (w.sum() * w.sum() - w.squaredNorm()));
}

void SetIntervals(const Estimates& estimates, RandomEffects* result) {
  const auto num = static_cast<int>(estimates.size());
  const double tau2 = result->tau * result->tau;
  const double excess = std::max(1.0, estimates.Q(tau2) / (num - 1));
  result->mean_std = std::sqrt(excess / estimates.Weights(tau2).sum());
  const double common = kNormal95 * result->common_error;
  result->mean_half_width = std::hypot(StudentHalfWidth95(num - 1) * result->mean_std, common);
  if (num < 3) return;
  result->next_half_width = std::hypot(StudentHalfWidth95(num - 2) * std::hypot(result->tau, result->mean_std), common);
}

Eigen::VectorXd Without(const Eigen::VectorXd& values, Eigen::Index index) {
  Eigen::VectorXd others(values.size() - 1);
  others << values.head(index), values.tail(values.size() - 1 - index);
  return others;
}

LeftOutEstimate LeaveOut(const Eigen::VectorXd& y, const Eigen::VectorXd& s, Eigen::Index index) {
  const auto num = static_cast<int>(y.size());
  const Estimates others(Without(y, index), Without(s, index));
  const double tau2 = num > 2 ? RestrictedTau2(others) : 0.0;
  LeftOutEstimate left_out;
  left_out.mean = others.Mean(tau2);
  if (num < 3) return left_out;
  const double variance = tau2 + s[index] * s[index] + 1.0 / others.Weights(tau2).sum();
  left_out.deviation = (y[index] - left_out.mean) / std::sqrt(variance);
  left_out.fits = StudentTwoSided(left_out.deviation, num - 2) >= kOutside / num;
  return left_out;
}

void Validate(const Eigen::VectorXd& y, const Eigen::VectorXd& s, const Eigen::VectorXd& b) {
  ExpectUsage(y.size() > 0 && s.size() == y.size() && b.size() == y.size(),
              "repetitions: expected an estimate, a standard deviation and a common error of every recording");
  ExpectUsage(y.allFinite() && s.allFinite() && s.minCoeff() > 0.0, "repetitions: expected standard deviations > 0");
  ExpectUsage(b.allFinite() && b.minCoeff() >= 0.0, "repetitions: expected common errors >= 0");
}

}  // namespace

double RandomEffects::scatter() const { return std::hypot(tau, typical_std); }

RandomEffects PoolRepetitions(const Eigen::VectorXd& estimates, const Eigen::VectorXd& deviations,
                              const Eigen::VectorXd& common_errors) {
  Validate(estimates, deviations, common_errors);
  const Estimates all(estimates, deviations);
  RandomEffects result;
  if (all.size() > 1) SetScatter(all, &result);
  const double tau2 = all.size() > 1 ? result.tau * result.tau : 0.0;
  const Eigen::VectorXd w = all.Weights(tau2);
  result.mean = all.Mean(tau2);
  result.weights = w / w.sum();
  result.common_error = result.weights.dot(common_errors);
  if (all.size() == 1) {
    result.mean_std = result.typical_std = deviations[0];
    result.left_out.resize(1);
    return result;
  }
  SetIntervals(all, &result);
  for (Eigen::Index r = 0; r < all.size(); ++r) result.left_out.push_back(LeaveOut(estimates, deviations, r));
  return result;
}

}  // namespace clothid
