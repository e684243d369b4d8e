// The forward sweeps of RecordingModel: with a rollout of their own, and along one that is at hand.
#include <algorithm>
#include <optional>
#include <vector>

#include "costs/prediction/force_prediction.h"
#include "costs/prediction/frame_prediction.h"
#include "costs/prediction/recording_model.h"

namespace clothid {
namespace {

// Columns that move a start beyond which they are for a Gauss-Newton matrix.
constexpr Eigen::Index kManyColumns = 24;

PairForceVisitor AddingTo(ForceSampler* sampler) {
  return [sampler](int step, const Eigen::VectorXd& forces, const Eigen::MatrixXd& derivative) {
    Eigen::MatrixXd all(forces.size(), 1 + derivative.cols());
    all << forces, derivative;
    sampler->AddPairForces(step, all);
  };
}

}  // namespace

SensitivityResult RecordingModel::PushForward(const Eigen::VectorXd& coordinates, const SweepColumns& columns,
                                              const FrameVisitor& visitor, const PassOptions& pass) {
  const RolloutStart start = StartAt(coordinates);
  SensitivityOptions options;
  start.SetOn(&options);
  options.step_tolerance = SolverAt(pass.precision).step_tolerance;
  options.adjoint_tolerance = ForwardTolerance(columns, pass.precision);
  options.correction = correction_;
  SensitivityResult result;
  SweepFrames(coordinates, columns, visitor, pass.passes_left,
              [&](const SensitivityDirections& directions, const SensitivityVisitor& add_step,
                  const PairForceVisitor& add_pair_forces, const SensitivityVisitor& replace_step) {
                options.pair_force_visitor = add_pair_forces;
                options.corrected_visitor = replace_step;
                result = clothid::PushForward(ParametersAt(coordinates), num_steps(), directions, add_step, &simulator_,
                                              pass.cancel, options);
              });
  return result;
}

void RecordingModel::PushForward(const Rollout& rollout, const Eigen::VectorXd& coordinates,
                                 const SweepColumns& columns, const FrameVisitor& visitor, Precision precision,
                                 int passes_left) {
  SweepFrames(coordinates, columns, visitor, passes_left,
              [&](const SensitivityDirections& directions, const SensitivityVisitor& add_step,
                  const PairForceVisitor& add_pair_forces, const SensitivityVisitor& replace_step) {
                clothid::PushForward(rollout, directions, add_step, &simulator_, ForwardTolerance(columns, precision),
                                     add_pair_forces, replace_step);
              });
}

double RecordingModel::ForwardTolerance(const SweepColumns& columns, Precision precision) const {
  const double tolerance = SolverAt(precision).adjoint_tolerance;
  if (start_ == nullptr || columns.combinations.cols() <= kManyColumns) return tolerance;
  const auto moves_start = (columns.combinations.topRows(num_start_unknowns()).array() != 0.0).colwise().any();
  return moves_start.count() > kManyColumns ? std::max(tolerance, kStartAdjointTolerance) : tolerance;
}

void RecordingModel::SweepFrames(const Eigen::VectorXd& coordinates, const SweepColumns& columns,
                                 const FrameVisitor& visitor, int passes_left, const Sweep& sweep) {
  const FramePrediction prediction = PredictionAt(coordinates);
  const SortedBlocks sorted = values_.Sort(columns.blocks);
  const auto num_blocks = static_cast<Eigen::Index>(columns.blocks.size());
  Eigen::VectorXd derivatives = Eigen::VectorXd::Ones(num_blocks + columns.combinations.cols());
  derivatives.head(num_blocks) = values_.DerivativesAt(coordinates, columns.blocks);
  Eigen::VectorXd residuals;
  Eigen::MatrixXd jacobian;
  FrameSampler sampler(&prediction.stencils(), [&](int frame, const FrameStates& states) {
    const Eigen::MatrixXd points = WithDerivatives(prediction, sorted, frame, states);
    observation_.LinearizeFrame(frame, points, &residuals, &jacobian);
    visitor(frame, points.col(0), residuals, jacobian * derivatives.asDiagonal());
  });
  const SensitivityDirections directions = DirectionsOf(coordinates, sorted, columns.combinations);
  const std::optional<ForcePrediction> forces = ForcesAt(coordinates);
  std::optional<ForceSampler> force_sampler;
  if (forces) {
    const auto visit = [&](int reading, const Eigen::MatrixXd& swept) {
      const Eigen::MatrixXd all = ForcesWithDerivatives(swept, sorted);
      observation_.forces().LinearizeReading(reading, all, &residuals, &jacobian);
      visitor(observation_.num_frames() + reading, all.col(0), residuals, jacobian * derivatives.asDiagonal());
    };
    force_sampler.emplace(&*forces, sorted.parameters, visit, directions.fields);
  }
  const bool has_pair_forces = force_sampler && scene().self_contact;
  const auto joined = [](const Eigen::VectorXd& positions, const Eigen::MatrixXd& derivative) {
    Eigen::MatrixXd state(positions.size(), 1 + derivative.cols());
    state.col(0) = positions;
    state.rightCols(derivative.cols()) = derivative;
    return state;
  };
  const auto add_step = [&](int step, const Eigen::VectorXd& positions, const Eigen::MatrixXd& derivative) {
    const Eigen::MatrixXd state = joined(positions, derivative);
    sampler.AddStep(step, state);
    if (force_sampler) force_sampler->AddStep(step, state);
    Observe(RolloutPass::kForwardSweep, step, passes_left);
  };
  SensitivityVisitor replace_step;
  if (correction_ != nullptr) {
    replace_step = [&](int step, const Eigen::VectorXd& positions, const Eigen::MatrixXd& derivative) {
      sampler.ReplaceStep(step, joined(positions, derivative));
    };
  }
  sweep(directions, add_step, has_pair_forces ? AddingTo(&*force_sampler) : PairForceVisitor(), replace_step);
}

Eigen::MatrixXd RecordingModel::Arranged(const Eigen::MatrixXd& swept, const SortedBlocks& blocks) {
  if (blocks.has_only_parameters()) return swept;
  std::vector<int> places = blocks.parameter_places;
  places.insert(places.end(), blocks.velocity_places.begin(), blocks.velocity_places.end());
  places.insert(places.end(), blocks.handle_places.begin(), blocks.handle_places.end());
  const auto num_swept = static_cast<Eigen::Index>(places.size());
  const Eigen::Index num_combinations = swept.cols() - 1 - num_swept;
  Eigen::MatrixXd all =
      Eigen::MatrixXd::Zero(swept.rows(), swept.cols() + static_cast<Eigen::Index>(blocks.corrections.size()));
  all.col(0) = swept.col(0);
  for (Eigen::Index i = 0; i < num_swept; ++i) all.col(1 + places[i]) = swept.col(1 + i);
  all.rightCols(num_combinations) = swept.rightCols(num_combinations);
  return all;
}

Eigen::MatrixXd RecordingModel::WithDerivatives(const FramePrediction& prediction, const SortedBlocks& blocks,
                                                int frame, const FrameStates& states) const {
  const Eigen::MatrixXd swept = prediction.Points(frame, states);
  Eigen::MatrixXd all = Arranged(swept, blocks);
  if (blocks.corrections.empty()) return all;
  Eigen::VectorXd velocities;
  if (interpolation_.has_slopes()) velocities = prediction.Velocities(frame, states);
  for (std::size_t i = 0; i < blocks.corrections.size(); ++i) {
    all.col(1 + blocks.correction_places[i]) = prediction.Derivative(blocks.corrections[i], swept.col(0), velocities);
  }
  return all;
}

}  // namespace clothid
