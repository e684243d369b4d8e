#include "costs/prediction/recording_model.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "costs/assimilation/recording_correction.h"
#include "costs/prediction/force_prediction.h"
#include "costs/prediction/frame_prediction.h"
#include "datasets/observation/residual_derivative.h"
#include "sim/base/error.h"
#include "sim/cloth/cloth_model.h"
#include "sim/rollout/pair_forces.h"
#include "sim/scene/material_field.h"

namespace clothid {
namespace {

// Linear where no block is the time offset.
FrameInterpolation InterpolationFor(const RecordedMotion& motion, const BlockValues& values,
                                    const Observation& observation) {
  const ParameterBlock* const time_offset = values.Find(ParameterTerm::kClock);
  return time_offset == nullptr ? FrameInterpolation(observation)
                                : FrameInterpolation(motion, time_offset->upper_bound);
}

// The scene whose material has every term that the fit will change.
Scene SceneAtStart(Scene scene, const Parameters& start) {
  scene.SetMaterials(start);
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    scene.obstacles[i].friction_coefficient = start.friction_coefficients[i];
  }
  if (scene.self_contact) scene.self_contact->friction_coefficient = start.self_friction;
  return scene;
}

}  // namespace

RecordingModel::RecordingModel(const RecordedMotion& motion, std::vector<ParameterBlock> blocks, PassObserver observer,
                               std::shared_ptr<const UnknownStart> start, const std::vector<FieldRequest>& fields)
    : name_(motion.name),
      values_(std::move(blocks), motion.scene),
      observation_(motion),
      interpolation_(InterpolationFor(motion, values_, observation_)),
      turn_center_(TurnCenter(motion)),
      simulator_(
          SceneAtStart(values_.Find(ParameterTerm::kHandles) != nullptr ? WithHandlePath(motion.scene) : motion.scene,
                       values_.start())),
      start_(std::move(start)),
      times_(motion.times),
      observer_(std::move(observer)) {
  if (start_ == nullptr && IsUnknown(motion.start_source)) start_ = std::make_shared<const UnknownStart>(motion);
  if (!fields.empty()) fields_.emplace(fields, scene(), name_);
  if (const ParameterBlock* size = values_.Find(ParameterTerm::kSize)) {
    FrontAxes(scene().mesh, "parameter '" + size->name + "': " + motion.name);
  }
  if (values_.Find(ParameterTerm::kHandles) == nullptr) return;
  const bool turns = values_.Find(ParameterKind::kHandleTurn) != nullptr;
  handle_correction_.emplace(scene(), HandleGroups(motion), start_ ? start_->handle_knots() : Eigen::VectorXd(), turns);
}

Eigen::VectorXd RecordingModel::StartUnknowns(const Eigen::VectorXd& coordinates) const {
  if (coordinates.size() == num_blocks()) return Eigen::VectorXd::Zero(num_start_unknowns());
  return coordinates.segment(num_blocks(), num_start_unknowns());
}

Eigen::VectorXd RecordingModel::FieldUnknownsOf(const Eigen::VectorXd& coordinates) const {
  if (coordinates.size() < num_coordinates()) return Eigen::VectorXd::Zero(num_field_unknowns());
  return coordinates.tail(num_field_unknowns());
}

Parameters RecordingModel::ParametersAt(const Eigen::VectorXd& coordinates) const {
  Parameters parameters = values_.ParametersAt(coordinates);
  if (fields_) parameters.fields = fields_->FactorsAt(FieldUnknownsOf(coordinates));
  return parameters;
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

std::string RecordingModel::WhyNotAssimilated() const {
  if (observation_.coordinates().empty() || !observation_.forces().is_empty()) return "has forces at its handles";
  if (interpolation_.has_slopes()) return "has a clock that is fitted";
  if (values_.Find(ParameterTerm::kFrame) != nullptr) return "has a frame of reference that is fitted";
  return {};
}

void RecordingModel::Assimilate(const Assimilation& assimilation, const RobustLoss& loss) {
  correction_ = nullptr;
  if (!assimilation.is_on()) return;
  const std::string reason = WhyNotAssimilated();
  if (!reason.empty()) throw std::logic_error(name_ + " " + reason + "; it corrects nothing");
  InfluenceOf influence;
  if (loss.is_robust()) influence = [loss](double squared) { return InfluenceOn(loss, squared); };
  correction_ = std::make_shared<const RecordingCorrection>(assimilation, std::move(influence), observation_, times_,
                                                            simulator_.model());
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
                                                const AdjointOptions& options, Precision precision,
                                                const AddPositionGradient& add_pair_force_seeds,
                                                const AddPositionGradient& add_corrected_seeds) {
  const auto add_position_gradient = [&](int step, Eigen::MatrixXd* gradient) {
    add_seeds(step, gradient);
    Observe(RolloutPass::kReverseSweep, num_steps() - step, /*passes_left=*/0);
  };
  AdjointOptions with_threshold = options;
  with_threshold.threshold = options.threshold.value_or(SolverAt(precision).adjoint_tolerance);
  return clothid::PullBack(rollout, parameters, static_cast<int>(num_columns), add_position_gradient, &simulator_,
                           with_threshold, add_pair_force_seeds, add_corrected_seeds);
}

Rollout RecordingModel::Simulate(const Eigen::VectorXd& coordinates, const PassOptions& pass,
                                 const RolloutStorage& storage, Eigen::MatrixXd* predicted, Eigen::MatrixXd* velocities,
                                 ForceTrack* forces) {
  const FramePrediction prediction = PredictionAt(coordinates);
  const std::optional<ForcePrediction> force_prediction = forces == nullptr ? std::nullopt : ForcesAt(coordinates);
  if (forces != nullptr) *forces = ForceTrack();
  if (force_prediction) {
    forces->states.resize(3 * static_cast<Eigen::Index>(force_prediction->forces().nodes().size()), num_steps() + 1);
    if (scene().self_contact) {
      forces->pair_forces.setZero(3 * static_cast<Eigen::Index>(scene().handles.nodes.size()), num_steps() + 1);
    }
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
  const bool has_pair_forces = force_prediction && scene().self_contact;
  options.correction = correction_;
  if (has_pair_forces || correction_ != nullptr) {
    options.end_visitor = [&, has_pair_forces, parameters = ParametersAt(coordinates)](int step,
                                                                                       const StepRecord& end) {
      if (has_pair_forces) forces->pair_forces.col(step) = PairForces(simulator_.model(), parameters, end);
      if (end.correction != nullptr) sampler.ReplaceStep(step, end.correction->positions);
    };
  }
  Rollout rollout = RunRollout(coordinates, pass, std::move(options));
  if (force_prediction && rollout.ok()) {
    forces->predicted = force_prediction->At(forces->states, forces->pair_forces);
  }
  return rollout;
}

RolloutCheck RecordingModel::CheckAt(const Eigen::VectorXd& coordinates, const std::atomic<bool>* cancel) {
  simulator_.UseParameters(ParametersAt(coordinates));
  if (!MayGainEnergy(ParametersAt(coordinates), simulator_)) return {};
  RolloutOptions options;
  options.checkpoint_interval = CheckpointInterval(simulator_.model(), num_steps(), RolloutStorage().memory_limit);
  const Rollout rollout = RunRollout(coordinates, {Precision::kFull, cancel}, std::move(options));
  if (!rollout.ok()) return {};
  return {FindEnergyGain(rollout, &simulator_), AuditSelfContact(rollout, &simulator_)};
}

Eigen::MatrixXd RecordingModel::PullBack(const Rollout& rollout, const Eigen::MatrixXd& predicted,
                                         const Eigen::MatrixXd& velocities, const Eigen::VectorXd& coordinates,
                                         const std::vector<int>& active, const Eigen::MatrixXd& seeds,
                                         const AdjointOptions& options, Precision precision, const ForceTrack* forces) {
  using FramesOf = FramePrediction::FramesOf;
  const FramePrediction prediction = PredictionAt(coordinates);
  const ResidualDerivative derivative(&observation_, predicted);
  const SortedBlocks sorted = values_.Sort(active, num_start_unknowns());
  const auto is_all_or_none = [](const std::vector<int>& places, int count) {
    return places.empty() || static_cast<int>(places.size()) == count;
  };
  if (!is_all_or_none(sorted.start_places, num_start_unknowns()) ||
      !is_all_or_none(sorted.field_places, num_field_unknowns())) {
    throw std::logic_error("derivatives along some unknowns of a start or of fields; expected all or none");
  }
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
    const bool is_corrected = correction_ != nullptr && correction_->Corrects(step);
    prediction.AddSeeds(step, is_corrected ? FramesOf::kEnding : FramesOf::kAll, seeds, derivative, gradient);
    if (force_seeds) force_seeds->AddTo(step, gradient);
  };
  AddPositionGradient add_pair_force_seeds;
  if (force_seeds && scene().self_contact) {
    add_pair_force_seeds = [&](int, Eigen::MatrixXd* gradient) { force_seeds->AddPairForcesTo(gradient); };
  }
  AddPositionGradient add_corrected_seeds;
  if (correction_ != nullptr) {
    add_corrected_seeds = [&](int step, Eigen::MatrixXd* gradient) {
      prediction.AddSeeds(step, FramesOf::kGoingOn, seeds, derivative, gradient);
    };
  }
  const RolloutGradient gradient = RunReverseSweep(rollout, sorted.parameters, seeds.cols(), add_seeds, options,
                                                   precision, add_pair_force_seeds, add_corrected_seeds);
  Eigen::MatrixXd all(static_cast<Eigen::Index>(active.size()), seeds.cols());
  all(sorted.parameter_places, Eigen::all) = gradient.parameters;
  if (force_seeds) all(sorted.parameter_places, Eigen::all) += force_seeds->parameter_gradient();
  SetStartRows(gradient, coordinates, sorted, &all);
  if (!sorted.field_places.empty()) {
    Eigen::MatrixXd by_triangle = gradient.fields;
    if (force_seeds && force_seeds->field_gradient().size() > 0) by_triangle += force_seeds->field_gradient();
    all(sorted.field_places, Eigen::all) = fields_->PullBack(by_triangle);
  }
  SetCorrectionRows(prediction, sorted, predicted, velocities, derivative, seeds, &all);
  return values_.DerivativesAt(coordinates, active).asDiagonal() * all;
}

void RecordingModel::SetCorrectionRows(const FramePrediction& prediction, const SortedBlocks& active,
                                       const Eigen::MatrixXd& predicted, const Eigen::MatrixXd& velocities,
                                       const ResidualDerivative& derivative, const Eigen::MatrixXd& seeds,
                                       Eigen::MatrixXd* gradient) const {
  Eigen::MatrixXd change(predicted.rows(), predicted.cols());
  for (std::size_t i = 0; i < active.corrections.size(); ++i) {
    const ParameterId id = active.corrections[i];
    if (id.kind == ParameterKind::kForceBias) {
      gradient->row(active.correction_places[i]) = ForceBiasDerivative(id).transpose() * seeds;
      continue;
    }
    const bool needs_velocities = id.kind == ParameterKind::kTimeOffset;
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

}  // namespace clothid
