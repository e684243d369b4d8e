// Unordered point clouds against a predicted surface: residuals of one frame and their derivatives.
//
// A row per measured point: d/sigma, d the signed distance to the predicted cloth
// (datasets/observation/cloth_surface.h), which says what it cannot see. Noise may carry a point kBorderAllowance sigma
// beyond the border of the cloth.
#ifndef CLOTHID_DATASETS_OBSERVATION_CLOUD_OBSERVATION_H_
#define CLOTHID_DATASETS_OBSERVATION_CLOUD_OBSERVATION_H_

#include <Eigen/Core>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "datasets/observation/cloth_surface.h"

namespace clothid {

inline constexpr double kBorderAllowance = 3.0;  // in sigma
// A point farther from the predicted surface than this, in sigma, counts as far in reports. Fits weigh it as their loss
// has it.
inline constexpr double kFarFromSurface = 5.0;

// The rows of one frame, linearized: residual + sum_k gradient(:, k) . dx[nodes[k]]. Distances are over sigma here.
using CloudRows = std::vector<SurfaceDistance>;

// How far clouds are from a prediction; those of several recordings add up.
struct CloudError {
  double squared_distance = 0.0;  // m^2, summed over the points
  double num_points = 0.0;
  double num_far = 0.0;              // farther than kFarFromSurface
  double successive_products = 0.0;  // m^2, see PredictionError: of the mean distance of the points near a node
  double successive_squares = 0.0;

  double rmse() const;  // m: root mean square distance of points to the surface
  CloudError& operator+=(const CloudError& other);
};

class CloudObservation {
 public:
  // Without clouds in `motion` it is empty. `sigma` m, > 0. Keeps no reference to `motion`.
  CloudObservation(const RecordedMotion& motion, double sigma);

  bool empty() const { return clouds_.empty(); }
  double sigma() const { return sigma_; }  // m
  int num_points(int frame) const { return empty() ? 0 : static_cast<int>(clouds_[frame].cols()); }

  // Of the frame's points, in their order, where the nodes stand at `nodes` [3N] m.
  CloudRows Linearize(int frame, const Eigen::VectorXd& nodes) const;
  // Only the residuals.
  Eigen::VectorXd Residuals(int frame, const Eigen::VectorXd& nodes) const;
  // The points of the surface that are nearest to those of the frame [3 x M], m.
  Eigen::Matrix3Xd ClosestPoints(int frame, const Eigen::VectorXd& nodes) const;
  // `nodes` [3N x T]: of every frame.
  CloudError Compare(const Eigen::MatrixXd& nodes) const;

 private:
  std::vector<Eigen::Matrix3Xd> clouds_;  // [T] or empty
  double sigma_ = 0.0;
  ClothTopology topology_;
};

}  // namespace clothid

#endif  // CLOTHID_DATASETS_OBSERVATION_CLOUD_OBSERVATION_H_
