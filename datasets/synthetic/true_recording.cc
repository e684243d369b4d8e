#include "datasets/synthetic/true_recording.h"

#include <algorithm>
#include <utility>

#include "sim/base/error.h"
#include "sim/rollout/simulator.h"

namespace clothid {

std::vector<TrueParameter> MakeTrueParameters(const std::map<std::string, double>& truth, const Scene& scene) {
  std::vector<TrueParameter> parameters;
  for (const auto& [name, value] : truth) {
    const ParameterId id = ParseParameter(name, scene);
    const ParameterDomain domain = RowOf(id.kind).domain;
    if (domain != ParameterDomain::kAny && !(value > 0.0)) {
      throw Error(ErrorKind::kUsage, "--set: '" + name + "': expected a number > 0");
    }
    parameters.push_back({name, value, id.kind == ParameterKind::kFriction});
  }
  std::stable_partition(parameters.begin(), parameters.end(),
                        [](const TrueParameter& parameter) { return parameter.is_friction; });
  return parameters;
}

Rollout SimulateTruth(const std::vector<TrueParameter>& truth, const std::string& source, Scene scene,
                      const RolloutOptions& options) {
  Parameters parameters = scene.nominal_parameters();
  for (const TrueParameter& parameter : truth) {
    SetParameter(ParseParameter(parameter.name, scene), parameter.value, &parameters);
  }
  scene.wind = parameters.wind;
  scene.SetMaterials(parameters);  // bending and air are there where the truth has them
  const int num_steps = scene.num_steps();
  Simulator simulator(std::move(scene));
  Rollout rollout = Simulate(parameters, num_steps, &simulator, nullptr, options);
  if (!rollout.ok()) {
    throw Error(ErrorKind::kBadData,
                source + ": the true parameters cannot be simulated: " + rollout.failure->ToString());
  }
  return rollout;
}

RecordedMotion MakeRecording(const Rollout& rollout, const Scene& scene, const std::string& scene_text,
                             const SyntheticOptions& options) {
  const MotionTensors tensors = RecordRollout(rollout, scene, scene_text, options);
  RecordedMotion motion;
  motion.name = "recording";
  motion.times = tensors.times;
  motion.positions = tensors.positions;
  motion.sigma = tensors.sigma;
  motion.forces = tensors.forces;
  motion.points.resize(static_cast<std::size_t>(scene.mesh.num_nodes()));
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) motion.points[node].nodes[0] = node;
  motion.scene = scene;
  motion.scene_text = tensors.scene_text;
  return motion;
}

}  // namespace clothid
