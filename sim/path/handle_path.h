// The prescribed motion of the handles: C1 cubic interpolation of positions given at increasing times.
#ifndef CLOTHID_SIM_PATH_HANDLE_PATH_H_
#define CLOTHID_SIM_PATH_HANDLE_PATH_H_

#include <Eigen/Core>

namespace clothid {

// Piecewise cubic Hermite interpolation with slopes from the parabola through each knot and its neighbours, so a
// straight path at uneven times is reproduced exactly and a velocity never jumps (a piecewise linear path kicks the
// cloth at every knot). Before the first and after the last knot the path stands still. One knot: a fixed handle.
class HandlePath {
 public:
  HandlePath() = default;
  // times [T] s, strictly increasing; positions [3H x T] m, finite, as the slopes between them have to be. Throws
  // `Error` (kBadData) otherwise.
  HandlePath(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions);

  int num_handles() const { return static_cast<int>(positions_.rows() / 3); }
  const Eigen::VectorXd& times() const { return times_; }
  const Eigen::MatrixXd& positions() const { return positions_; }

  // [3H] m.
  Eigen::VectorXd At(double time) const;
  // Its derivative by time [3H] m/s, from the right where it jumps.
  Eigen::VectorXd RateAt(double time) const;
  // [T] w with At(time) = positions() w: what a change of the positions does; zero but at four knots.
  Eigen::VectorXd KnotWeights(double time) const;

 private:
  Eigen::VectorXd times_;
  Eigen::MatrixXd positions_;  // [3H x T]
  Eigen::MatrixXd slopes_;     // [3H x T] m/s
};

// Natural cubic smoothing spline through (times, rows of values), its weight chosen by generalised cross-validation
// (Craven and Wahba 1979), row by row, for noise and motion differ between directions: measured handle paths carry the
// noise of their sensor, and a simulated cloth is shaken by it. A path without noise is returned as it is, up to its
// curvature at the scale of one frame interval. times [T], values [R x T]; returns [R x T]. Fewer than five times:
// returned unchanged.
Eigen::MatrixXd SmoothPath(const Eigen::VectorXd& times, const Eigen::MatrixXd& values);

}  // namespace clothid

#endif  // CLOTHID_SIM_PATH_HANDLE_PATH_H_
