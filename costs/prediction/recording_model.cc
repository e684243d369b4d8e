#include "costs/prediction/recording_model.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "costs/prediction/aligned_prediction.h"
#include "sim/cloth/cloth_model.h"

namespace clothid {
namespace {

std::vector<std::optional<AlignmentId>> ParseAlignmentIds(const std::vector<ParameterBlock>& blocks) {
  std::vector<std::optional<AlignmentId>> ids;
  for (const ParameterBlock& block : blocks) ids.push_back(ParseAlignmentId(BaseName(block.name)));
  return ids;
}

std::vector<ParameterId> ParseIds(const std::vector<ParameterBlock>& blocks, const Scene& scene) {
  std::vector<ParameterId> ids;
  for (const ParameterBlock& block : blocks) {
    const std::string name = BaseName(block.name);
    ids.push_back(ParseAlignmentId(name) ? ParameterId() : ParseParameter(name, scene.obstacle_names()));
  }
  return ids;
}

Parameters StartParameters(const std::vector<ParameterBlock>& blocks, const Scene& scene) {
  Parameters parameters = scene.nominal_parameters();
  const std::vector<ParameterId> ids = ParseIds(blocks, scene);
  const std::vector<std::optional<AlignmentId>> alignment_ids = ParseAlignmentIds(blocks);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!alignment_ids[i]) SetParameter(ids[i], blocks[i].start, &parameters);
  }
  return parameters;
}

// Nothing where no block is a parameter of the recording itself.
std::optional<FrameInterpolation> InterpolationFor(const RecordedMotion& motion,
                                                   const std::vector<ParameterBlock>& blocks,
                                                   const Observation& observation) {
  const std::vector<std::optional<AlignmentId>> ids = ParseAlignmentIds(blocks);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (ids[i] && ids[i]->kind == AlignmentKind::kTimeOffset) return FrameInterpolation(motion, blocks[i].upper_bound);
  }
  const bool has_any = std::any_of(ids.begin(), ids.end(), [](const auto& id) { return id.has_value(); });
  return has_any ? std::optional(FrameInterpolation(observation)) : std::nullopt;
}

// [3N x q]: in every column each node moves at 1 m/s along one of `axes` [q].
Eigen::MatrixXd UniformVelocities(int num_nodes, const std::vector<int>& axes) {
  Eigen::MatrixXd velocities = Eigen::MatrixXd::Zero(3 * num_nodes, static_cast<Eigen::Index>(axes.size()));
  for (std::size_t i = 0; i < axes.size(); ++i) {
    for (int node = 0; node < num_nodes; ++node) velocities(3 * node + axes[i], static_cast<Eigen::Index>(i)) = 1.0;
  }
  return velocities;
}

// The scene whose material has every term that the fit will change.
Scene SceneAtStart(Scene scene, const Parameters& start) {
  scene.material = start.material;
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    scene.obstacles[i].friction_coefficient = start.friction_coefficients[i];
  }
  return scene;
}

}  // namespace

RecordingModel::RecordingModel(const RecordedMotion& motion, std::vector<ParameterBlock> blocks, PassObserver observer)
    : name_(motion.name),
      blocks_(std::move(blocks)),
      ids_(ParseIds(blocks_, motion.scene)),
      alignment_ids_(ParseAlignmentIds(blocks_)),
      start_(StartParameters(blocks_, motion.scene)),
      observation_(motion),
      interpolation_(InterpolationFor(motion, blocks_, observation_)),
      turn_center_(TurnCenter(motion)),
      initial_velocities_(motion.scene.initial_velocities),
      full_precision_(motion.scene.solver),
      simulator_(SceneAtStart(motion.scene, start_)),
      observer_(std::move(observer)) {}

Parameters RecordingModel::ParametersAt(const Eigen::VectorXd& coordinates) const {
  Parameters parameters = start_;
  for (int i = 0; i < num_blocks(); ++i) {
    if (!alignment_ids_[i]) SetParameter(ids_[i], blocks_[i].ToValue(coordinates[i]), &parameters);
  }
  return parameters;
}

Alignment RecordingModel::AlignmentAt(const Eigen::VectorXd& coordinates) const {
  Alignment alignment;
  for (int i = 0; i < num_blocks(); ++i) {
    if (alignment_ids_[i]) alignment.Set(*alignment_ids_[i], blocks_[i].ToValue(coordinates[i]));
  }
  return alignment;
}

AlignedPrediction RecordingModel::PredictionAt(const Eigen::VectorXd& coordinates) const {
  return AlignedPrediction(AlignmentAt(coordinates), turn_center_, *interpolation_, &observation_);
}

void RecordingModel::SetStartVelocity(const Eigen::VectorXd& coordinates) {
  const Eigen::Vector3d velocity = AlignmentAt(coordinates).start_velocity;
  Eigen::VectorXd velocities = initial_velocities_;
  for (int node : simulator_.model().free_nodes()) velocities.segment<3>(3 * node) += velocity;
  simulator_.SetInitialVelocities(velocities);
}

RecordingModel::SortedBlocks RecordingModel::Sort(const std::vector<int>& active) const {
  SortedBlocks sorted;
  for (int place = 0; place < static_cast<int>(active.size()); ++place) {
    const std::optional<AlignmentId>& id = alignment_ids_[active[place]];
    if (!id) {
      sorted.parameters.push_back(ids_[active[place]]);
      sorted.parameter_places.push_back(place);
    } else if (id->kind == AlignmentKind::kStartVelocity) {
      sorted.velocity_axes.push_back(id->axis);
      sorted.velocity_places.push_back(place);
    } else {
      sorted.corrections.push_back(*id);
      sorted.correction_places.push_back(place);
    }
  }
  return sorted;
}

Eigen::VectorXd RecordingModel::ValueDerivatives(const Eigen::VectorXd& coordinates,
                                                 const std::vector<int>& active) const {
  Eigen::VectorXd derivatives(static_cast<Eigen::Index>(active.size()));
  for (Eigen::Index i = 0; i < derivatives.size(); ++i) {
    derivatives[i] = blocks_[active[i]].ValueDerivative(coordinates[active[i]]);
  }
  return derivatives;
}

SolverOptions RecordingModel::SolverAt(Precision precision) const {
  SolverOptions solver = full_precision_;
  if (precision == Precision::kLoose) {
    solver.step_tolerance = std::max(solver.step_tolerance, kLooseStepTolerance);
    solver.adjoint_tolerance = std::max(solver.adjoint_tolerance, kLooseAdjointTolerance);
  }
  return solver;
}

void RecordingModel::UsePrecision(Precision precision) {
  const SolverOptions solver = SolverAt(precision);
  simulator_.SetTolerances(solver.step_tolerance, solver.adjoint_tolerance);
}

Rollout RecordingModel::RunRollout(const Eigen::VectorXd& coordinates, const SweepOptions& sweep,
                                   RolloutOptions options) {
  if (observer_) {
    options.visitor = [this, sweep, visit = std::move(options.visitor)](int step, const Eigen::VectorXd& positions) {
      if (visit) visit(step, positions);
      Observe(RolloutPass::kRollout, step, sweep.sweeps_left);
    };
  }
  UsePrecision(sweep.precision);
  return clothid::Simulate(ParametersAt(coordinates), num_steps(), &simulator_, sweep.cancel, options);
}

RolloutGradient RecordingModel::RunReverseSweep(const Rollout& rollout, const std::vector<ParameterId>& parameters,
                                                Eigen::Index num_columns, const AddPositionGradient& add_seeds,
                                                const AdjointOptions& options, Precision precision) {
  const auto add_position_gradient = [&](int step, Eigen::MatrixXd* gradient) {
    add_seeds(step, gradient);
    Observe(RolloutPass::kReverseSweep, num_steps() - step, /*sweeps_left=*/0);
  };
  UsePrecision(precision);
  return clothid::PullBack(rollout, parameters, static_cast<int>(num_columns), add_position_gradient, &simulator_,
                           options);
}

SensitivityResult RecordingModel::RunForwardSweep(const Eigen::VectorXd& coordinates,
                                                  const SensitivityDirections& directions,
                                                  const SensitivityVisitor& visitor, const SweepOptions& sweep) {
  const auto add_step = [&](int step, const Eigen::VectorXd& positions, const Eigen::MatrixXd& derivative) {
    visitor(step, positions, derivative);
    Observe(RolloutPass::kForwardSweep, step, sweep.sweeps_left);
  };
  UsePrecision(sweep.precision);
  return clothid::PushForward(ParametersAt(coordinates), num_steps(), directions, add_step, &simulator_, sweep.cancel);
}

Rollout RecordingModel::Simulate(const Eigen::VectorXd& coordinates, const SweepOptions& sweep,
                                 const RolloutStorage& storage, Eigen::MatrixXd* predicted,
                                 Eigen::MatrixXd* velocities) {
  RolloutOptions options;
  if (storage.keep_factors) options.factor_memory = storage.memory_limit;
  options.checkpoint_interval = CheckpointInterval(simulator_.model(), num_steps(), storage.memory_limit);
  if (velocities != nullptr) velocities->resize(0, 0);
  if (is_aligned()) return SimulateAligned(coordinates, sweep, options, predicted, velocities);
  FrameSampler sampler(&observation_,
                       [predicted](int frame, const Eigen::MatrixXd& points) { predicted->col(frame) = points; });
  if (predicted != nullptr) {
    predicted->resize(observation_.num_predicted(), observation_.num_frames());
    options.visitor = [&sampler](int step, const Eigen::VectorXd& positions) { sampler.AddStep(step, positions); };
  }
  return RunRollout(coordinates, sweep, std::move(options));
}

Rollout RecordingModel::SimulateAligned(const Eigen::VectorXd& coordinates, const SweepOptions& sweep,
                                        RolloutOptions options, Eigen::MatrixXd* predicted,
                                        Eigen::MatrixXd* velocities) {
  const AlignedPrediction prediction = PredictionAt(coordinates);
  for (Eigen::MatrixXd* matrix : {predicted, velocities}) {
    if (matrix != nullptr) matrix->resize(observation_.num_predicted(), observation_.num_frames());
  }
  FrameStateSampler sampler =
      prediction.MakeSampler([predicted, velocities](int frame, const Eigen::VectorXd& points,
                                                     const Eigen::VectorXd& velocity, const Eigen::MatrixXd&) {
        if (predicted != nullptr) predicted->col(frame) = points;
        if (velocities != nullptr) velocities->col(frame) = velocity;
      });
  options.visitor = [&sampler](int step, const Eigen::VectorXd& positions) { sampler.AddStep(step, positions); };
  SetStartVelocity(coordinates);
  return RunRollout(coordinates, sweep, std::move(options));
}

Eigen::MatrixXd RecordingModel::PullBack(const Rollout& rollout, const Eigen::MatrixXd& predicted,
                                         const Eigen::MatrixXd& velocities, const Eigen::VectorXd& coordinates,
                                         const std::vector<int>& active, const Eigen::MatrixXd& seeds,
                                         const AdjointOptions& options, Precision precision) {
  if (is_aligned()) {
    if (velocities.size() == 0) {
      throw std::logic_error("the derivatives of a recording's own parameters need the velocities of its points");
    }
    return PullBackAligned(rollout, predicted, velocities, coordinates, active, seeds, options, precision);
  }
  const std::vector<CloudRows> cloud_rows = observation_.LinearizeClouds(predicted);
  const auto add_seeds = [&](int step, Eigen::MatrixXd* gradient) {
    observation_.AddSeeds(step, seeds, gradient, cloud_rows);
  };
  const RolloutGradient gradient =
      RunReverseSweep(rollout, Sort(active).parameters, seeds.cols(), add_seeds, options, precision);
  return ValueDerivatives(coordinates, active).asDiagonal() * gradient.parameters;
}

Eigen::MatrixXd RecordingModel::PullBackAligned(const Rollout& rollout, const Eigen::MatrixXd& predicted,
                                                const Eigen::MatrixXd& velocities, const Eigen::VectorXd& coordinates,
                                                const std::vector<int>& active, const Eigen::MatrixXd& seeds,
                                                const AdjointOptions& options, Precision precision) {
  const AlignedPrediction prediction = PredictionAt(coordinates);
  const SortedBlocks sorted = Sort(active);
  const std::vector<CloudRows> cloud_rows = observation_.LinearizeClouds(predicted);
  const auto add_seeds = [&](int step, Eigen::MatrixXd* gradient) {
    prediction.AddSeeds(step, seeds, gradient, cloud_rows);
  };
  const RolloutGradient gradient =
      RunReverseSweep(rollout, sorted.parameters, seeds.cols(), add_seeds, options, precision);
  Eigen::MatrixXd all(static_cast<Eigen::Index>(active.size()), seeds.cols());
  all(sorted.parameter_places, Eigen::all) = gradient.parameters;
  all(sorted.velocity_places, Eigen::all) =
      UniformVelocities(observation_.num_nodes(), sorted.velocity_axes).transpose() * gradient.initial_velocities;
  Eigen::MatrixXd derivative(predicted.rows(), predicted.cols());
  for (std::size_t i = 0; i < sorted.corrections.size(); ++i) {
    for (Eigen::Index frame = 0; frame < predicted.cols(); ++frame) {
      derivative.col(frame) = prediction.Derivative(sorted.corrections[i], predicted.col(frame), velocities.col(frame));
    }
    all.row(sorted.correction_places[i]) = observation_.ResidualDerivative(derivative, cloud_rows).transpose() * seeds;
  }
  return ValueDerivatives(coordinates, active).asDiagonal() * all;
}

SensitivityResult RecordingModel::PushForward(const Eigen::VectorXd& coordinates, const std::vector<int>& active,
                                              const FrameVisitor& visitor, const SweepOptions& sweep) {
  if (is_aligned()) return PushForwardAligned(coordinates, active, visitor, sweep);
  const Eigen::VectorXd derivatives = ValueDerivatives(coordinates, active);
  const Eigen::Index num_active = derivatives.size();
  FrameSampler sampler(&observation_, [&](int frame, const Eigen::MatrixXd& points) {
    Eigen::VectorXd residuals;
    Eigen::MatrixXd jacobian;
    observation_.LinearizeFrame(frame, points, &residuals, &jacobian);
    visitor(frame, points.col(0), residuals, jacobian * derivatives.asDiagonal());
  });
  SensitivityDirections directions;
  directions.parameters = Sort(active).parameters;
  Eigen::MatrixXd state(3 * observation_.num_nodes(), 1 + num_active);
  const auto add_step = [&](int step, const Eigen::VectorXd& positions, const Eigen::MatrixXd& derivative) {
    state.col(0) = positions;
    state.rightCols(num_active) = derivative;
    sampler.AddStep(step, state);
  };
  return RunForwardSweep(coordinates, directions, add_step, sweep);
}

SensitivityResult RecordingModel::PushForwardAligned(const Eigen::VectorXd& coordinates, const std::vector<int>& active,
                                                     const FrameVisitor& visitor, const SweepOptions& sweep) {
  const AlignedPrediction prediction = PredictionAt(coordinates);
  const SortedBlocks sorted = Sort(active);
  const Eigen::VectorXd derivatives = ValueDerivatives(coordinates, active);
  // The columns of the sweep: parameters of the simulation, then those of the start velocity.
  std::vector<int> places = sorted.parameter_places;
  places.insert(places.end(), sorted.velocity_places.begin(), sorted.velocity_places.end());
  // The prediction and its derivatives, in the order of `active`.
  Eigen::MatrixXd points_with_derivatives(observation_.num_predicted(), 1 + derivatives.size());
  FrameStateSampler sampler = prediction.MakeSampler(
      [&](int frame, const Eigen::VectorXd& points, const Eigen::VectorXd& velocities, const Eigen::MatrixXd& changes) {
        points_with_derivatives.col(0) = points;
        for (std::size_t i = 0; i < places.size(); ++i) {
          points_with_derivatives.col(1 + places[i]) = changes.col(static_cast<Eigen::Index>(i));
        }
        for (std::size_t i = 0; i < sorted.corrections.size(); ++i) {
          points_with_derivatives.col(1 + sorted.correction_places[i]) =
              prediction.Derivative(sorted.corrections[i], points, velocities);
        }
        Eigen::VectorXd residuals;
        Eigen::MatrixXd jacobian;
        observation_.LinearizeFrame(frame, points_with_derivatives, &residuals, &jacobian);
        visitor(frame, points, residuals, jacobian * derivatives.asDiagonal());
      });

  SensitivityDirections directions;
  directions.parameters = sorted.parameters;
  directions.initial_velocities = UniformVelocities(observation_.num_nodes(), sorted.velocity_axes);
  Eigen::MatrixXd state(3 * observation_.num_nodes(), 1 + static_cast<Eigen::Index>(places.size()));
  const auto add_step = [&](int step, const Eigen::VectorXd& positions, const Eigen::MatrixXd& derivative) {
    state.col(0) = positions;
    state.rightCols(derivative.cols()) = derivative;
    sampler.AddStep(step, state);
  };
  SetStartVelocity(coordinates);
  return RunForwardSweep(coordinates, directions, add_step, sweep);
}

}  // namespace clothid
