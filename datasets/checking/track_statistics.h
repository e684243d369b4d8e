// Robust statistics of points over time: the numbers behind datasets/checking/motion_check.h.
#ifndef CLOTHID_DATASETS_CHECKING_TRACK_STATISTICS_H_
#define CLOTHID_DATASETS_CHECKING_TRACK_STATISTICS_H_

#include <Eigen/Core>
#include <cmath>
#include <utility>
#include <vector>

#include "sim/base/median.h"

namespace clothid {

// An interval between frames is a gap where it exceeds the median by this factor: one frame that was dropped makes an
// interval of twice the usual length.
inline constexpr double kGapFactor = 2.0;

// Noise of the measured positions, from third differences in time: of four successive frames the combination
// sum_i w_i x(t_i), w_i = 1/prod_{j != i} (t_i - t_j), vanishes for motion of constant acceleration; scaled to
// sum w_i^2 = 1 it has the variance of the noise. The median of its size is not moved by jumps. What changes its
// acceleration within four frames counts as noise, so that this is an upper bound.
struct NoiseEstimate {
  Eigen::Vector3d sigma = Eigen::Vector3d::Zero();  // m, along the directions
  Eigen::Matrix3d directions = Eigen::Matrix3d::Identity();
  bool is_known = false;  // false: too few frames in succession

  double rms() const { return sigma.norm() / std::sqrt(3.0); }  // m: of a coordinate
};
// times [T] s, positions [3P x T] m, NaN: not seen.
NoiseEstimate EstimateNoise(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions);

// Two points that are neighbours on the cloth.
struct PointPair {
  int first = 0, second = 0;
  double rest_length = 0.0;  // m
};

// The length of every pair in every frame over its length at rest [pairs x T]; NaN where one of them is not seen.
Eigen::MatrixXd LengthRatios(const std::vector<PointPair>& pairs, const Eigen::MatrixXd& positions);

// Frames into which the cloth as a whole jumps: the median step of its points is more than four times that of the
// frames around it, and more than `floor` m. Steps over gaps count as at the usual frame rate.
std::vector<int> ClothJumps(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions, double floor);

// Places (frame, point) at which a point leaves its path for one frame and returns: it is off the line between the
// frames before and after by more than `floor` m and by more than six times what it and its cloth are otherwise. In the
// first and the last frame, which have no such line, that of the frame beside them tells: it is off by half as much.
std::vector<std::pair<int, int>> PointJumps(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions,
                                            double floor);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CHECKING_TRACK_STATISTICS_H_
