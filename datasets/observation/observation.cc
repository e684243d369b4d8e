#include "datasets/observation/observation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "datasets/motion/motion_validation.h"
#include "sim/base/error.h"
#include "sim/mesh/mesh.h"
#include "sim/rollout/handle_forces.h"

namespace clothid {
namespace {

// The sigma of a recording that does not know it, relative to the cloth's size.
constexpr double kRelativeSigma = 1e-3;

double CloudSigma(const RecordedMotion& motion) {
  if (motion.clouds.empty()) return 0.0;
  return motion.cloud_sigma > 0.0 ? motion.cloud_sigma : kRelativeSigma * ClothSize(motion.scene.mesh);
}

// Of all kinds of points that there are.
bool SigmaIsKnown(const RecordedMotion& motion) {
  const bool of_points = motion.sigma.size() > 0 || (motion.num_points() == 0 && !motion.clouds.empty());
  return of_points && (motion.clouds.empty() || motion.cloud_sigma > 0.0);
}

Eigen::VectorXd PointSigma(const RecordedMotion& motion) {
  if (motion.sigma.size() == 0) {
    return Eigen::VectorXd::Constant(motion.num_points(), kRelativeSigma * ClothSize(motion.scene.mesh));
  }
  return motion.sigma;
}

const RecordedMotion& Validated(const RecordedMotion& motion) {
  ValidateMotion(motion);
  return motion;
}

// Of every point [P] whether all of its nodes are handles.
std::vector<bool> FindHeldPoints(const RecordedMotion& motion) {
  std::vector<bool> is_handle(static_cast<std::size_t>(motion.scene.mesh.num_nodes()), false), is_held;
  for (const int node : motion.scene.handles.nodes) is_handle[node] = true;
  for (const ObservedPoint& point : motion.points) {
    bool all = true;
    for (int k = 0; k < point.num_nodes; ++k) all &= point.weights[k] == 0.0 || is_handle[point.nodes[k]];
    is_held.push_back(all);
  }
  return is_held;
}

}  // namespace

double PredictionError::rmse() const {
  return std::sqrt(3.0 * (squared_error + cloud.squared_distance) / (num_coordinates + 3.0 * cloud.num_points));
}

double PredictionError::fit_percent() const {
  if (!(squared_motion > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  return 100.0 * (1.0 - std::sqrt(squared_error / squared_motion));
}

double PredictionError::autocorrelation() const {
  const double squares = successive_squares + cloud.successive_squares;
  if (!(squares > 0.0)) return force.autocorrelation();
  // NaN is not larger.
  return std::fmax((successive_products + cloud.successive_products) / squares, force.autocorrelation());
}

PredictionError& PredictionError::operator+=(const PredictionError& other) {
  successive_products += other.successive_products;
  successive_squares += other.successive_squares;
  squared_error += other.squared_error;
  squared_motion += other.squared_motion;
  num_coordinates += other.num_coordinates;
  cloud += other.cloud;
  force += other.force;
  return *this;
}

Observation::Observation(const RecordedMotion& motion)
    : num_nodes_(Validated(motion).scene.mesh.num_nodes()),
      sigma_is_known_(SigmaIsKnown(motion)),
      points_(motion.points),
      sigma_(PointSigma(motion)),
      stencils_(LinearStencils(motion.times, motion.scene)),
      clouds_(motion, CloudSigma(motion), sigma_, FindHeldPoints(motion)),
      forces_(motion),
      times_(motion.times),
      force_times_(motion.forces.times) {
  for (const FrameStencil& stencil : stencils_) num_steps_ = std::max(num_steps_, stencil.last_step());
  if (!forces_.is_empty()) num_steps_ = std::max({num_steps_, forces_.last_step(), kFewestForceSteps});
  FindSeenCoordinates(motion);
}

void Observation::FindSeenCoordinates(const RecordedMotion& motion) {
  const std::vector<bool> is_held = FindHeldPoints(motion);
  std::vector<double> measured;
  std::size_t most = 3 * points_.size() * stencils_.size();
  for (int i = 0; i < num_frames(); ++i) most += static_cast<std::size_t>(clouds_.num_rows(i));
  coordinates_.reserve(most);
  measured.reserve(most);
  first_row_.push_back(0);
  for (int i = 0; i < num_frames(); ++i) {
    for (int p = 0; p < num_points(); ++p) {
      if (is_held[p] || points_[p].kind != PointKind::kMaterial) continue;
      for (int axis = 0; axis < 3; ++axis) {
        const double position = motion.positions(3 * p + axis, i);
        if (!std::isfinite(position)) continue;
        coordinates_.push_back({i, p, axis});
        measured.push_back(position / sigma_[p]);
      }
    }
    for (int j = 0; j < clouds_.num_rows(i); ++j) {
      coordinates_.push_back({i, num_points() + j, 0});
      measured.push_back(0.0);
    }
    first_row_.push_back(first_force_row());
  }
  if (coordinates_.empty() && forces_.is_empty()) {
    throw Error(ErrorKind::kBadData, motion.name + ": positions: no seen point moves freely; nothing can be fitted");
  }
  measured_ = Eigen::Map<const Eigen::VectorXd>(measured.data(), static_cast<Eigen::Index>(measured.size()));
}

PredictedKind Observation::KindOf(int row) const {
  if (row >= first_force_row()) return PredictedKind::kForces;
  return coordinates_[row].point < num_points() ? PredictedKind::kPoints : PredictedKind::kClouds;
}

double Observation::SigmaOf(int row) const {
  if (row < first_force_row()) return sigma(coordinates_[row]);
  return forces_.sigma(forces_.seen()[row - first_force_row()].row / 3);
}

Eigen::VectorXd Observation::RowTimes() const {
  Eigen::VectorXd times(num_residuals());
  for (int row = 0; row < first_force_row(); ++row) times[row] = times_[coordinates_[row].frame];
  for (int row = first_force_row(); row < num_residuals(); ++row) {
    times[row] = force_times_[forces_.seen()[row - first_force_row()].reading];
  }
  return times;
}

void Observation::SetModelError(const ModelError& error) {
  model_error_ = error;
  error_weights_.resize(0);
  if (error.is_zero()) return;
  const Eigen::VectorXd times = RowTimes();
  error_weights_.resize(num_residuals());
  for (int row = 0; row < num_residuals(); ++row) {
    const double sigma = SigmaOf(row);
    const ErrorCurve& curve = error.CurveOf(KindOf(row));
    error_weights_[row] = sigma / std::hypot(sigma, std::sqrt(curve.alike) * curve.DeviationAt(times[row]));
  }
}

Eigen::MatrixXd Observation::Combine(const std::array<double, FrameStencil::kMaxSize>& weights,
                                     const FrameStates& states, Eigen::Index num_columns) const {
  Eigen::MatrixXd points = Eigen::MatrixXd::Zero(num_predicted(), num_columns);
  for (int p = 0; p < num_points(); ++p) {
    for (int k = 0; k < points_[p].num_nodes; ++k) {
      for (std::size_t j = 0; j < states.size(); ++j) {
        points.middleRows<3>(3 * p) += (points_[p].weights[k] * weights[j]) *
                                       states[j].leftCols(num_columns).middleRows<3>(3 * points_[p].nodes[k]);
      }
    }
  }
  if (!has_clouds()) return points;
  auto nodes = points.bottomRows(3 * num_nodes_);
  nodes = weights[0] * states[0].leftCols(num_columns);
  for (std::size_t j = 1; j < states.size(); ++j) nodes += weights[j] * states[j].leftCols(num_columns);
  return points;
}

Eigen::MatrixXd Observation::PointsAt(const FrameStencil& stencil, const FrameStates& states) const {
  return Combine(stencil.weights, states, states.front().cols());
}

Eigen::VectorXd Observation::VelocitiesAt(const FrameStencil& stencil, const FrameStates& states) const {
  return Combine(stencil.slopes, states, 1);
}

Eigen::MatrixXd Observation::Predict(const Rollout& rollout) const {
  Eigen::MatrixXd predicted(num_predicted(), num_frames());
  for (int i = 0; i < num_frames(); ++i) {
    FrameStates states;
    for (int step = stencils_[i].first_step; step <= stencils_[i].last_step(); ++step) {
      const Eigen::VectorXd& state = rollout.positions(step);
      states.emplace_back(state.data(), state.size(), 1);
    }
    predicted.col(i) = PointsAt(stencils_[i], states);
  }
  return predicted;
}

Eigen::VectorXd Observation::Whiten(const Eigen::MatrixXd& points, const Eigen::MatrixXd& forces) const {
  Eigen::VectorXd whitened = Eigen::VectorXd::Zero(num_residuals());
  for (int r = 0; r < first_force_row(); ++r) {
    const SeenCoordinate& seen = coordinates_[r];
    if (seen.point < num_points()) whitened[r] = points(3 * seen.point + seen.axis, seen.frame) / sigma_[seen.point];
  }
  if (forces.size() > 0) whitened.tail(forces_.num_residuals()) = forces_.Whiten(forces);
  return whitened;
}

Eigen::MatrixXd Observation::WhitenFrame(int frame, const Eigen::MatrixXd& points) const {
  const int first = first_row_[frame];
  Eigen::MatrixXd whitened = Eigen::MatrixXd::Zero(first_row_[frame + 1] - first, points.cols());
  for (int r = 0; r < first_cloud_row(frame) - first; ++r) {
    const SeenCoordinate& seen = coordinates_[first + r];
    whitened.row(r) = points.row(3 * seen.point + seen.axis) / sigma_[seen.point];
  }
  return whitened;
}

Eigen::VectorXd Observation::Residuals(const Eigen::MatrixXd& predicted, const Eigen::MatrixXd& forces) const {
  if (forces.cols() != forces_.num_readings()) throw std::logic_error("residuals: expected the predicted forces");
  Eigen::VectorXd residuals = Whiten(predicted);
  residuals.head(first_force_row()) -= measured_;
  if (!forces_.is_empty()) residuals.tail(forces_.num_residuals()) = forces_.Residuals(forces);
  for (int i = 0; has_clouds() && i < num_frames(); ++i) {
    residuals.segment(first_cloud_row(i), clouds_.num_rows(i)) = clouds_.Residuals(i, Nodes(predicted).col(i));
  }
  return residuals;
}

void Observation::LinearizeFrame(int frame, const Eigen::MatrixXd& points, Eigen::VectorXd* residuals,
                                 Eigen::MatrixXd* jacobian) const {
  const Eigen::MatrixXd whitened = WhitenFrame(frame, points);
  *residuals = whitened.col(0) - measured_.segment(first_row_[frame], whitened.rows());
  *jacobian = whitened.rightCols(whitened.cols() - 1);
  if (!has_clouds()) return;
  Eigen::Index row = first_cloud_row(frame) - first_row_[frame];
  const auto derivatives = Nodes(points).rightCols(jacobian->cols());
  for (const SurfaceDistance& distance : clouds_.Linearize(frame, Nodes(points).col(0))) {
    (*residuals)[row] = distance.distance;
    for (int k = 0; k < distance.num_nodes; ++k) {
      jacobian->row(row) += distance.gradient.col(k).transpose() * derivatives.middleRows<3>(3 * distance.nodes[k]);
    }
    ++row;
  }
}

PredictionError Observation::Compare(const Eigen::MatrixXd& predicted, const Eigen::MatrixXd& forces) const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(3 * num_points());
  Eigen::VectorXd count = Eigen::VectorXd::Zero(3 * num_points());
  for (int r = 0; r < first_force_row(); ++r) {
    const SeenCoordinate& seen = coordinates_[r];
    if (seen.point >= num_points()) continue;
    sum[3 * seen.point + seen.axis] += measured_[r] * sigma_[seen.point];
    count[3 * seen.point + seen.axis] += 1.0;
  }
  PredictionError error;
  if (forces.size() > 0) error.force = forces_.Compare(forces);
  if (has_clouds()) error.cloud = clouds_.Compare(predicted.topRows(3 * num_points()), Nodes(predicted));
  error.num_coordinates = first_force_row() - error.cloud.num_points - error.cloud.num_border;
  Eigen::VectorXd last = Eigen::VectorXd::Constant(3 * num_points(), std::numeric_limits<double>::quiet_NaN());
  for (int r = 0; r < first_force_row(); ++r) {
    const SeenCoordinate& seen = coordinates_[r];
    if (seen.point >= num_points()) continue;
    const int row = 3 * seen.point + seen.axis;
    const double measured = measured_[r] * sigma_[seen.point];
    const double difference = predicted(row, seen.frame) - measured;
    error.squared_error += difference * difference;
    error.squared_motion += std::pow(measured - sum[row] / count[row], 2);
    if (!std::isnan(last[row])) {
      error.successive_products += last[row] * difference;
      error.successive_squares += 0.5 * (last[row] * last[row] + difference * difference);
    }
    last[row] = difference;
  }
  return error;
}

}  // namespace clothid
