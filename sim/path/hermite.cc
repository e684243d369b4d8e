#include "sim/path/hermite.h"

#include <algorithm>

namespace clothid {
namespace {

// Slope of the straight piece from knot i to knot i + 1.
Eigen::VectorXd Secant(const Eigen::VectorXd& times, const Eigen::MatrixXd& values, Eigen::Index i) {
  return (values.col(i + 1) - values.col(i)) / (times[i + 1] - times[i]);
}

// With what a curve between two knots is made of: the rise between them and both slopes times the interval.
Eigen::VectorXd Combine(const Eigen::MatrixXd& values, const Eigen::MatrixXd& slopes, Eigen::Index i, double interval,
                        const Eigen::Vector3d& weights) {
  return weights[0] * (values.col(i + 1) - values.col(i)) +
         interval * (weights[1] * slopes.col(i) + weights[2] * slopes.col(i + 1));
}

bool IsBetweenKnots(const Eigen::VectorXd& times, Eigen::Index i) { return i >= 0 && i + 1 < times.size(); }

}  // namespace

HermiteWeights::HermiteWeights(const Eigen::VectorXd& times, double time) {
  const Eigen::Index i = IntervalAt(times, time);
  first = second = std::max<Eigen::Index>(i, 0);
  if (!IsBetweenKnots(times, i)) return;
  second = i + 1;
  const double interval = times[second] - times[first], s = (time - times[first]) / interval;
  const Eigen::Vector3d scale(1.0, interval, interval);
  value = scale.cwiseProduct(Eigen::Vector3d(s * s * (3.0 - 2.0 * s), s * (1.0 - s) * (1.0 - s), -s * s * (1.0 - s)));
  rate = scale.cwiseProduct(Eigen::Vector3d(6.0 * s * (1.0 - s), (1.0 - s) * (1.0 - 3.0 * s), s * (3.0 * s - 2.0))) /
         interval;
  acceleration =
      scale.cwiseProduct(Eigen::Vector3d(6.0 - 12.0 * s, 6.0 * s - 4.0, 6.0 * s - 2.0)) / (interval * interval);
}

Eigen::Index IntervalAt(const Eigen::VectorXd& times, double time) {
  return std::upper_bound(times.begin(), times.end(), time) - times.begin() - 1;
}

Eigen::MatrixXd ParabolaSlopes(const Eigen::VectorXd& times, const Eigen::MatrixXd& values) {
  const Eigen::Index count = times.size();
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(values.rows(), count);
  if (count == 1) return slopes;
  if (count == 2) {
    slopes.colwise() = Secant(times, values, 0);
    return slopes;
  }
  for (Eigen::Index i = 1; i + 1 < count; ++i) {
    const Eigen::VectorXd before = Secant(times, values, i - 1);
    const Eigen::VectorXd bend = Secant(times, values, i) - before;
    const double before_share = (times[i] - times[i - 1]) / (times[i + 1] - times[i - 1]);
    slopes.col(i) = before + before_share * bend;
    if (i == 1) slopes.col(0) = before - before_share * bend;
    if (i + 2 == count) slopes.col(count - 1) = before + (1.0 + before_share) * bend;
  }
  return slopes;
}

Eigen::VectorXd HermiteValue(const Eigen::VectorXd& times, const Eigen::MatrixXd& values, const Eigen::MatrixXd& slopes,
                             double time) {
  const Eigen::Index last = times.size() - 1;
  if (last < 0) return {};
  if (!(time > times[0])) return values.col(0);
  if (time >= times[last]) return values.col(last);
  const Eigen::Index i = IntervalAt(times, time);
  const double interval = times[i + 1] - times[i];
  const double s = (time - times[i]) / interval;
  // The Hermite polynomials on [0, 1], written around the first knot so that a path that rests is exactly constant.
  const double rise = s * s * (3.0 - 2.0 * s);
  const double slope_first = s * (1.0 - s) * (1.0 - s);
  const double slope_second = -s * s * (1.0 - s);
  return values.col(i) + rise * (values.col(i + 1) - values.col(i)) +
         interval * (slope_first * slopes.col(i) + slope_second * slopes.col(i + 1));
}

Eigen::VectorXd HermiteRate(const Eigen::VectorXd& times, const Eigen::MatrixXd& values, const Eigen::MatrixXd& slopes,
                            double time) {
  const Eigen::Index i = IntervalAt(times, time);
  if (!IsBetweenKnots(times, i)) return Eigen::VectorXd::Zero(values.rows());
  const double interval = times[i + 1] - times[i];
  const double s = (time - times[i]) / interval;
  const Eigen::Vector3d weights(6.0 * s * (1.0 - s), (1.0 - s) * (1.0 - 3.0 * s), s * (3.0 * s - 2.0));
  return Combine(values, slopes, i, interval, weights) / interval;
}

Eigen::VectorXd HermiteAcceleration(const Eigen::VectorXd& times, const Eigen::MatrixXd& values,
                                    const Eigen::MatrixXd& slopes, double time) {
  const Eigen::Index i = IntervalAt(times, time);
  if (!IsBetweenKnots(times, i)) return Eigen::VectorXd::Zero(values.rows());
  const double interval = times[i + 1] - times[i];
  const double s = (time - times[i]) / interval;
  const Eigen::Vector3d weights(6.0 - 12.0 * s, 6.0 * s - 4.0, 6.0 * s - 2.0);
  return Combine(values, slopes, i, interval, weights) / (interval * interval);
}

}  // namespace clothid
