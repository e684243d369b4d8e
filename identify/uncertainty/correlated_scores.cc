#include "identify/uncertainty/correlated_scores.h"

#include <algorithm>
#include <cmath>

namespace clothid {
namespace {

// Lags whose correlation prewhitening may have left.
constexpr Eigen::Index kLags = 2;
constexpr double kFewestDegreesOfFreedom = 2.0;

constexpr double kChance = 4.0;    // standard deviations of a sum of squares
constexpr double kMaterial = 0.5;  // of a variance: a quarter of an interval

Eigen::Index NumFrames(const FrameSeries& series) {
  Eigen::Index count = 0;
  for (const Eigen::MatrixXd& recording : series) count += recording.cols();
  return count;
}

Eigen::Index NumParameters(const FrameSeries& series) { return series.empty() ? 0 : series.front().rows(); }

void AddBartlettSum(const Eigen::MatrixXd& z, Eigen::MatrixXd* sum) {
  *sum += z * z.transpose();
  for (Eigen::Index lag = 1; lag <= std::min(kLags, z.cols() - 1); ++lag) {
    const double weight = 1.0 - static_cast<double>(lag) / (kLags + 1.0);
    const Eigen::MatrixXd products = z.rightCols(z.cols() - lag) * z.leftCols(z.cols() - lag).transpose();
    *sum += weight * (products + products.transpose());
  }
}

}  // namespace

FrameSeries WithoutEmptyFrames(const FrameSeries& scores) {
  FrameSeries result;
  for (const Eigen::MatrixXd& recording : scores) {
    std::vector<Eigen::Index> frames;
    for (Eigen::Index i = 0; i < recording.cols(); ++i) {
      if ((recording.col(i).array() != 0.0).any()) frames.push_back(i);
    }
    result.push_back(recording(Eigen::all, frames));
  }
  return result;
}

Eigen::MatrixXd CovarianceOfSum(const FrameSeries& influences, double autocorrelation) {
  const Eigen::Index num_parameters = NumParameters(influences);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(num_parameters, num_parameters);
  const auto frames = static_cast<double>(NumFrames(influences));
  const double left = frames - static_cast<double>(influences.size()),
               free = frames - static_cast<double>(num_parameters);
  if (!(left > 0.0 && free > 0.0)) return sum;
  for (const Eigen::MatrixXd& u : influences) {
    if (u.cols() < 2) continue;
    const Eigen::Index count = u.cols() - 1;
    AddBartlettSum(u.rightCols(count) - autocorrelation * u.leftCols(count), &sum);
  }
  return sum / std::pow(1.0 - autocorrelation, 2) * (frames / left) * (frames / free);
}

bool IsCorrelatedWithinFrames(const FrameSeries& influences, const Eigen::VectorXd& independent) {
  const Eigen::Index num_parameters = NumParameters(influences);
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(num_parameters), fourths = squares;
  for (const Eigen::MatrixXd& u : influences) {
    squares += u.array().square().rowwise().sum().matrix();
    fourths += u.array().pow(4).rowwise().sum().matrix();
  }
  for (Eigen::Index i = 0; i < num_parameters; ++i) {
    const double excess = squares[i] / independent[i] - 1.0;
    const double num_telling = 3.0 * squares[i] * squares[i] / fourths[i];
    if (excess > kMaterial && excess > kChance * std::sqrt(2.0 / num_telling)) return true;
  }
  return false;
}

double ScoreDegreesOfFreedom(const FrameSeries& influences, double autocorrelation) {
  const auto frames = static_cast<double>(NumFrames(influences));
  const double independent = frames * (1.0 - autocorrelation) / (1.0 + autocorrelation);
  return std::max(kFewestDegreesOfFreedom, independent - static_cast<double>(NumParameters(influences)));
}

double Student95(double degrees_of_freedom) {
  constexpr double kOutside = 0.05, kHalfPi = 1.5707963267948966, kNormal = -1.959963984540054;
  const double n = degrees_of_freedom;
  if (n <= kFewestDegreesOfFreedom) return std::sqrt(2.0 / (kOutside * (2.0 - kOutside)) - 2.0);
  const double a = 1.0 / (n - 0.5), b = 48.0 / (a * a);
  double c = ((20700.0 * a / b - 98.0) * a - 16.0) * a + 96.36;
  const double d = ((94.5 / (b + c) - 3.0) / b + 1.0) * std::sqrt(a * kHalfPi) * n;
  double y = std::pow(d * kOutside, 2.0 / n);
  if (y > 0.05 + a) {
    const double x = kNormal;
    y = x * x;
    if (n < 5.0) c += 0.3 * (n - 4.5) * (x + 0.6);
    c = (((0.05 * d * x - 5.0) * x - 7.0) * x - 2.0) * x + b + c;
    y = (((((0.4 * y + 6.3) * y + 36.0) * y + 94.5) / c - y - 3.0) / b + 1.0) * x;
    y = std::expm1(a * y * y);
  } else {
    y = ((1.0 / (((n + 6.0) / (n * y) - 0.089 * d - 0.822) * (n + 2.0) * 3.0) + 0.5 / (n + 4.0)) * y - 1.0) *
            (n + 1.0) / (n + 2.0) +
        1.0 / y;
  }
  return std::sqrt(n * y);
}

}  // namespace clothid
