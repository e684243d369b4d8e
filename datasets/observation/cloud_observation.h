// Points that are compared with the predicted surface, not with a point of it: residuals of one frame and their
// derivatives. They are those of unordered clouds, and tracked points that are not material (`PointKind`): grid points
// of every frame, say, which slide over the cloth from one to the next.
//
// A row per measured point: d/sigma, d the signed distance to the predicted cloth
// (datasets/observation/cloth_surface.h), which says what it cannot see. Noise may carry a point kBorderAllowance sigma
// beyond the border of the cloth. A point of the border has two rows: d/sigma, in which that noise may be any, and
// u/sigma, its signed distance along the cloth to the border.
// A loss takes every row for a point.
#ifndef CLOTHID_DATASETS_OBSERVATION_CLOUD_OBSERVATION_H_
#define CLOTHID_DATASETS_OBSERVATION_CLOUD_OBSERVATION_H_

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "datasets/observation/cloth_surface.h"

namespace clothid {

inline constexpr double kBorderAllowance = 3.0;  // in sigma
// A point farther from the predicted surface than this, in sigma, counts as far in reports. Fits weigh it as their loss
// has it.
inline constexpr double kFarFromSurface = 5.0;

// A measured point of a frame.
struct SeenSurfacePoint {
  Eigen::Vector3d position;  // m
  double sigma = 0.0;        // m
  bool is_border = false;
  int tracked = -1;  // which of the tracked points; -1: a point of a cloud
};

// The rows of one frame, linearized: residual + sum_k gradient(:, k) . dx[nodes[k]]. Distances are over sigma here.
using CloudRows = std::vector<SurfaceDistance>;

// How far points of the surface are from a prediction; the errors of several recordings add up.
struct CloudError {
  double squared_distance = 0.0;  // m^2, of d, summed over the points
  double num_points = 0.0;
  double squared_border = 0.0;  // m^2, of u, summed over the points of the border
  double num_border = 0.0;
  double squared_node = 0.0;  // m^2: of tracked points to where they would be if they were material
  double num_tracked = 0.0;
  double num_far = 0.0;              // farther than kFarFromSurface
  double successive_products = 0.0;  // m^2, see PredictionError: of the mean distance of the points near a node
  double successive_squares = 0.0;
  double num_successive = 0.0;  // of means that were compared so

  double rmse() const;         // m: root mean square distance of points to the surface
  double border_rmse() const;  // m: of points of the border to the border; NaN without any
  double node_rmse() const;    // m: of tracked points to the places of their nodes; NaN without any
  CloudError& operator+=(const CloudError& other);
};

class CloudObservation {
 public:
  // Of the clouds and the seen points of `motion` that are not material, but for those in `is_held` [P]. Empty where
  // all are. `cloud_sigma` m, > 0 where there are clouds; `sigma` [P] m, > 0. Keeps no reference. Throws `Error`
  // (kBadData), naming the recording, for points of the border of a cloth that has none.
  CloudObservation(const RecordedMotion& motion, double cloud_sigma, const Eigen::VectorXd& sigma,
                   const std::vector<bool>& is_held);

  bool empty() const { return points_.empty(); }
  double cloud_sigma() const { return cloud_sigma_; }  // m
  // The points of a frame: first those of its cloud, then the tracked ones.
  const std::vector<SeenSurfacePoint>& points(int frame) const { return points_[static_cast<std::size_t>(frame)]; }
  int num_rows(int frame) const { return empty() ? 0 : static_cast<int>(row_points_[frame].size()); }
  // The point of a row, and whether the row is u.
  const SeenSurfacePoint& point(int frame, int row) const { return points(frame)[row_points_[frame][row].first]; }
  bool is_border_row(int frame, int row) const { return row_points_[frame][row].second; }

  // Of the frame's rows, in their order, where the nodes stand at `nodes` [3N] m.
  CloudRows Linearize(int frame, const Eigen::VectorXd& nodes) const;
  // Only the residuals.
  Eigen::VectorXd Residuals(int frame, const Eigen::VectorXd& nodes) const;
  // How the points of the frame lie from the nearest points of the cloth, those of the border from the border.
  std::vector<SurfaceOffset> Offsets(int frame, const Eigen::VectorXd& nodes) const;
  // The points of the surface that are nearest to those of the frame [3 x M], m.
  Eigen::Matrix3Xd ClosestPoints(int frame, const Eigen::VectorXd& nodes) const;
  // `tracked` [3P x T] and `nodes` [3N x T]: the two parts of a prediction (datasets/observation/observation.h).
  CloudError Compare(const Eigen::MatrixXd& tracked, const Eigen::MatrixXd& nodes) const;

 private:
  void AddPoint(const SeenSurfacePoint& point, int frame);

  std::vector<std::vector<SeenSurfacePoint>> points_;          // [T] or empty
  std::vector<std::vector<std::pair<int, bool>>> row_points_;  // likewise
  double cloud_sigma_ = 0.0;
  ClothTopology topology_;
};

}  // namespace clothid

#endif  // CLOTHID_DATASETS_OBSERVATION_CLOUD_OBSERVATION_H_
