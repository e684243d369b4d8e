#include "costs/prediction/aligned_prediction.h"

#include <algorithm>
#include <utility>

namespace clothid {

AlignedPrediction::AlignedPrediction(const Alignment& alignment, const Eigen::Vector3d& center,
                                     const FrameInterpolation& interpolation, const Observation* observation)
    : observation_(observation),
      stencils_(interpolation.At(alignment.time_offset)),
      correction_(alignment.turn, alignment.shift, center) {}

FrameStateSampler AlignedPrediction::MakeSampler(Visitor visitor) const {
  return FrameStateSampler(&stencils_, [this, visitor = std::move(visitor)](int frame, const Eigen::MatrixXd& state,
                                                                            const Eigen::VectorXd& velocity) {
    Eigen::MatrixXd nodes(state.rows(), state.cols() + 1);
    nodes.col(0) = correction_.Apply(state.col(0));
    nodes.col(1) = correction_.Rotate(velocity);
    nodes.rightCols(state.cols() - 1) = correction_.Rotate(state.rightCols(state.cols() - 1));
    const Eigen::MatrixXd points = observation_->PointsOf(nodes);
    visitor(frame, points.col(0), points.col(1), points.rightCols(state.cols() - 1));
  });
}

Eigen::VectorXd AlignedPrediction::Derivative(AlignmentId id, const Eigen::VectorXd& points,
                                              const Eigen::VectorXd& velocities) const {
  Eigen::VectorXd derivative = Eigen::VectorXd::Zero(points.size());
  switch (id.kind) {
    case AlignmentKind::kTimeOffset:
      return velocities;
    case AlignmentKind::kShift:
      for (Eigen::Index row = id.axis; row < points.size(); row += 3) derivative[row] = 1.0;
      break;
    case AlignmentKind::kTurn:
      return correction_.TurnDerivative(id.axis, points);
    case AlignmentKind::kStartVelocity:
      break;
  }
  return derivative;
}

void AlignedPrediction::AddSeeds(int step, const Eigen::MatrixXd& seeds, Eigen::MatrixXd* gradient,
                                 const std::vector<CloudRows>& cloud_rows) const {
  const auto ends_before = [](const FrameStencil& stencil, int value) { return stencil.last_step() < value; };
  auto it = std::lower_bound(stencils_.begin(), stencils_.end(), step, ends_before);
  if (it == stencils_.end() || it->first_step > step) return;
  Eigen::MatrixXd corrected = Eigen::MatrixXd::Zero(gradient->rows(), gradient->cols());
  for (; it != stencils_.end() && it->first_step <= step; ++it) {
    const double weight = it->weights[static_cast<std::size_t>(step - it->first_step)];
    if (weight != 0.0) {
      observation_->AddFrameSeeds(static_cast<int>(it - stencils_.begin()), weight, seeds, cloud_rows, &corrected);
    }
  }
  *gradient += correction_.RotateBack(corrected);
}

}  // namespace clothid
