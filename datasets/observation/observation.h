// From a trajectory to predicted points at the recorded times, and to residuals. The way back, the transpose, is
// datasets/observation/residual_derivative.h.
//
// Tracked points are a linear map P x of the trajectory:
//   predicted_p(t_i) = sum_k w_k x(t_i)[node_k]
// for a point p (a node, or a barycentric point), with the state x(t_i) of datasets/observation/frame_stencil.h. A
// residual is (predicted - measured)/sigma for every seen coordinate. Not seen: a coordinate that was not measured
// (NaN). Without a residual: a point all of whose nodes are handles, whose motion is part of the scene.
//
// Where the recording does not know its sigma, every coordinate has sigma = 1e-3 of the cloth's size (the square root
// of its rest area): costs are then free of scale, and say nothing about likelihood.
//
// A recording may have point clouds, too, or alone, and points that are not material (`PointKind`). Their residuals are
// distances to the predicted surface (datasets/observation/cloud_observation.h), a nonlinear function of all nodes at
// the recorded time, which are interpolated as the points are. A prediction then has two parts, rows 0 .. 3P - 1: the
// points, as if all were material; the 3N rows below them: the nodes. With material points alone it has the first.
//
// Below, clouds are all points that are compared with the surface.
//
// Where a model is known to err, rows count for less (datasets/observation/model_error.h): residuals stay over sigma,
// and who adds them up takes `error_weights`, as costs do.
//
// Forces that were measured at handles (datasets/observation/force_observation.h) have predictions of their own, [3G x
// F] N, at times of their own; their rows of the residual come after all others.
#ifndef CLOTHID_DATASETS_OBSERVATION_OBSERVATION_H_
#define CLOTHID_DATASETS_OBSERVATION_OBSERVATION_H_

#include <Eigen/Core>
#include <array>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "datasets/observation/cloud_observation.h"
#include "datasets/observation/force_observation.h"
#include "datasets/observation/frame_stencil.h"
#include "datasets/observation/model_error.h"
#include "sim/rollout/rollout.h"

namespace clothid {

// A coordinate with a residual, or a row of the frame's cloud.
struct SeenCoordinate {
  int frame = 0;
  int point = 0;  // P + j: row j of the frame's cloud
  int axis = 0;   // 0, 1, 2: x, y, z; 0 in a cloud
};

// How far a prediction is from the recording, over the seen coordinates; the errors of recordings add up.
// What is said of coordinates is of tracked points alone.
struct PredictionError {
  double squared_error = 0.0;   // m^2: |predicted - measured|^2
  double squared_motion = 0.0;  // m^2: |measured - its mean over time|^2
  double num_coordinates = 0.0;
  double successive_products = 0.0;  // m^2: errors of a coordinate in one frame and the next in which it is seen
  double successive_squares = 0.0;   // m^2: the mean of their squares, summed likewise
  CloudError cloud;
  ForceError force;  // no part of any of the sizes below

  // m: the root mean square distance of seen points; a partly seen point counts by its share, a point of a cloud by its
  // distance to the predicted surface.
  double rmse() const;
  // Of the tracked points: 100 (1 - |predicted - measured| / |measured - its mean over time|); NaN where nothing moves
  // or nothing is tracked.
  double fit_percent() const;
  // Of a coordinate's errors from frame to frame: 0 for the independent noise of a sensor, near 1 where the model
  // misses something that lasts. NaN without two frames, or without error. In a cloud no point can be followed: there
  // it is of the mean distance of the points that are nearest to a node. Where forces were measured, too, the larger of
  // theirs and that of positions.
  double autocorrelation() const;
  PredictionError& operator+=(const PredictionError& other);
};

class Observation {
 public:
  // Throws `Error` (kBadData), naming the recording, where `ValidateMotion` does and where neither a coordinate nor a
  // force is seen. Keeps no reference to `motion`.
  explicit Observation(const RecordedMotion& motion);

  int num_residuals() const { return first_force_row() + forces_.num_residuals(); }  // m
  int num_frames() const { return static_cast<int>(stencils_.size()); }              // T
  int num_points() const { return static_cast<int>(points_.size()); }                // P
  int num_nodes() const { return num_nodes_; }                                       // N
  int num_steps() const { return num_steps_; }  // the least number that covers all frames
  bool sigma_is_known() const { return sigma_is_known_; }
  const std::vector<FrameStencil>& stencils() const { return stencils_; }  // [T] linear in time
  const std::vector<ObservedPoint>& points() const { return points_; }     // [P]
  bool has_clouds() const { return !clouds_.empty(); }
  const CloudObservation& clouds() const { return clouds_; }
  const ForceObservation& forces() const { return forces_; }
  int first_force_row() const { return static_cast<int>(coordinates_.size()); }  // as many rows are of positions
  int num_predicted() const { return 3 * (num_points() + (has_clouds() ? num_nodes_ : 0)); }  // rows of a prediction R

  // The rows of the residual that are of positions, ordered by frame, then point, then axis; the points of a frame's
  // cloud come after its tracked ones. Frame i has the rows first_row(i) .. first_row(i+1)-1.
  const std::vector<SeenCoordinate>& coordinates() const { return coordinates_; }
  // Also of reading i of the forces, as frame T + i.
  int first_row(int frame) const {
    return frame < num_frames() ? first_row_[frame] : first_force_row() + forces_.first_row(frame - num_frames());
  }
  int first_cloud_row(int frame) const { return first_row_[frame + 1] - clouds_.num_rows(frame); }
  double sigma(int point) const { return sigma_[point]; }  // m, of a tracked point
  double sigma(const SeenCoordinate& seen) const {         // m
    return seen.point < num_points() ? sigma_[seen.point] : clouds_.point(seen.frame, seen.point - num_points()).sigma;
  }
  // Whether the row is the distance to the border of a point that has one to the surface, too.
  bool is_border_row(const SeenCoordinate& seen) const {
    return seen.point >= num_points() && clouds_.is_border_row(seen.frame, seen.point - num_points());
  }
  // Of any row of the residual: what it is of; its sigma, m or N; and of all of them their times [m] s.
  PredictedKind KindOf(int row) const;
  double SigmaOf(int row) const;
  Eigen::VectorXd RowTimes() const;

  // How far the model errs; at first it does not. And what is left of the weights of rows, sigma/sqrt(sigma^2 + n
  // tau^2): [m], or empty where all are 1.
  void SetModelError(const ModelError& error);
  const ModelError& model_error() const { return model_error_; }
  const Eigen::VectorXd& error_weights() const { return error_weights_; }

  // [first_force_row()] measured/sigma; 0 in the rows of clouds.
  const Eigen::VectorXd& whitened_measured() const { return measured_; }

  // States at the steps of a stencil, [3N x c] each, to rows of the prediction at its time [R x c]; and the time
  // derivative [R] m/s of their first column.
  Eigen::MatrixXd PointsAt(const FrameStencil& stencil, const FrameStates& states) const;
  Eigen::VectorXd VelocitiesAt(const FrameStencil& stencil, const FrameStates& states) const;
  // Of a prediction [R x ..] with clouds: the nodes [3N x ..].
  auto Nodes(const Eigen::MatrixXd& predicted) const { return predicted.bottomRows(3 * num_nodes_); }

  // Every point, seen or not, at every frame: [R x T] m. `rollout` must be ok() and have num_steps() steps.
  Eigen::MatrixXd Predict(const Rollout& rollout) const;
  // The seen coordinates of `points` [R x T] over sigma: [m]; 0 in the rows of clouds, and of forces where there are
  // none in `forces` [3G x F].
  Eigen::VectorXd Whiten(const Eigen::MatrixXd& points, const Eigen::MatrixXd& forces = {}) const;
  // The same for one frame and several columns: [R x c] -> [rows of the frame x c].
  Eigen::MatrixXd WhitenFrame(int frame, const Eigen::MatrixXd& points) const;
  // (predicted - measured)/sigma, and distances over sigma: [m]. Throws `std::logic_error` where the recording has
  // forces and `forces` [3G x F] are not given.
  Eigen::VectorXd Residuals(const Eigen::MatrixXd& predicted, const Eigen::MatrixXd& forces = {}) const;
  // Of positions, and of forces [3G x F] where they are given.
  PredictionError Compare(const Eigen::MatrixXd& predicted, const Eigen::MatrixXd& forces = {}) const;

  // One frame with derivatives: the first column of `points` [R x (1 + q)] is the prediction, the others are its
  // derivatives; to residuals [r] and theirs [r x q].
  void LinearizeFrame(int frame, const Eigen::MatrixXd& points, Eigen::VectorXd* residuals,
                      Eigen::MatrixXd* jacobian) const;

 private:
  void FindSeenCoordinates(const RecordedMotion& motion);
  // sum_j weights[j] x_j of the first `num_columns` columns, as rows of a prediction.
  Eigen::MatrixXd Combine(const std::array<double, FrameStencil::kMaxSize>& weights, const FrameStates& states,
                          Eigen::Index num_columns) const;

  int num_nodes_ = 0;
  int num_steps_ = 0;
  bool sigma_is_known_ = false;
  std::vector<ObservedPoint> points_;
  Eigen::VectorXd sigma_;               // [P]
  std::vector<FrameStencil> stencils_;  // [T]
  std::vector<SeenCoordinate> coordinates_;
  std::vector<int> first_row_;  // [T + 1]
  Eigen::VectorXd measured_;    // [first_force_row()]
  CloudObservation clouds_;
  ForceObservation forces_;
  Eigen::VectorXd times_, force_times_;  // [T], [F] s
  ModelError model_error_;
  Eigen::VectorXd error_weights_;
};

}  // namespace clothid

#endif  // CLOTHID_DATASETS_OBSERVATION_OBSERVATION_H_
