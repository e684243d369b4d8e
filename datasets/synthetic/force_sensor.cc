#include "datasets/synthetic/force_sensor.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <utility>

#include "sim/base/error.h"
#include "sim/cloth/cloth_model.h"
#include "sim/rollout/handle_forces.h"
#include "sim/rollout/pair_forces.h"
#include "sim/rollout/simulator.h"

namespace clothid {
namespace {

// After every step [3G x (steps + 1)].
struct Loads {
  Eigen::MatrixXd forces;
  Eigen::MatrixXd moments;  // empty where no handle clamps the cloth
};

// What pairs that touch push handles with, off the forces after a step and, about the middle of a group, the moments.
void SubtractPairs(const Eigen::VectorXd& on_handles, const Eigen::VectorXd& positions, const HandleForces& forces,
                   const std::vector<std::vector<int>>& groups, const std::vector<int>& nodes, int step, Loads* loads) {
  loads->forces.col(step) -= forces.OverGroups(on_handles);
  for (std::size_t g = 0; g < groups.size() && loads->moments.size() > 0; ++g) {
    const Eigen::Vector3d middle = positions.reshaped(3, positions.size() / 3)(Eigen::all, groups[g]).rowwise().mean();
    for (const int node : groups[g]) {
      const auto handle = 3 * (std::find(nodes.begin(), nodes.end(), node) - nodes.begin());
      const Eigen::Vector3d arm = positions.segment<3>(3 * node) - middle, push = on_handles.segment<3>(handle);
      loads->moments.col(step).segment<3>(3 * static_cast<Eigen::Index>(g)) -= arm.cross(push);
    }
  }
}

Loads LoadsAfterSteps(const Rollout& rollout, Scene scene, const std::vector<std::vector<int>>& groups) {
  scene.SetMaterials(rollout.parameters);  // bending and air are there where the rollout has them
  Simulator simulator(std::move(scene));
  simulator.UseParameters(rollout.parameters);
  const ClothModel& model = simulator.model();
  const HandleForces forces(model, rollout.parameters, rollout.num_steps(), groups);
  Eigen::MatrixXd states(3 * static_cast<Eigen::Index>(forces.nodes().size()), rollout.num_steps() + 1);
  for (int step = 0; step <= rollout.num_steps(); ++step) states.col(step) = forces.Gather(rollout.positions(step));
  Loads loads{forces.Over(states), {}};
  const Handles& handles = model.scene().handles;
  if (!handles.clamped.empty()) loads.moments = forces.MomentsOver(states);
  for (int step = 0; step <= rollout.num_steps() && model.scene().self_contact; ++step) {
    const StepRecord& end = rollout.records[rollout.last_record[std::max(step, 1) - 1]];
    SubtractPairs(PairForces(model, rollout.parameters, end), rollout.positions(step), forces, groups, handles.nodes,
                  step, &loads);
  }
  return loads;
}

void Check(const ForceSensor& sensor, const Rollout& rollout, const Scene& scene) {
  if (!(sensor.sigma >= 0.0) || !std::isfinite(sensor.sigma)) {
    throw Error(ErrorKind::kUsage, "force_sigma: expected a standard deviation >= 0 (N)");
  }
  if (!sensor.bias.allFinite()) throw Error(ErrorKind::kUsage, "force_bias: expected finite numbers (N)");
  if (scene.handles.nodes.empty()) throw Error(ErrorKind::kUsage, "forces: the scene has no handles");
  if (rollout.num_steps() < kFewestForceSteps) {
    throw Error(ErrorKind::kUsage,
                "forces: expected a scene of at least " + std::to_string(kFewestForceSteps) + " steps");
  }
}

}  // namespace

ForceReadings ReadForceSensor(const ForceSensor& sensor, const Rollout& rollout, const Scene& scene,
                              const Eigen::VectorXd& steps, std::uint64_t seed) {
  Check(sensor, rollout, scene);
  ForceReadings forces;
  forces.groups = sensor.groups;
  forces.times = scene.start_time + scene.time_step * steps.array();
  std::vector<std::vector<int>> groups = sensor.groups;
  if (groups.empty()) groups = {scene.handles.nodes};
  const Loads loads = LoadsAfterSteps(rollout, scene, groups);
  const Eigen::MatrixXd& after = loads.forces;
  forces.values.resize(after.rows(), steps.size());
  if (loads.moments.size() > 0) forces.moments.resize(after.rows(), steps.size());
  constexpr std::uint32_t kForces = 0xf04ce;  // apart from the streams of datasets/synthetic/synthetic.cc
  std::seed_seq sequence{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32), kForces};
  std::mt19937_64 generator(sequence);
  std::normal_distribution<double> normal;
  for (Eigen::Index i = 0; i < steps.size(); ++i) {
    const auto before = static_cast<Eigen::Index>(std::floor(steps[i]));
    const double fraction = steps[i] - static_cast<double>(before);
    auto force = forces.values.col(i);
    force = after.col(before);
    if (fraction > 0.0) force += fraction * (after.col(before + 1) - after.col(before));
    if (loads.moments.size() > 0) {
      forces.moments.col(i) = loads.moments.col(before);
      if (fraction > 0.0)
        forces.moments.col(i) += fraction * (loads.moments.col(before + 1) - loads.moments.col(before));
    }
    for (double& component : force) component += sensor.sigma * normal(generator);
    force += sensor.bias.replicate(forces.num_groups(), 1);
  }
  const double sigma = sensor.sigma > 0.0 ? sensor.sigma : kNoiselessForceSigma * after.cwiseAbs().maxCoeff();
  forces.sigma = Eigen::VectorXd::Constant(forces.num_groups(), sigma > 0.0 ? sigma : kNoiselessForceSigma);
  return forces;
}

}  // namespace clothid
