// The forward sweeps of RecordingModel: with a rollout of their own, and along one that is at hand.
#include <optional>
#include <vector>

#include "costs/prediction/force_prediction.h"
#include "costs/prediction/frame_prediction.h"
#include "costs/prediction/recording_model.h"

namespace clothid {
namespace {

// Hands positions and derivatives to the samplers, side by side. `forces` may be null.
SensitivityVisitor AddStates(FrameSampler* sampler, ForceSampler* forces = nullptr) {
  return [sampler, forces](int step, const Eigen::VectorXd& positions, const Eigen::MatrixXd& derivative) {
    Eigen::MatrixXd state(positions.size(), 1 + derivative.cols());
    state.col(0) = positions;
    state.rightCols(derivative.cols()) = derivative;
    sampler->AddStep(step, state);
    if (forces != nullptr) forces->AddStep(step, state);
  };
}

}  // namespace

SensitivityResult RecordingModel::PushForward(const Eigen::VectorXd& coordinates, const std::vector<int>& active,
                                              const FrameVisitor& visitor, const PassOptions& pass,
                                              const Eigen::MatrixXd* follow) {
  SensitivityResult result;
  SweepFrames(coordinates, active, follow, visitor,
              [&](const SensitivityDirections& directions, const SensitivityVisitor& add_step) {
                result = RunForwardSweep(coordinates, directions, add_step, pass);
              });
  return result;
}

void RecordingModel::PushForward(const Rollout& rollout, const Eigen::VectorXd& coordinates,
                                 const std::vector<int>& active, const FrameVisitor& visitor, Precision precision) {
  SweepFrames(coordinates, active, nullptr, visitor,
              [&](const SensitivityDirections& directions, const SensitivityVisitor& add_step) {
                clothid::PushForward(rollout, directions, add_step, &simulator_, SolverAt(precision).adjoint_tolerance);
              });
}

void RecordingModel::PushForwardFields(const Rollout& rollout, const Eigen::VectorXd& coordinates,
                                       const Eigen::MatrixXd& changes, const FrameVisitor& visitor,
                                       Precision precision) {
  const FramePrediction prediction = PredictionAt(coordinates);
  FrameSampler sampler(&prediction.stencils(), [&](int frame, const FrameStates& states) {
    const Eigen::MatrixXd points = prediction.Points(frame, states);
    Eigen::VectorXd residuals;
    Eigen::MatrixXd jacobian;
    observation_.LinearizeFrame(frame, points, &residuals, &jacobian);
    visitor(frame, points.col(0), residuals, jacobian);
  });
  SensitivityDirections directions;
  directions.fields = changes;
  const std::optional<ForcePrediction> forces = ForcesAt(coordinates);
  std::optional<ForceSampler> force_sampler;
  if (forces) {
    const auto visit = [&](int reading, const Eigen::MatrixXd& swept) {
      Eigen::VectorXd residuals;
      Eigen::MatrixXd jacobian;
      observation_.forces().LinearizeReading(reading, swept, &residuals, &jacobian);
      visitor(observation_.num_frames() + reading, swept.col(0), residuals, jacobian);
    };
    force_sampler.emplace(&*forces, std::vector<ParameterId>(), visit, changes);
  }
  clothid::PushForward(rollout, directions, AddStates(&sampler, force_sampler ? &*force_sampler : nullptr), &simulator_,
                       SolverAt(precision).adjoint_tolerance);
}

void RecordingModel::SweepFrames(const Eigen::VectorXd& coordinates, const std::vector<int>& active,
                                 const Eigen::MatrixXd* follow, const FrameVisitor& visitor, const Sweep& sweep) {
  const FramePrediction prediction = PredictionAt(coordinates);
  const SortedBlocks sorted = values_.Sort(active);
  const Eigen::VectorXd derivatives = values_.DerivativesAt(coordinates, active);
  // Per unit of the values, as all other columns.
  Eigen::MatrixXd along;
  if (follow != nullptr) along = *follow * derivatives.cwiseInverse().asDiagonal();
  FrameSampler sampler(&prediction.stencils(), [&](int frame, const FrameStates& states) {
    Eigen::MatrixXd points = WithDerivatives(prediction, sorted, frame, states);
    if (along.cols() > 0) {
      const Eigen::MatrixXd moved = prediction.Points(frame, states);
      points.rightCols(along.cols()) += moved.rightCols(along.cols());
    }
    Eigen::VectorXd residuals;
    Eigen::MatrixXd jacobian;
    observation_.LinearizeFrame(frame, points, &residuals, &jacobian);
    visitor(frame, points.col(0), residuals, jacobian * derivatives.asDiagonal());
  });
  const SensitivityDirections directions = DirectionsOf(coordinates, sorted, along);
  const std::optional<ForcePrediction> forces = ForcesAt(coordinates);
  if (!forces) return sweep(directions, AddStates(&sampler));
  ForceSampler force_sampler(&*forces, sorted.parameters, [&](int reading, const Eigen::MatrixXd& swept) {
    Eigen::MatrixXd all = ForcesWithDerivatives(swept, sorted);
    if (along.cols() > 0) all.rightCols(along.cols()) += swept.rightCols(along.cols());
    Eigen::VectorXd residuals;
    Eigen::MatrixXd jacobian;
    observation_.forces().LinearizeReading(reading, all, &residuals, &jacobian);
    visitor(observation_.num_frames() + reading, all.col(0), residuals, jacobian * derivatives.asDiagonal());
  });
  sweep(directions, AddStates(&sampler, &force_sampler));
}

}  // namespace clothid
