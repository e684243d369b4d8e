// Recordings of known truth in memory, for benchmarks that fit them.
#ifndef CLOTHID_DATASETS_SYNTHETIC_TRUE_RECORDING_H_
#define CLOTHID_DATASETS_SYNTHETIC_TRUE_RECORDING_H_

#include <map>
#include <string>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "datasets/synthetic/synthetic.h"
#include "sim/rollout/rollout.h"
#include "sim/scene/scene.h"

namespace clothid {

// A parameter to be fitted, and its true value.
struct TrueParameter {
  std::string name;
  double value = 0.0;
  bool is_friction = false;
};

// Friction first, otherwise in the order of the names. Throws `Error` (kUsage), naming --set, unless every name is a
// parameter of `scene` and every value positive.
std::vector<TrueParameter> MakeTrueParameters(const std::map<std::string, double>& truth, const Scene& scene);

// The whole of `scene` with the true parameters and its nominal values for all others. Throws `Error` (kBadData), led
// by `source`, where a step does not converge.
Rollout SimulateTruth(const std::vector<TrueParameter>& truth, const std::string& source, Scene scene,
                      const RolloutOptions& options = {});

// What `ReadMotion` would make of the file of a recording (see `RecordRollout`), but for a path of handles, which stays
// exact between frames. `options` without markers.
RecordedMotion MakeRecording(const Rollout& rollout, const Scene& scene, const std::string& scene_text,
                             const SyntheticOptions& options);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_SYNTHETIC_TRUE_RECORDING_H_
