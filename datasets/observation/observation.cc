#include "datasets/observation/observation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "datasets/motion/motion_validation.h"
#include "sim/base/error.h"
#include "sim/scene/mesh.h"

namespace clothid {
namespace {

// A recorded time this close to a step (in steps) is that step: times are multiples of h up to their rounding.
constexpr double kSameTime = 1e-9;

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

bool IsHandlePoint(const ObservedPoint& point, const std::vector<bool>& is_handle) {
  for (int k = 0; k < point.num_nodes; ++k) {
    if (point.weights[k] != 0.0 && !is_handle[point.nodes[k]]) return false;
  }
  return true;
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
  if (!(squares > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  return (successive_products + cloud.successive_products) / squares;
}

PredictionError& PredictionError::operator+=(const PredictionError& other) {
  successive_products += other.successive_products;
  successive_squares += other.successive_squares;
  squared_error += other.squared_error;
  squared_motion += other.squared_motion;
  num_coordinates += other.num_coordinates;
  cloud += other.cloud;
  return *this;
}

Observation::Observation(const RecordedMotion& motion)
    : num_nodes_(Validated(motion).scene.mesh.num_nodes()),
      sigma_is_known_(SigmaIsKnown(motion)),
      points_(motion.points),
      sigma_(PointSigma(motion)),
      clouds_(motion, CloudSigma(motion)) {
  PlaceFrames(motion);
  FindSeenCoordinates(motion);
}

void Observation::PlaceFrames(const RecordedMotion& motion) {
  for (int i = 0; i < motion.num_frames(); ++i) {
    double steps = (motion.times[i] - motion.scene.start_time) / motion.scene.time_step;
    const double nearest = std::round(steps);
    if (std::abs(steps - nearest) <= kSameTime * std::max(1.0, nearest)) steps = nearest;
    Bracket bracket;
    bracket.step = static_cast<int>(std::floor(steps));
    bracket.fraction = steps - bracket.step;
    brackets_.push_back(bracket);
    num_steps_ = std::max(num_steps_, bracket.step + (bracket.fraction > 0.0 ? 1 : 0));
  }
}

void Observation::FindSeenCoordinates(const RecordedMotion& motion) {
  std::vector<bool> is_handle(num_nodes_, false);
  for (int node : motion.scene.handles.nodes) is_handle[node] = true;
  std::vector<double> measured;
  first_row_.push_back(0);
  for (int i = 0; i < num_frames(); ++i) {
    for (int p = 0; p < num_points(); ++p) {
      if (IsHandlePoint(points_[p], is_handle)) continue;
      for (int axis = 0; axis < 3; ++axis) {
        const double position = motion.positions(3 * p + axis, i);
        if (!std::isfinite(position)) continue;
        coordinates_.push_back({i, p, axis});
        measured.push_back(position / sigma_[p]);
      }
    }
    for (int j = 0; j < clouds_.num_points(i); ++j) {
      coordinates_.push_back({i, num_points() + j, 0});
      measured.push_back(0.0);
    }
    first_row_.push_back(num_residuals());
  }
  if (coordinates_.empty()) {
    throw Error(ErrorKind::kBadData, motion.name + ": positions: no seen point moves freely; nothing can be fitted");
  }
  measured_ = Eigen::Map<const Eigen::VectorXd>(measured.data(), static_cast<Eigen::Index>(measured.size()));
}

Eigen::MatrixXd Observation::PointsAt(int frame, const Eigen::MatrixXd& from, const Eigen::MatrixXd& to) const {
  const double fraction = brackets_[frame].fraction;
  Eigen::MatrixXd points = Eigen::MatrixXd::Zero(num_predicted(), from.cols());
  for (int p = 0; p < num_points(); ++p) {
    for (int k = 0; k < points_[p].num_nodes; ++k) {
      const int row = 3 * points_[p].nodes[k];
      points.middleRows<3>(3 * p) += (points_[p].weights[k] * (1.0 - fraction)) * from.middleRows<3>(row);
      if (fraction > 0.0) points.middleRows<3>(3 * p) += (points_[p].weights[k] * fraction) * to.middleRows<3>(row);
    }
  }
  if (has_clouds()) {
    points.bottomRows(from.rows()) = (1.0 - fraction) * from;
    if (fraction > 0.0) points.bottomRows(from.rows()) += fraction * to;
  }
  return points;
}

Eigen::MatrixXd Observation::PointsOf(const Eigen::MatrixXd& nodes) const {
  Eigen::MatrixXd points = Eigen::MatrixXd::Zero(num_predicted(), nodes.cols());
  for (int p = 0; p < num_points(); ++p) {
    for (int k = 0; k < points_[p].num_nodes; ++k) {
      points.middleRows<3>(3 * p) += points_[p].weights[k] * nodes.middleRows<3>(3 * points_[p].nodes[k]);
    }
  }
  if (has_clouds()) points.bottomRows(nodes.rows()) = nodes;
  return points;
}

Eigen::MatrixXd Observation::Predict(const Rollout& rollout) const {
  Eigen::MatrixXd predicted(num_predicted(), num_frames());
  for (int i = 0; i < num_frames(); ++i) {
    const int from = step(i);
    predicted.col(i) = PointsAt(i, rollout.positions(from), rollout.positions(needs_next(i) ? from + 1 : from));
  }
  return predicted;
}

Eigen::VectorXd Observation::Whiten(const Eigen::MatrixXd& points) const {
  Eigen::VectorXd whitened(num_residuals());
  for (int r = 0; r < num_residuals(); ++r) {
    const SeenCoordinate& seen = coordinates_[r];
    whitened[r] = seen.point < num_points() ? points(3 * seen.point + seen.axis, seen.frame) / sigma_[seen.point] : 0.0;
  }
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

Eigen::VectorXd Observation::Residuals(const Eigen::MatrixXd& predicted) const {
  Eigen::VectorXd residuals = Whiten(predicted) - measured_;
  for (int i = 0; has_clouds() && i < num_frames(); ++i) {
    residuals.segment(first_cloud_row(i), clouds_.num_points(i)) = clouds_.Residuals(i, Nodes(predicted).col(i));
  }
  return residuals;
}

std::vector<CloudRows> Observation::LinearizeClouds(const Eigen::MatrixXd& predicted) const {
  std::vector<CloudRows> rows;
  for (int i = 0; has_clouds() && i < num_frames(); ++i) {
    rows.push_back(clouds_.Linearize(i, Nodes(predicted).col(i)));
  }
  return rows;
}

Eigen::VectorXd Observation::ResidualDerivative(const Eigen::MatrixXd& derivative,
                                                const std::vector<CloudRows>& cloud_rows) const {
  Eigen::VectorXd result = Whiten(derivative);
  for (int i = 0; has_clouds() && i < num_frames(); ++i) {
    int row = first_cloud_row(i);
    for (const SurfaceDistance& distance : cloud_rows[i]) {
      for (int k = 0; k < distance.num_nodes; ++k) {
        result[row] += distance.gradient.col(k).dot(Nodes(derivative).col(i).segment<3>(3 * distance.nodes[k]));
      }
      ++row;
    }
  }
  return result;
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

PredictionError Observation::Compare(const Eigen::MatrixXd& predicted) const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(3 * num_points());
  Eigen::VectorXd count = Eigen::VectorXd::Zero(3 * num_points());
  for (int r = 0; r < num_residuals(); ++r) {
    const SeenCoordinate& seen = coordinates_[r];
    if (seen.point >= num_points()) continue;
    sum[3 * seen.point + seen.axis] += measured_[r] * sigma_[seen.point];
    count[3 * seen.point + seen.axis] += 1.0;
  }
  PredictionError error;
  if (has_clouds()) error.cloud = clouds_.Compare(Nodes(predicted));
  error.num_coordinates = num_residuals() - error.cloud.num_points;
  Eigen::VectorXd last = Eigen::VectorXd::Constant(3 * num_points(), std::numeric_limits<double>::quiet_NaN());
  for (int r = 0; r < num_residuals(); ++r) {
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

void Observation::AddSeeds(int step, const Eigen::MatrixXd& seeds, Eigen::MatrixXd* gradient,
                           const std::vector<CloudRows>& cloud_rows) const {
  // Frames that touch this step: a = step, and a = step - 1 with a fraction. Frames are sorted by time.
  const auto by_step = [](const Bracket& bracket, int value) { return bracket.step < value; };
  auto it = std::lower_bound(brackets_.begin(), brackets_.end(), step - 1, by_step);
  for (; it != brackets_.end() && it->step <= step; ++it) {
    const double weight = it->step == step ? 1.0 - it->fraction : it->fraction;
    if (weight > 0.0) AddFrameSeeds(static_cast<int>(it - brackets_.begin()), weight, seeds, cloud_rows, gradient);
  }
}

void Observation::AddFrameSeeds(int frame, double weight, const Eigen::MatrixXd& seeds,
                                const std::vector<CloudRows>& cloud_rows, Eigen::MatrixXd* gradient) const {
  for (int r = first_row_[frame]; r < first_cloud_row(frame); ++r) {
    const SeenCoordinate& seen = coordinates_[r];
    const ObservedPoint& point = points_[seen.point];
    for (int k = 0; k < point.num_nodes; ++k) {
      gradient->row(3 * point.nodes[k] + seen.axis) += (weight * point.weights[k] / sigma_[seen.point]) * seeds.row(r);
    }
  }
  if (!has_clouds()) return;
  int row = first_cloud_row(frame);
  for (const SurfaceDistance& distance : cloud_rows[frame]) {
    for (int k = 0; k < distance.num_nodes; ++k) {
      gradient->middleRows<3>(3 * distance.nodes[k]) += (weight * distance.gradient.col(k)) * seeds.row(row);
    }
    ++row;
  }
}

FrameSampler::FrameSampler(const Observation* observation, Visitor visitor)
    : observation_(observation), visitor_(std::move(visitor)) {}

void FrameSampler::AddStep(int step, const Eigen::MatrixXd& state) {
  for (; next_frame_ < observation_->num_frames(); ++next_frame_) {
    const int from = observation_->step(next_frame_);
    const bool needs_next = observation_->needs_next(next_frame_);
    if (from + (needs_next ? 1 : 0) > step) break;
    visitor_(next_frame_, observation_->PointsAt(next_frame_, needs_next ? previous_ : state, state));
  }
  previous_ = state;
}

}  // namespace clothid
