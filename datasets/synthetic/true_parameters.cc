#include "datasets/synthetic/true_parameters.h"

#include "sim/base/error.h"

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

}  // namespace clothid
