#include "identify/uncertainty/model_error_estimate.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "identify/uncertainty/uncertainty.h"

namespace clothid {
namespace {

constexpr int kMostScorings = 50, kMostSweeps = 100, kMostHalvings = 20;
constexpr double kHighestCorrelation = 0.97;  // no recording is long enough to tell more
// Rows of a frame that err alike where the model does; of fewer rows than that it is seen from frame to frame alone.
constexpr double kLeastAlike = 4.0, kFewRows = 36.0;
constexpr double kGone = 0.05;          // of a squared correlation
constexpr double kBeyondChance = 4.0;   // standard deviations
constexpr double kSteadyGain = 1e-9;    // of -2 log L
constexpr double kSteadySweep = 1e-10;  // of a step, relative to the largest variance

// Rows of one kind, and the hat functions of all knots but the first over the squares of their sigmas.
class ErrorLikelihood {
 public:
  ErrorLikelihood(const ErrorRows& rows, const ErrorCurve& knots, double degrees_of_freedom) {
    const auto num = static_cast<Eigen::Index>(rows.sums().size());
    hats_.resize(num, knots.times.size() - 1);
    counts_.resize(num);
    squares_.resize(num);
    Eigen::Index i = 0;
    for (const auto& [key, sum] : rows.sums()) {
      const auto& [time, sigma] = key;
      hats_.row(i) = knots.SharesAt(time).tail(hats_.cols()).transpose() / (sigma * sigma);
      counts_[i] = degrees_of_freedom * sum.count;
      squares_[i++] = sum.squares;
    }
  }

  Eigen::Index num_knots() const { return hats_.cols(); }

  // -2 log L at c.
  double At(const Eigen::VectorXd& c) const {
    const Eigen::ArrayXd v = Variances(c);
    return (counts_ * v.log() + squares_ / v).sum();
  }

  // Its gradient and the expectation of its second derivative.
  void Derive(const Eigen::VectorXd& c, Eigen::VectorXd* gradient, Eigen::MatrixXd* information) const {
    const Eigen::ArrayXd v = Variances(c);
    *gradient = hats_.transpose() * (counts_ / v - squares_ / v.square()).matrix();
    *information = hats_.transpose() * (counts_ / v.square()).matrix().asDiagonal() * hats_;
  }

 private:
  Eigen::ArrayXd Variances(const Eigen::VectorXd& c) const { return 1.0 + (hats_ * c).array(); }

  Eigen::MatrixXd hats_;             // [s x K - 1], s the sums of rows
  Eigen::ArrayXd counts_, squares_;  // [s] h times their rows; of e_i^2
};

// The step d >= -c at which  gradient . d + 1/2 d . information d  is least, coordinate by coordinate.
Eigen::VectorXd BoundedStep(const Eigen::VectorXd& c, const Eigen::VectorXd& gradient,
                            const Eigen::MatrixXd& information) {
  Eigen::VectorXd step = Eigen::VectorXd::Zero(c.size()), slope = gradient;
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    double moved = 0.0;
    for (Eigen::Index k = 0; k < c.size(); ++k) {
      if (!(information(k, k) > 0.0)) continue;
      const double change = std::max(-slope[k] / information(k, k), -c[k] - step[k]);
      step[k] += change;
      slope += change * information.col(k);
      moved = std::max(moved, std::abs(change));
    }
    if (moved <= kSteadySweep * (c + step).maxCoeff()) break;
  }
  return step;
}

// Where the likelihood is largest.
Eigen::VectorXd LikeliestVariances(const ErrorLikelihood& likelihood) {
  Eigen::VectorXd c = Eigen::VectorXd::Zero(likelihood.num_knots()), gradient;
  Eigen::MatrixXd information;
  double value = likelihood.At(c);
  for (int scoring = 0; scoring < kMostScorings; ++scoring) {
    likelihood.Derive(c, &gradient, &information);
    const Eigen::VectorXd step = BoundedStep(c, gradient, information);
    double share = 1.0, next = likelihood.At(c + step);
    for (int halving = 0; halving < kMostHalvings && !(next <= value); ++halving) {
      share *= 0.5;
      next = likelihood.At(c + share * step);
    }
    if (!(next <= value)) break;
    c += share * step;
    const bool is_steady = value - next <= kSteadyGain * std::abs(value);
    value = next;
    if (is_steady) break;
  }
  return c;
}

// G, or of ones the numbers of rows that two frames have in common [T x T].
struct FrameProducts {
  Eigen::MatrixXd products, counts;
  Eigen::VectorXd errors;  // S

  explicit FrameProducts(const Eigen::MatrixXd& frames) {
    const Eigen::MatrixXd seen = (frames.array() == frames.array()).cast<double>();
    const Eigen::MatrixXd values = seen.cwiseEqual(1.0).select(frames, 0.0);
    products = values.transpose() * values;
    counts = seen.transpose() * seen;
    errors = (products.diagonal() - counts.diagonal()).cwiseMax(0.0);
  }

  // c.
  double Correlation() const {
    double along = 0.0, size = 0.0;
    for (Eigen::Index t = 0; t + 1 < errors.size(); ++t) {
      along += products(t, t + 1);
      size += std::sqrt(errors[t] * errors[t + 1]);
    }
    return size > 0.0 ? std::clamp(along / size, 0.0, kHighestCorrelation) : 0.0;
  }

  // 1/N, at most 1; 0 where the products are as large as chance makes those of noise. Of frames so far apart that the
  // correlation between them is gone, if there are any: how it falls is known about its start alone.
  double Alikeness(double correlation) const {
    const double few = std::log(kGone) / (2.0 * std::log(std::max(correlation, kGone)));
    const auto last = errors.size() - 1;
    const auto apart =
        std::clamp(static_cast<Eigen::Index>(std::ceil(few)), Eigen::Index{1}, std::max<Eigen::Index>(last, 1));
    double measured = 0.0, variance = 0.0, size = 0.0, lasting = 0.0;
    for (Eigen::Index t = 0; t < errors.size(); ++t) {
      for (Eigen::Index u = 0; u + apart <= t; ++u) {
        if (!(counts(t, u) > 0.0)) continue;
        const double pair = errors[t] * errors[u], noise = products(t, t) * products(u, u) / counts(t, u);
        measured += std::pow(products(t, u), 2) - errors[t] - errors[u] - counts(t, u);
        variance += 2.0 * noise * noise;
        size += pair;
        lasting += pair * std::pow(correlation, 2.0 * static_cast<double>(t - u));
      }
    }
    if (!(measured - lasting > kBeyondChance * std::sqrt(variance))) return 0.0;
    return size > lasting ? std::clamp((measured - lasting) / (size - lasting), 0.0, 1.0) : 0.0;
  }
};

}  // namespace

double NumAlike(const Eigen::MatrixXd& frames, bool is_absorbed) {
  const FrameProducts products(frames);
  const double correlation = products.Correlation(), num_rows = products.counts.diagonal().mean();
  double alike = num_rows * products.Alikeness(correlation);
  const bool is_of_model = num_rows < kFewRows ? correlation > kCorrelatedResiduals : alike > kLeastAlike;
  if (!is_of_model) return 1.0;
  if (is_absorbed) alike = num_rows / 3.0;
  const double lasts = std::min<double>(static_cast<double>(frames.cols()), (1.0 + correlation) / (1.0 - correlation));
  return std::max(1.0, alike) * lasts;
}

void ErrorRows::Add(double time, double sigma, double square) {
  Sum& sum = sums_[{time, sigma}];
  sum.count += 1.0;
  sum.squares += square;
}

ErrorCurve EstimateErrorCurve(const ErrorRows& rows, double start, double degrees_of_freedom) {
  std::set<double> distinct;
  for (const auto& [key, sum] : rows.sums()) distinct.insert(key.first);
  const auto num_knots = std::min<Eigen::Index>(kMostErrorKnots, static_cast<Eigen::Index>(distinct.size()) / 2);
  if (num_knots < 1 || !(*distinct.rbegin() > start) || !(degrees_of_freedom > 0.0)) return {};
  ErrorCurve curve;
  const Eigen::ArrayXd shares = Eigen::ArrayXd::LinSpaced(num_knots + 1, 0.0, 1.0).square();
  curve.times = start + (*distinct.rbegin() - start) * shares;
  const ErrorLikelihood likelihood(rows, curve, degrees_of_freedom);
  const Eigen::VectorXd c = LikeliestVariances(likelihood);
  const double gain = likelihood.At(Eigen::VectorXd::Zero(c.size())) - likelihood.At(c);
  if (!(gain > kLeastGain)) return {};
  curve.variances.resize(num_knots + 1);
  curve.variances << 0.0, c;
  return curve;
}

}  // namespace clothid
