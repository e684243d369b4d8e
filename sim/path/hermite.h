// Piecewise cubic Hermite interpolation with a continuous slope.
#ifndef CLOTHID_SIM_PATH_HERMITE_H_
#define CLOTHID_SIM_PATH_HERMITE_H_

#include <Eigen/Core>

namespace clothid {

// The interval of increasing `times` [T] that holds `time`: the index of its first knot, -1 before the first knot, T -
// 1 from the last one on. A knot belongs to the interval that it begins.
Eigen::Index IntervalAt(const Eigen::VectorXd& times, double time);

// Slopes of rows of `values` [R x T] at their knots, per s: of the parabola through a knot and its two neighbours, at
// the first and the last knot that of the next one. So a straight line at uneven times is met exactly. [R x T].
Eigen::MatrixXd ParabolaSlopes(const Eigen::VectorXd& times, const Eigen::MatrixXd& values);

// The curves with those values and slopes at the knots, at a time [R], constant before the first and after the last
// knot; none without a knot.
Eigen::VectorXd HermiteValue(const Eigen::VectorXd& times, const Eigen::MatrixXd& values, const Eigen::MatrixXd& slopes,
                             double time);

// The same curves, many at a time: what their values and derivatives are combined of at `time`. Of one with the values
// a and b and the slopes p and q at the ends of the interval, any of them is
//   w_0 (b - a) + w_1 p + w_2 q,   the value: a plus that.
struct HermiteWeights {
  Eigen::Index first = 0, second = 0;  // knots; the same where the curves stand still: all weights are zero
  Eigen::Vector3d value = Eigen::Vector3d::Zero(), rate = value, acceleration = value;

  HermiteWeights(const Eigen::VectorXd& times, double time);
};

// Likewise their derivatives by time, from the right where they jump: the first, /s, and the second, /s^2.
Eigen::VectorXd HermiteRate(const Eigen::VectorXd& times, const Eigen::MatrixXd& values, const Eigen::MatrixXd& slopes,
                            double time);
Eigen::VectorXd HermiteAcceleration(const Eigen::VectorXd& times, const Eigen::MatrixXd& values,
                                    const Eigen::MatrixXd& slopes, double time);

}  // namespace clothid

#endif  // CLOTHID_SIM_PATH_HERMITE_H_
