// Recordings that are right: the shipped ones, and others that are simulated with the nominal parameters of a scene.
#ifndef CLOTHID_TESTS_IDENTIFY_SIMULATED_RECORDINGS_H_
#define CLOTHID_TESTS_IDENTIFY_SIMULATED_RECORDINGS_H_

#include <string>

#include "datasets/motion/motion_file.h"
#include "datasets/synthetic/synthetic.h"
#include "datasets/synthetic/true_parameters.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"
#include "sim/scene/scene_json.h"

namespace clothid {

inline const std::string kDatasets = CLOTHID_SOURCE_DIR "/datasets/";

inline MotionTensors Shipped(const std::string& name) { return ReadMotionTensors(kDatasets + name + ".motion.bin"); }

inline MotionTensors SimulatedText(const std::string& text, const SyntheticOptions& options) {
  const Scene scene = ParseScene(text, "scene", "");
  return RecordRollout(SimulateTruth({}, "scene", scene), scene, text, options);
}

inline MotionTensors Simulated(const std::string& name, const SyntheticOptions& options) {
  return SimulatedText(ReadFile(kDatasets + name + ".scene.json", kMaxJsonBytes), options);
}

// The cloth of `drape` as a depth camera sees it.
inline MotionTensors Clouds() {
  SyntheticOptions options;
  options.num_cloud_points = 300;
  options.noise_sigma = 0.001;
  options.frame_rate = 25.0;
  return Simulated("drape", options);
}

inline RecordedMotion AsFitted(const MotionTensors& tensors) { return InterpretMotion(tensors, "recording"); }

}  // namespace clothid

#endif  // CLOTHID_TESTS_IDENTIFY_SIMULATED_RECORDINGS_H_
