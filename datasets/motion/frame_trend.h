// Where the points of a recording are at its first frame, and how fast, as its first frames together tell it.
//
// Over the first K frames every point follows, with tau = t - t_0,
//   x   or   x + a tau^2   or   x + v tau   or   x + v tau + a tau^2,
// fitted by least squares with weights 1/(1 + r^2/9), r the distance in standard deviations, from a least median of
// squares (Rousseeuw 1984), so that a frame that has jumped does not count. One of the four and K = 3, 5 or 8 hold for
// the whole recording: of the K at which the last of them (for K = 3: x + v tau) leaves no more over than at the
// others, and of the trends whose missing coefficients would take no more away than chance, the pair that leaves x the
// least variance. Chance: two standard deviations of a sum of squares over all points. A trend that misses a motion
// that one could see is worse than noise: it moves all nodes the same way, and a fit takes that for a property of the
// cloth. Where every K leaves more than 2.5 sigma^2 over, or a quarter of the points off, the first frame stands for
// itself.
#ifndef CLOTHID_DATASETS_MOTION_FRAME_TREND_H_
#define CLOTHID_DATASETS_MOTION_FRAME_TREND_H_

#include <Eigen/Core>

namespace clothid {

struct FrameTrend {
  Eigen::MatrixXd positions;           // [3 x P] m; NaN: not seen often enough
  Eigen::VectorXd position_variances;  // [P] of a coordinate, m^2
  // Empty unless the fitted trend has a velocity and all velocities together are more than noise (their sum of squares
  // in standard deviations is four of its own standard deviations above what noise gives).
  Eigen::MatrixXd velocities;          // [3 x P] m/s; NaN: not seen often enough
  Eigen::VectorXd velocity_variances;  // [P] m^2/s^2
  int num_frames = 1;                  // K
};

// times [T] s; positions [3P x T] m, NaN: not seen; sigma [P] m.
FrameTrend FitFrameTrend(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions, const Eigen::VectorXd& sigma);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_MOTION_FRAME_TREND_H_
