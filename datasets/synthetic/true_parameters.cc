#include "datasets/synthetic/true_parameters.h"

#include <utility>

#include "sim/base/error.h"
#include "sim/rollout/simulator.h"

namespace clothid {

Parameters SetTrueParameters(const std::map<std::string, double>& truth, const std::string& flag,
                             const std::string& source, Scene* scene) {
  Parameters parameters = scene->nominal_parameters();
  for (const auto& [name, value] : truth) {
    const ParameterId id = ParseParameter(name, *scene);
    SetParameter(id, value, &parameters);
    if (GetParameter(parameters, id) != value) {
      throw Error(ErrorKind::kUsage, flag + ": '" + name + "': the scene has no obstacle");
    }
  }
  scene->SetMaterials(parameters);
  try {
    ValidateParameters(parameters, *scene, truth.empty() ? source : flag);
  } catch (const Error& error) {
    throw Error(truth.empty() ? error.kind() : ErrorKind::kUsage, error.what());
  }
  return parameters;
}

Rollout SimulateTruth(const std::map<std::string, double>& truth, const std::string& source, Scene scene,
                      const RolloutOptions& options) {
  const Parameters parameters = SetTrueParameters(truth, "--set", source, &scene);
  scene.wind = parameters.wind;
  const int num_steps = scene.num_steps();
  Simulator simulator(std::move(scene));
  Rollout rollout = Simulate(parameters, num_steps, &simulator, nullptr, options);
  if (!rollout.ok()) {
    throw Error(ErrorKind::kBadData,
                source + ": the true parameters cannot be simulated: " + rollout.failure->ToString());
  }
  return rollout;
}

}  // namespace clothid
