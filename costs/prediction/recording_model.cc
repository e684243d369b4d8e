#include "costs/prediction/recording_model.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "costs/prediction/force_prediction.h"
#include "costs/prediction/frame_prediction.h"
#include "datasets/observation/residual_derivative.h"
#include "sim/base/error.h"
#include "sim/cloth/cloth_model.h"
#include "sim/scene/material_field.h"

namespace clothid {
namespace {

// Linear where no block is the time offset.
FrameInterpolation InterpolationFor(const RecordedMotion& motion, const BlockValues& values,
                                    const Observation& observation) {
  const ParameterBlock* const time_offset = values.Find(AlignmentKind::kTimeOffset);
  return time_offset == nullptr ? FrameInterpolation(observation)
                                : FrameInterpolation(motion, time_offset->upper_bound);
}

// Handles that stand still have a path, too, as only a path can be corrected.
Scene WithHandlePath(Scene scene) {
  Handles& handles = scene.handles;
  if (handles.nodes.empty() || handles.path.num_handles() > 0) return scene;
  Eigen::VectorXd places(3 * static_cast<Eigen::Index>(handles.nodes.size()));
  for (std::size_t i = 0; i < handles.nodes.size(); ++i) {
    places.segment<3>(3 * static_cast<Eigen::Index>(i)) = scene.initial_positions.segment<3>(3 * handles.nodes[i]);
  }
  handles.path = HandlePath(Eigen::VectorXd::Constant(1, scene.start_time), places);
  return scene;
}

// Columns of a start beyond which they are for a Gauss-Newton matrix.
constexpr Eigen::Index kManyColumns = 24;

// The scene whose material has every term that the fit will change.
Scene SceneAtStart(Scene scene, const Parameters& start) {
  scene.material = start.material;
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    scene.obstacles[i].friction_coefficient = start.friction_coefficients[i];
  }
  return scene;
}

}  // namespace

RecordingModel::RecordingModel(const RecordedMotion& motion, std::vector<ParameterBlock> blocks, PassObserver observer,
                               std::shared_ptr<const UnknownStart> start)
    : name_(motion.name),
      values_(std::move(blocks), motion.scene),
      observation_(motion),
      interpolation_(InterpolationFor(motion, values_, observation_)),
      turn_center_(TurnCenter(motion)),
      simulator_(SceneAtStart(values_.move_handles() ? WithHandlePath(motion.scene) : motion.scene, values_.start())),
      start_(std::move(start)),
      observer_(std::move(observer)) {
  if (start_ == nullptr && IsUnknown(motion.start_source)) start_ = std::make_shared<const UnknownStart>(motion);
  if (const ParameterBlock* size = values_.FindSize()) {
    FrontAxes(scene().mesh, "parameter '" + size->name + "': " + motion.name);
    if (!observation_.forces().is_empty()) {
      throw Error(ErrorKind::kUsage, "parameter '" + size->name + "': " + motion.name +
                                         " has forces at its handles; expected a recording without them");
    }
  }
  if (!values_.move_handles()) return;
  const bool turns = values_.Find(AlignmentKind::kHandleTurn) != nullptr;
  handle_correction_.emplace(scene(), HandleGroups(motion), start_ ? start_->handle_knots() : Eigen::VectorXd(), turns);
}

FramePrediction RecordingModel::PredictionAt(const Eigen::VectorXd& coordinates) const {
  return FramePrediction(values_.AlignmentAt(coordinates), turn_center_, interpolation_, &observation_);
}

SolverOptions RecordingModel::SolverAt(Precision precision) const {
  SolverOptions solver = scene().solver;
  if (precision == Precision::kLoose) {
    solver.step_tolerance = std::max(solver.step_tolerance, kLooseStepTolerance);
    solver.adjoint_tolerance = std::max(solver.adjoint_tolerance, kLooseAdjointTolerance);
  }
  return solver;
}

Rollout RecordingModel::RunRollout(const Eigen::VectorXd& coordinates, const PassOptions& pass,
                                   RolloutOptions options) {
  if (observer_) {
    options.visitor = [this, pass, visit = std::move(options.visitor)](int step, const Eigen::VectorXd& positions) {
      if (visit) visit(step, positions);
      Observe(RolloutPass::kRollout, step, pass.passes_left);
    };
  }
  const RolloutStart start = StartAt(coordinates);
  start.SetOn(&options);
  options.step_tolerance = SolverAt(pass.precision).step_tolerance;
  return clothid::Simulate(ParametersAt(coordinates), num_steps(), &simulator_, pass.cancel, options);
}

RolloutGradient RecordingModel::RunReverseSweep(const Rollout& rollout, const std::vector<ParameterId>& parameters,
                                                Eigen::Index num_columns, const AddPositionGradient& add_seeds,
                                                const AdjointOptions& options, Precision precision) {
  const auto add_position_gradient = [&](int step, Eigen::MatrixXd* gradient) {
    add_seeds(step, gradient);
    Observe(RolloutPass::kReverseSweep, num_steps() - step, /*passes_left=*/0);
  };
  AdjointOptions with_threshold = options;
  with_threshold.threshold = options.threshold.value_or(SolverAt(precision).adjoint_tolerance);
  return clothid::PullBack(rollout, parameters, static_cast<int>(num_columns), add_position_gradient, &simulator_,
                           with_threshold);
}

SensitivityResult RecordingModel::RunForwardSweep(const Eigen::VectorXd& coordinates,
                                                  const SensitivityDirections& directions,
                                                  const SensitivityVisitor& visitor, const PassOptions& pass) {
  const auto add_step = [&](int step, const Eigen::VectorXd& positions, const Eigen::MatrixXd& derivative) {
    visitor(step, positions, derivative);
    Observe(RolloutPass::kForwardSweep, step, pass.passes_left);
  };
  const SolverOptions solver = SolverAt(pass.precision);
  const RolloutStart start = StartAt(coordinates);
  SensitivityOptions options;
  start.SetOn(&options);
  options.step_tolerance = solver.step_tolerance;
  options.adjoint_tolerance = solver.adjoint_tolerance;
  if (directions.initial_positions.cols() > kManyColumns) {
    options.adjoint_tolerance = std::max(solver.adjoint_tolerance, kStartAdjointTolerance);
  }
  return clothid::PushForward(ParametersAt(coordinates), num_steps(), directions, add_step, &simulator_, pass.cancel,
                              options);
}

Rollout RecordingModel::Simulate(const Eigen::VectorXd& coordinates, const PassOptions& pass,
                                 const RolloutStorage& storage, Eigen::MatrixXd* predicted, Eigen::MatrixXd* velocities,
                                 ForceTrack* forces) {
  const FramePrediction prediction = PredictionAt(coordinates);
  const std::optional<ForcePrediction> force_prediction = forces == nullptr ? std::nullopt : ForcesAt(coordinates);
  if (forces != nullptr) *forces = ForceTrack();
  if (force_prediction) {
    forces->states.resize(3 * static_cast<Eigen::Index>(force_prediction->forces().nodes().size()), num_steps() + 1);
  }
  predicted->resize(observation_.num_predicted(), observation_.num_frames());
  if (velocities != nullptr) velocities->resize(0, 0);
  const bool has_velocities = velocities != nullptr && interpolation_.has_slopes();
  if (has_velocities) velocities->resize(predicted->rows(), predicted->cols());
  FrameSampler sampler(&prediction.stencils(), [&](int frame, const FrameStates& states) {
    predicted->col(frame) = prediction.Points(frame, states);
    if (has_velocities) velocities->col(frame) = prediction.Velocities(frame, states);
  });
  RolloutOptions options;
  if (storage.keep_factors) options.factor_memory = storage.memory_limit;
  options.checkpoint_interval = CheckpointInterval(simulator_.model(), num_steps(), storage.memory_limit);
  options.visitor = [&](int step, const Eigen::VectorXd& positions) {
    sampler.AddStep(step, positions);
    if (force_prediction) forces->states.col(step) = force_prediction->forces().Gather(positions);
  };
  Rollout rollout = RunRollout(coordinates, pass, std::move(options));
  if (force_prediction && rollout.ok()) forces->predicted = force_prediction->At(forces->states);
  return rollout;
}

EnergyGain RecordingModel::EnergyGainAt(const Eigen::VectorXd& coordinates, const std::atomic<bool>* cancel) {
  simulator_.UseParameters(ParametersAt(coordinates));
  if (!MayGainEnergy(ParametersAt(coordinates), simulator_)) return {};
  RolloutOptions options;
  options.checkpoint_interval = CheckpointInterval(simulator_.model(), num_steps(), RolloutStorage().memory_limit);
  const Rollout rollout = RunRollout(coordinates, {Precision::kFull, cancel}, std::move(options));
  return rollout.ok() ? FindEnergyGain(rollout, &simulator_) : EnergyGain();
}

Eigen::MatrixXd RecordingModel::PullBack(const Rollout& rollout, const Eigen::MatrixXd& predicted,
                                         const Eigen::MatrixXd& velocities, const Eigen::VectorXd& coordinates,
                                         const std::vector<int>& active, const Eigen::MatrixXd& seeds,
                                         const AdjointOptions& options, Precision precision, Eigen::MatrixXd* fields,
                                         const ForceTrack* forces) {
  const FramePrediction prediction = PredictionAt(coordinates);
  const ResidualDerivative derivative(&observation_, predicted);
  const SortedBlocks sorted = values_.Sort(active);
  const std::optional<ForcePrediction> force_prediction = ForcesAt(coordinates);
  std::optional<ForceSeeds> force_seeds;
  if (force_prediction) {
    if (forces == nullptr || forces->states.cols() != num_steps() + 1) {
      throw std::logic_error("the adjoint of forces: expected those of the rollout");
    }
    force_seeds.emplace(&*force_prediction, &forces->states, seeds.bottomRows(observation_.forces().num_residuals()),
                        sorted.parameters);
  }
  const auto add_seeds = [&](int step, Eigen::MatrixXd* gradient) {
    prediction.AddSeeds(step, seeds, derivative, gradient);
    if (force_seeds) force_seeds->AddTo(step, gradient);
  };
  const RolloutGradient gradient =
      RunReverseSweep(rollout, sorted.parameters, seeds.cols(), add_seeds, options, precision);
  if (fields != nullptr) *fields = gradient.fields;
  if (fields != nullptr && force_seeds && fields->size() > 0) *fields += force_seeds->field_gradient();
  Eigen::MatrixXd all(static_cast<Eigen::Index>(active.size()), seeds.cols());
  all(sorted.parameter_places, Eigen::all) = gradient.parameters;
  if (force_seeds) all(sorted.parameter_places, Eigen::all) += force_seeds->parameter_gradient();
  SetStartRows(gradient, coordinates, sorted, &all);
  SetCorrectionRows(prediction, sorted, predicted, velocities, derivative, seeds, &all);
  return values_.DerivativesAt(coordinates, active).asDiagonal() * all;
}

void RecordingModel::SetCorrectionRows(const FramePrediction& prediction, const SortedBlocks& active,
                                       const Eigen::MatrixXd& predicted, const Eigen::MatrixXd& velocities,
                                       const ResidualDerivative& derivative, const Eigen::MatrixXd& seeds,
                                       Eigen::MatrixXd* gradient) const {
  Eigen::MatrixXd change(predicted.rows(), predicted.cols());
  for (std::size_t i = 0; i < active.corrections.size(); ++i) {
    const AlignmentId id = active.corrections[i];
    if (id.kind == AlignmentKind::kForceBias) {
      gradient->row(active.correction_places[i]) = ForceBiasDerivative(id).transpose() * seeds;
      continue;
    }
    const bool needs_velocities = id.kind == AlignmentKind::kTimeOffset;
    if (needs_velocities && velocities.size() != predicted.size()) {
      throw std::logic_error("the derivative along the time offset needs the velocities of the prediction");
    }
    for (Eigen::Index frame = 0; frame < predicted.cols(); ++frame) {
      const Eigen::VectorXd velocity = needs_velocities ? velocities.col(frame) : Eigen::VectorXd();
      change.col(frame) = prediction.Derivative(id, predicted.col(frame), velocity);
    }
    gradient->row(active.correction_places[i]) = derivative.Apply(change).transpose() * seeds;
  }
}

Eigen::MatrixXd RecordingModel::Arranged(const Eigen::MatrixXd& swept, const SortedBlocks& active) {
  const auto num_swept = static_cast<Eigen::Index>(active.parameters.size() + active.start_places.size());
  if (active.has_only_parameters()) return swept.leftCols(1 + num_swept);
  std::vector<int> places = active.parameter_places;
  places.insert(places.end(), active.velocity_places.begin(), active.velocity_places.end());
  places.insert(places.end(), active.handle_places.begin(), active.handle_places.end());
  places.insert(places.end(), active.start_places.begin(), active.start_places.end());
  Eigen::MatrixXd all =
      Eigen::MatrixXd::Zero(swept.rows(), 1 + static_cast<Eigen::Index>(places.size() + active.corrections.size()));
  all.col(0) = swept.col(0);
  for (std::size_t i = 0; i < places.size(); ++i) all.col(1 + places[i]) = swept.col(1 + static_cast<Eigen::Index>(i));
  return all;
}

Eigen::MatrixXd RecordingModel::WithDerivatives(const FramePrediction& prediction, const SortedBlocks& active,
                                                int frame, const FrameStates& states) const {
  const Eigen::MatrixXd swept = prediction.Points(frame, states);
  Eigen::MatrixXd all = Arranged(swept, active);
  if (active.corrections.empty()) return all;
  Eigen::VectorXd velocities;
  if (interpolation_.has_slopes()) velocities = prediction.Velocities(frame, states);
  for (std::size_t i = 0; i < active.corrections.size(); ++i) {
    all.col(1 + active.correction_places[i]) = prediction.Derivative(active.corrections[i], swept.col(0), velocities);
  }
  return all;
}

}  // namespace clothid
