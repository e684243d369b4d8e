#include "tools/benchmark/fits/sampled_truth.h"

#include <utility>

#include "sim/scene/refinement.h"

namespace clothid {

Rollout SampleTruth(const std::vector<TrueParameter>& truth, const std::string& source, const Scene& scene,
                    const TruthResolution& resolution) {
  constexpr int kFewSteps = 20;  // kept at a time, for memory's sake
  Scene fine = scene;
  for (int level = 0; level < resolution.levels; ++level) {
    ExpectRefinable(fine, source);
    fine = RefineScene(fine, RefineMesh(fine.mesh));
  }
  fine.time_step /= resolution.steps;
  const Eigen::Index size = 3 * static_cast<Eigen::Index>(scene.mesh.num_nodes());
  Rollout sampled;
  RolloutOptions options;
  options.checkpoint_interval = kFewSteps;
  options.visitor = [&](int step, const Eigen::VectorXd& positions) {
    if (step == 0 || step % resolution.steps != 0) return;
    StepRecord record;
    record.time_step = scene.time_step;
    record.time = scene.start_time + step * fine.time_step;
    record.positions = positions.head(size);
    sampled.last_record.push_back(static_cast<int>(sampled.records.size()));
    sampled.records.push_back(std::move(record));
  };
  const Rollout rollout = SimulateTruth(truth, source, fine, options);
  sampled.parameters = rollout.parameters;
  sampled.start_time = rollout.start_time;
  sampled.time_step = scene.time_step;
  sampled.initial_positions = rollout.initial_positions.head(size);
  sampled.initial_velocities = rollout.initial_velocities.head(size);
  return sampled;
}

}  // namespace clothid
