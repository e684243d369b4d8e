// From a trajectory to predicted points at the recorded times, to residuals, and back: the transpose.
//
// Tracked points are a linear map P x of the trajectory:
//
// A point p (a node, or a barycentric point) at the recorded time t_i lies between two steps a and a + 1:
//   predicted_p(t_i) = (1 - c) sum_k w_k x_a[node_k] + c sum_k w_k x_{a+1}[node_k],   c = (t_i - start)/h - a,
// linear in time. A residual is (predicted - measured)/sigma for every seen coordinate. Not seen: a coordinate that was
// not measured (NaN). Without a residual: a point all of whose nodes are handles, whose motion is part of the scene.
//
// Where the recording does not know its sigma, every coordinate has sigma = 1e-3 of the cloth's size (the square root
// of its rest area): costs are then free of scale, and say nothing about likelihood.
//
// A recording may have point clouds, too, or alone. Their residuals are distances to the predicted surface
// (datasets/observation/cloud_observation.h), a nonlinear function of all nodes at the recorded time, which are
// interpolated as the points are. A prediction then has two parts, rows 0 .. 3P - 1: the points; the 3N rows below
// them: the nodes. Without clouds it is the points alone.
#ifndef CLOTHID_DATASETS_OBSERVATION_OBSERVATION_H_
#define CLOTHID_DATASETS_OBSERVATION_OBSERVATION_H_

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "datasets/observation/cloud_observation.h"
#include "sim/rollout/rollout.h"

namespace clothid {

// A coordinate with a residual, or the distance of a cloud's point.
struct SeenCoordinate {
  int frame = 0;
  int point = 0;  // P + j: point j of the frame's cloud
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

  // m: the root mean square distance of seen points; a partly seen point counts by its share, a point of a cloud by its
  // distance to the predicted surface.
  double rmse() const;
  // Of the tracked points: 100 (1 - |predicted - measured| / |measured - its mean over time|); NaN where nothing moves
  // or nothing is tracked.
  double fit_percent() const;
  // Of a coordinate's errors from frame to frame: 0 for the independent noise of a sensor, near 1 where the model
  // misses something that lasts. NaN without two frames, or without error. In a cloud no point can be followed: there
  // it is of the mean distance of the points that are nearest to a node.
  double autocorrelation() const;
  PredictionError& operator+=(const PredictionError& other);
};

class Observation {
 public:
  // Throws `Error` (kBadData), naming the recording, where `ValidateMotion` does and where no coordinate is seen. Keeps
  // no reference to `motion`.
  explicit Observation(const RecordedMotion& motion);

  int num_residuals() const { return static_cast<int>(coordinates_.size()); }  // m
  int num_frames() const { return static_cast<int>(brackets_.size()); }        // T
  int num_points() const { return static_cast<int>(points_.size()); }          // P
  int num_nodes() const { return num_nodes_; }                                 // N
  int num_steps() const { return num_steps_; }  // the least number that covers all frames
  bool sigma_is_known() const { return sigma_is_known_; }
  bool has_clouds() const { return !clouds_.empty(); }
  const CloudObservation& clouds() const { return clouds_; }
  int num_predicted() const { return 3 * (num_points() + (has_clouds() ? num_nodes_ : 0)); }  // rows of a prediction R

  // The rows of the residual, ordered by frame, then point, then axis; the points of a frame's cloud come after its
  // tracked ones. Frame i has the rows first_row(i) .. first_row(i+1)-1.
  const std::vector<SeenCoordinate>& coordinates() const { return coordinates_; }
  int first_row(int frame) const { return first_row_[frame]; }
  double sigma(int point) const { return point < num_points() ? sigma_[point] : clouds_.sigma(); }  // m
  const Eigen::VectorXd& whitened_measured() const { return measured_; }  // [m] measured/sigma; 0 in the rows of clouds

  // Every point, seen or not, at every frame: [R x T] m. `rollout` must be ok() and have num_steps() steps.
  Eigen::MatrixXd Predict(const Rollout& rollout) const;
  // The seen coordinates of `points` [R x T] over sigma: [m]; 0 in the rows of clouds.
  Eigen::VectorXd Whiten(const Eigen::MatrixXd& points) const;
  // The same for one frame and several columns: [R x c] -> [rows of the frame x c].
  Eigen::MatrixXd WhitenFrame(int frame, const Eigen::MatrixXd& points) const;
  // (predicted - measured)/sigma, and distances over sigma: [m].
  Eigen::VectorXd Residuals(const Eigen::MatrixXd& predicted) const;
  PredictionError Compare(const Eigen::MatrixXd& predicted) const;

  // The rows of every frame's cloud at `predicted` [R x T]: what the derivative of the residual needs beside the linear
  // map. Empty without clouds.
  std::vector<CloudRows> LinearizeClouds(const Eigen::MatrixXd& predicted) const;
  // What the derivative of the prediction along one parameter [R x T] is of the residual [m]; `cloud_rows` of
  // LinearizeClouds at the prediction.
  Eigen::VectorXd ResidualDerivative(const Eigen::MatrixXd& derivative, const std::vector<CloudRows>& cloud_rows) const;
  // One frame with derivatives: the first column of `points` [R x (1 + q)] is the prediction, the others are its
  // derivatives; to residuals [r] and theirs [r x q].
  void LinearizeFrame(int frame, const Eigen::MatrixXd& points, Eigen::VectorXd* residuals,
                      Eigen::MatrixXd* jacobian) const;

  // The transpose: adds to `gradient` [3N x s] the part at `step` of  dC/dx = (d residual/dx)^T seeds,  seeds [m x s].
  // `cloud_rows`: of LinearizeClouds at the prediction.
  void AddSeeds(int step, const Eigen::MatrixXd& seeds, Eigen::MatrixXd* gradient,
                const std::vector<CloudRows>& cloud_rows = {}) const;

  // Columns of states at `from` and `to` = step(frame), step(frame) + 1, [3N x c] each, to rows of predictions [R x c].
  Eigen::MatrixXd PointsAt(int frame, const Eigen::MatrixXd& from, const Eigen::MatrixXd& to) const;
  // The step a before frame i; a + 1 is needed too where needs_next(i).
  int step(int frame) const { return brackets_[frame].step; }
  bool needs_next(int frame) const { return brackets_[frame].fraction > 0.0; }
  double fraction(int frame) const { return brackets_[frame].fraction; }  // c, in [0, 1)

  // The same in two: columns of the nodes' states at the time of a frame, [3N x c], to rows of predictions [R x c]; and
  // the transpose, which adds  weight (d residual of the frame/d nodes)^T seeds,  seeds [m x s], to `gradient` [3N x
  // s].
  Eigen::MatrixXd PointsOf(const Eigen::MatrixXd& nodes) const;
  void AddFrameSeeds(int frame, double weight, const Eigen::MatrixXd& seeds, const std::vector<CloudRows>& cloud_rows,
                     Eigen::MatrixXd* gradient) const;

 private:
  struct Bracket {
    int step = 0;
    double fraction = 0.0;  // c, in [0, 1)
  };

  void PlaceFrames(const RecordedMotion& motion);
  void FindSeenCoordinates(const RecordedMotion& motion);
  int first_cloud_row(int frame) const { return first_row_[frame + 1] - clouds_.num_points(frame); }
  // Of a prediction: the nodes [3N x ..].
  auto Nodes(const Eigen::MatrixXd& predicted) const { return predicted.bottomRows(3 * num_nodes_); }

  int num_nodes_ = 0;
  int num_steps_ = 0;
  bool sigma_is_known_ = false;
  std::vector<ObservedPoint> points_;
  Eigen::VectorXd sigma_;  // [P]
  std::vector<Bracket> brackets_;
  std::vector<SeenCoordinate> coordinates_;
  std::vector<int> first_row_;  // [T + 1]
  Eigen::VectorXd measured_;    // [m]
  CloudObservation clouds_;
};

// Predictions from states that arrive step by step, as in a forward sweep: nothing but the last state is stored.
class FrameSampler {
 public:
  // Called once per frame, in order, with the points [R x c] of every column of the state.
  using Visitor = std::function<void(int frame, const Eigen::MatrixXd& points)>;

  // `observation` must outlive the sampler.
  FrameSampler(const Observation* observation, Visitor visitor);
  // `state` [3N x c] after `step` steps; steps 0, 1, 2, .. in order.
  void AddStep(int step, const Eigen::MatrixXd& state);

 private:
  const Observation* observation_;
  Visitor visitor_;
  int next_frame_ = 0;
  Eigen::MatrixXd previous_;
};

}  // namespace clothid

#endif  // CLOTHID_DATASETS_OBSERVATION_OBSERVATION_H_
