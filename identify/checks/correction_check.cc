#include "identify/checks/correction_check.h"

#include <algorithm>
#include <cmath>

#include "costs/prediction/recording_model.h"
#include "costs/prediction/rollout_cost_options.h"
#include "identify/checks/lead_time.h"
#include "sim/cloth/cloth_model.h"
#include "sim/rollout/correction.h"

namespace clothid {
namespace {

// The changes of velocities [3N x T] that corrections made in the steps in which frames end; empty where the rollout
// did not keep its steps.
Eigen::MatrixXd VelocityChanges(const RecordingModel& model, const Rollout& rollout) {
  const std::vector<FrameStencil>& stencils = model.observation().stencils();
  Eigen::MatrixXd changes = Eigen::MatrixXd::Zero(rollout.initial_positions.size(), model.times().size());
  if (rollout.checkpoint_interval > 0) return {};
  for (Eigen::Index frame = 0; frame < changes.cols(); ++frame) {
    const int step = stencils[static_cast<std::size_t>(frame)].last_step();
    if (step < 1) continue;
    const StepRecord& end = rollout.records[static_cast<std::size_t>(rollout.last_record[step - 1])];
    if (end.correction) changes.col(frame) = end.correction->velocities - end.velocities;
  }
  return changes;
}

// rho [N] kg/m^2 of the nodes, air that moves with them included; 0 of handles.
Eigen::VectorXd MassPerArea(const ClothModel& cloth, const Material& material) {
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(cloth.num_nodes());
  for (const int node : cloth.free_nodes()) mass[node] = cloth.mass(material, node) / cloth.node_areas()[node];
  return mass;
}

}  // namespace

MissingForce ForceOfChanges(const Eigen::MatrixXd& changes, const Eigen::VectorXd& times, const Eigen::VectorXd& mass,
                            double gravity) {
  MissingForce missing;
  const Eigen::Index num_frames = changes.cols(), num_nodes = mass.size();
  missing.forces = Eigen::MatrixXd::Zero(3 * num_nodes, num_frames);
  for (Eigen::Index i = 1; i < num_frames; ++i) {
    const double interval = times[i] - times[i - 1];
    for (Eigen::Index node = 0; node < num_nodes; ++node) {
      missing.forces.col(i).segment<3>(3 * node) = mass[node] / interval * changes.col(i).segment<3>(3 * node);
    }
  }
  const double num_moving = static_cast<double>((mass.array() > 0.0).count());
  if (num_frames < 3 || num_moving == 0.0) return missing;
  missing.weight = gravity * mass.sum() / num_moving;
  Eigen::MatrixXd products(num_nodes, num_frames - 2);  // of consecutive frames, from the second on
  for (Eigen::Index i = 0; i < products.cols(); ++i) {
    for (Eigen::Index node = 0; node < num_nodes; ++node) {
      products(node, i) =
          missing.forces.col(i + 1).segment<3>(3 * node).dot(missing.forces.col(i + 2).segment<3>(3 * node));
    }
  }
  const auto root = [](double square) { return std::sqrt(std::max(0.0, square)); };
  Eigen::Index frame = 0, node = 0;
  const Eigen::VectorXd over_cloth = products.colwise().sum().transpose() / num_moving;
  const Eigen::VectorXd over_time = products.rowwise().mean();
  missing.size = root(over_cloth.mean());
  missing.largest_in_frame = root(over_cloth.maxCoeff(&frame));
  missing.largest_at_node = root(over_time.maxCoeff(&node));
  missing.frame = static_cast<int>(frame) + 2;
  missing.node = static_cast<int>(node);
  missing.time = times[missing.frame] - times[0];
  return missing;
}

namespace {

constexpr double kLastingMemory = 0.1;  // s

// Of the memories that were tried the one nearest to that, as a factor; none tried: that of the end.
Assimilation LastingAssimilation(const FitSummary& summary) {
  Assimilation nearest = LastAssimilation(summary);
  const auto distance = [](double memory) { return std::abs(std::log(memory / kLastingMemory)); };
  for (const MemoryTrial& trial : summary.memory_trials) {
    if (distance(trial.memory) < distance(nearest.memory)) nearest = {trial.memory};
  }
  return nearest;
}

// The forces of the rollout of `model` at `coordinates` with the corrections of `assimilation`, and its prediction;
// no forces: it failed, or is too large to be kept.
MissingForce ForceOfRollout(const Assimilation& assimilation, const RobustLoss& loss,
                            const Eigen::VectorXd& coordinates, RecordingModel* model, Eigen::MatrixXd* predicted) {
  model->Assimilate(assimilation, loss);
  const Rollout rollout = model->Simulate(coordinates, {}, {}, predicted);
  const Eigen::MatrixXd changes = rollout.ok() ? VelocityChanges(*model, rollout) : Eigen::MatrixXd();
  if (changes.size() == 0) return {};
  return ForceOfChanges(changes, model->times(), MassPerArea(model->cloth(), rollout.parameters.material),
                        model->scene().gravity.norm());
}

}  // namespace

std::vector<CorrectionCheck> CheckCorrections(const std::vector<RecordedMotion>& motions, const FitProblem& problem,
                                              const FitSummary& summary, const RobustLoss& loss) {
  const Assimilation assimilation = LastAssimilation(summary);
  const Assimilation lasting = LastingAssimilation(summary);
  std::vector<CorrectionCheck> checks;
  for (int r = 0; assimilation.is_on() && r < problem.num_recordings(); ++r) {
    const RecordedMotion& motion = motions[static_cast<std::size_t>(r)];
    const RecordingModel& fitted = problem.cost(r).model();
    RecordingModel model(motion, fitted.blocks(), {}, fitted.shared_start(), problem.fields());
    const Eigen::VectorXd coordinates = problem.CoordinatesOf(r, summary.coordinates);
    Eigen::MatrixXd predicted, ignored;
    CorrectionCheck& check = checks.emplace_back();
    check.missing_force = ForceOfRollout(assimilation, loss, coordinates, &model, &predicted);
    if (check.missing_force.forces.size() == 0) return {};
    check.innovations = model.observation().Compare(predicted);
    const MissingForce told = lasting.memory == assimilation.memory
                                  ? check.missing_force
                                  : ForceOfRollout(lasting, loss, coordinates, &model, &ignored);
    if (told.forces.size() > 0) {
      check.missing_force.lasting = DescribeLastingForce(told.forces, model.times(), model.cloth());
    }
  }
  return checks;
}

std::optional<LastingForce> MeanForce(const std::vector<CorrectionCheck>& corrections) {
  LastingForce mean;
  double num = 0.0;
  for (const CorrectionCheck& check : corrections) {
    const LastingForce& force = check.missing_force.lasting;
    if (!(force.size > 0.0) || !(force.time > 0.0) || !(force.length > 0.0)) continue;
    mean.size += force.size * force.size;
    mean.time += force.time;
    mean.length += force.length;
    num += 1.0;
  }
  if (num == 0.0) return std::nullopt;
  return LastingForce{std::sqrt(mean.size / num), mean.time / num, mean.length / num};
}

}  // namespace clothid
