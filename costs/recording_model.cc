#include "costs/recording_model.h"

#include <algorithm>
#include <utility>

namespace clothid {
namespace {

std::vector<ParameterId> ParseIds(const std::vector<ParameterBlock>& blocks, const Scene& scene) {
  std::vector<ParameterId> ids;
  for (const ParameterBlock& block : blocks) ids.push_back(ParseParameter(block.name, scene.obstacle_names()));
  return ids;
}

Parameters StartParameters(const std::vector<ParameterBlock>& blocks, const Scene& scene) {
  Parameters parameters = scene.nominal_parameters();
  const std::vector<ParameterId> ids = ParseIds(blocks, scene);
  for (std::size_t i = 0; i < blocks.size(); ++i) SetParameter(ids[i], blocks[i].start, &parameters);
  return parameters;
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

RecordingModel::RecordingModel(const RecordedMotion& motion, std::vector<ParameterBlock> blocks)
    : name_(motion.name),
      blocks_(std::move(blocks)),
      ids_(ParseIds(blocks_, motion.scene)),
      start_(StartParameters(blocks_, motion.scene)),
      observation_(motion),
      full_precision_(motion.scene.solver),
      simulator_(SceneAtStart(motion.scene, start_)) {}

Parameters RecordingModel::ParametersAt(const Eigen::VectorXd& coordinates) const {
  Parameters parameters = start_;
  for (int i = 0; i < num_blocks(); ++i) SetParameter(ids_[i], blocks_[i].ToValue(coordinates[i]), &parameters);
  return parameters;
}

std::vector<ParameterId> RecordingModel::Ids(const std::vector<int>& active) const {
  std::vector<ParameterId> ids;
  for (int i : active) ids.push_back(ids_[i]);
  return ids;
}

Eigen::VectorXd RecordingModel::ValueDerivatives(const Eigen::VectorXd& coordinates,
                                                 const std::vector<int>& active) const {
  Eigen::VectorXd derivatives(static_cast<Eigen::Index>(active.size()));
  for (Eigen::Index i = 0; i < derivatives.size(); ++i) {
    derivatives[i] = blocks_[active[i]].ValueDerivative(coordinates[active[i]]);
  }
  return derivatives;
}

void RecordingModel::SetPrecision(Precision precision) {
  double step_tolerance = full_precision_.step_tolerance, adjoint_tolerance = full_precision_.adjoint_tolerance;
  if (precision == Precision::kLoose) {
    step_tolerance = std::max(step_tolerance, kLooseStepTolerance);
    adjoint_tolerance = std::max(adjoint_tolerance, kLooseAdjointTolerance);
  }
  simulator_.SetTolerances(step_tolerance, adjoint_tolerance);
}

Rollout RecordingModel::Simulate(const Eigen::VectorXd& coordinates, const std::atomic<bool>* cancel,
                                 std::size_t memory_limit, bool keep_factors, Eigen::MatrixXd* predicted) {
  const int num_steps = observation_.num_steps();
  RolloutOptions options;
  if (keep_factors) options.factor_memory = memory_limit;
  options.checkpoint_interval = CheckpointInterval(simulator_.model(), num_steps, memory_limit);
  FrameSampler sampler(&observation_,
                       [predicted](int frame, const Eigen::MatrixXd& points) { predicted->col(frame) = points; });
  if (predicted != nullptr) {
    predicted->resize(observation_.num_predicted(), observation_.num_frames());
    options.visitor = [&sampler](int step, const Eigen::VectorXd& positions) { sampler.AddStep(step, positions); };
  }
  return clothid::Simulate(ParametersAt(coordinates), num_steps, &simulator_, cancel, options);
}

Eigen::MatrixXd RecordingModel::PullBack(const Rollout& rollout, const Eigen::MatrixXd& predicted,
                                         const Eigen::VectorXd& coordinates, const std::vector<int>& active,
                                         const Eigen::MatrixXd& seeds, const AdjointOptions& options) {
  const std::vector<CloudRows> cloud_rows = observation_.LinearizeClouds(predicted);
  const auto add_seeds = [&](int step, Eigen::MatrixXd* gradient) {
    observation_.AddSeeds(step, seeds, gradient, cloud_rows);
  };
  const RolloutGradient gradient =
      clothid::PullBack(rollout, Ids(active), static_cast<int>(seeds.cols()), add_seeds, &simulator_, options);
  return ValueDerivatives(coordinates, active).asDiagonal() * gradient.parameters;
}

SensitivityResult RecordingModel::PushForward(const Eigen::VectorXd& coordinates, const std::vector<int>& active,
                                              const FrameVisitor& visitor, const std::atomic<bool>* cancel) {
  const Eigen::VectorXd derivatives = ValueDerivatives(coordinates, active);
  const Eigen::Index num_active = derivatives.size();
  FrameSampler sampler(&observation_, [&](int frame, const Eigen::MatrixXd& points) {
    Eigen::VectorXd residuals;
    Eigen::MatrixXd jacobian;
    observation_.LinearizeFrame(frame, points, &residuals, &jacobian);
    visitor(frame, points.col(0), residuals, jacobian * derivatives.asDiagonal());
  });
  SensitivityDirections directions;
  directions.parameters = Ids(active);
  Eigen::MatrixXd state(3 * observation_.num_nodes(), 1 + num_active);
  const auto add_step = [&](int step, const Eigen::VectorXd& positions, const Eigen::MatrixXd& derivative) {
    state.col(0) = positions;
    state.rightCols(num_active) = derivative;
    sampler.AddStep(step, state);
  };
  return clothid::PushForward(ParametersAt(coordinates), observation_.num_steps(), directions, add_step, &simulator_,
                              cancel);
}

}  // namespace clothid
