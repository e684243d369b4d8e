// The true parameters of a recording that is to be simulated.
#ifndef CLOTHID_DATASETS_SYNTHETIC_TRUE_PARAMETERS_H_
#define CLOTHID_DATASETS_SYNTHETIC_TRUE_PARAMETERS_H_

#include <map>
#include <string>

#include "sim/rollout/rollout.h"
#include "sim/scene/parameters.h"
#include "sim/scene/scene.h"

namespace clothid {

// The nominal parameters of `scene` with those of `truth` in place, by name in alphabetical order: "mu.NAME" overrides
// "mu". Gives `scene` the true material, so that it has the terms that the truth has. Throws `Error`: kUsage, naming
// `flag`, for names and values that the scene cannot have; without any truth kBadData, naming `source`, where the scene
// itself has them.
Parameters SetTrueParameters(const std::map<std::string, double>& truth, const std::string& flag,
                             const std::string& source, Scene* scene);

// The whole of `scene` with the true parameters, as `SetTrueParameters` sets them for --set. Throws `Error` (kBadData),
// led by `source`, where a step does not converge.
Rollout SimulateTruth(const std::map<std::string, double>& truth, const std::string& source, Scene scene,
                      const RolloutOptions& options = {});

}  // namespace clothid

#endif  // CLOTHID_DATASETS_SYNTHETIC_TRUE_PARAMETERS_H_
