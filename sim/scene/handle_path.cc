#include "sim/scene/handle_path.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "sim/base/error.h"

namespace clothid {
namespace {

[[noreturn]] void Fail(const std::string& message) { throw Error(ErrorKind::kBadData, "handle path: " + message); }

void ValidateKnots(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions) {
  if (times.size() == 0 || positions.cols() != times.size() || positions.rows() % 3 != 0) {
    Fail("expected one position of every handle at each of " + std::to_string(times.size()) + " times");
  }
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    if (!std::isfinite(times[i]) || (i > 0 && !(times[i] > times[i - 1]))) {
      Fail("time " + std::to_string(i) + " is not a finite number above the time before it");
    }
    if (!positions.col(i).allFinite()) Fail("the position at time " + std::to_string(i) + " is not finite");
  }
}

// Slope of the straight piece from knot i to knot i + 1.
Eigen::VectorXd Secant(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions, Eigen::Index i) {
  return (positions.col(i + 1) - positions.col(i)) / (times[i + 1] - times[i]);
}

// Of the parabola through three neighbouring knots, at the first, the middle or the last of them.
Eigen::MatrixXd ParabolaSlopes(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions) {
  const Eigen::Index count = times.size();
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(positions.rows(), count);
  if (count == 1) return slopes;
  if (count == 2) {
    slopes.colwise() = Secant(times, positions, 0);
    return slopes;
  }
  for (Eigen::Index i = 1; i + 1 < count; ++i) {
    const Eigen::VectorXd before = Secant(times, positions, i - 1);
    const Eigen::VectorXd bend = Secant(times, positions, i) - before;
    const double before_share = (times[i] - times[i - 1]) / (times[i + 1] - times[i - 1]);
    slopes.col(i) = before + before_share * bend;
    if (i == 1) slopes.col(0) = before - before_share * bend;
    if (i + 2 == count) slopes.col(count - 1) = before + (1.0 + before_share) * bend;
  }
  return slopes;
}

// Rows of `values` with their slopes at the knots, at a time.
Eigen::VectorXd Interpolate(const Eigen::VectorXd& times, const Eigen::MatrixXd& values, const Eigen::MatrixXd& slopes,
                            double time) {
  const Eigen::Index last = times.size() - 1;
  if (last < 0) return {};
  if (!(time > times[0])) return values.col(0);
  if (time >= times[last]) return values.col(last);
  const Eigen::Index i = std::upper_bound(times.begin(), times.end(), time) - times.begin() - 1;
  const double interval = times[i + 1] - times[i];
  const double s = (time - times[i]) / interval;
  // The Hermite polynomials on [0, 1], written around the first knot so that a path that rests is exactly constant.
  const double rise = s * s * (3.0 - 2.0 * s);
  const double slope_first = s * (1.0 - s) * (1.0 - s);
  const double slope_second = -s * s * (1.0 - s);
  return values.col(i) + rise * (values.col(i + 1) - values.col(i)) +
         interval * (slope_first * slopes.col(i) + slope_second * slopes.col(i + 1));
}

}  // namespace

HandlePath::HandlePath(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions)
    : times_(times), positions_(positions) {
  ValidateKnots(times_, positions_);
  slopes_ = ParabolaSlopes(times_, positions_);
  if (!slopes_.allFinite()) Fail("expected velocities that are finite numbers");
}

Eigen::VectorXd HandlePath::At(double time) const { return Interpolate(times_, positions_, slopes_, time); }

// Slopes are linear in positions, and so is what lies between two knots.
Eigen::VectorXd HandlePath::KnotWeights(double time) const {
  const Eigen::MatrixXd knots = Eigen::MatrixXd::Identity(times_.size(), times_.size());
  return Interpolate(times_, knots, ParabolaSlopes(times_, knots), time);
}

}  // namespace clothid
