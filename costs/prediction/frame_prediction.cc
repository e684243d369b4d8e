#include "costs/prediction/frame_prediction.h"

namespace clothid {

FramePrediction::FramePrediction(const Alignment& alignment, const Eigen::Vector3d& center,
                                 const FrameInterpolation& interpolation, const Observation* observation)
    : observation_(observation),
      stencils_(interpolation.At(alignment.time_offset)),
      correction_(alignment.turn, alignment.shift, center) {}

Eigen::MatrixXd FramePrediction::Points(int frame, const FrameStates& states) const {
  Eigen::MatrixXd points = observation_->PointsAt(stencils_[frame], states);
  if (correction_.is_identity()) return points;
  const Eigen::Index num_changes = points.cols() - 1;
  points.col(0) = correction_.Apply(points.col(0));
  if (num_changes > 0) points.rightCols(num_changes) = correction_.Rotate(points.rightCols(num_changes));
  return points;
}

Eigen::VectorXd FramePrediction::Velocities(int frame, const FrameStates& states) const {
  const Eigen::VectorXd velocities = observation_->VelocitiesAt(stencils_[frame], states);
  return correction_.is_identity() ? velocities : Eigen::VectorXd(correction_.Rotate(velocities));
}

Eigen::VectorXd FramePrediction::Derivative(ParameterId id, const Eigen::VectorXd& points,
                                            const Eigen::VectorXd& velocities) const {
  if (id.kind == ParameterKind::kTimeOffset) return velocities;
  if (id.kind == ParameterKind::kTurn) return correction_.TurnDerivative(id.axis, points);
  Eigen::VectorXd derivative = Eigen::VectorXd::Zero(points.size());
  if (id.kind == ParameterKind::kShift) {
    for (Eigen::Index row = id.axis; row < points.size(); row += 3) derivative[row] = 1.0;
  }
  return derivative;
}

void FramePrediction::AddSeeds(int step, FramesOf frames, const Eigen::MatrixXd& seeds,
                               const ResidualDerivative& derivative, Eigen::MatrixXd* gradient) const {
  const auto [first, end] = FramesAt(step, stencils_);
  if (first == end) return;
  Eigen::MatrixXd corrected;
  if (!correction_.is_identity()) corrected = Eigen::MatrixXd::Zero(gradient->rows(), gradient->cols());
  Eigen::MatrixXd* const sum = correction_.is_identity() ? gradient : &corrected;
  for (int frame = first; frame < end; ++frame) {
    const bool is_ending = stencils_[frame].last_step() == step;
    if (frames != FramesOf::kAll && is_ending != (frames == FramesOf::kEnding)) continue;
    const double weight = stencils_[frame].weight(step);
    if (weight != 0.0) derivative.AddFrameSeeds(frame, weight, seeds, sum);
  }
  if (!correction_.is_identity()) *gradient += correction_.RotateBack(corrected);
}

}  // namespace clothid
