#include <gflags/gflags.h>

#include <filesystem>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "datasets/files/atomic_file.h"
#include "datasets/files/overwrite.h"
#include "datasets/motion/motion_file.h"
#include "datasets/synthetic/synthetic.h"
#include "datasets/synthetic/true_parameters.h"
#include "identify/view/view_page.h"
#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/base/program.h"
#include "sim/base/text_file.h"
#include "sim/scene/scene_json.h"
#include "tools/base/scene_rollout.h"
#include "tools/motion/motion_commands.h"

DEFINE_string(output, "view.html", "view: page to write");

namespace clothid {
namespace {

bool IsScene(const std::string& path) { return std::filesystem::path(path).extension() == ".json"; }

// A scene as it is, simulated with its nominal values, with the forces at its handles. Returns an exit code.
int SimulateNominal(const std::string& path, MotionTensors* motion) {
  const std::string text = ReadText(path, kMaxJsonBytes);
  Scene scene = ParseScene(text, path, std::filesystem::path(path).parent_path().string());
  const Parameters nominal = SetTrueParameters({}, "", path, &scene);
  SyntheticOptions options;
  if (!scene.handles.nodes.empty()) options.force_sensor.emplace();
  CheckSyntheticOptions(options, scene, text);
  CheckRolloutMemory(path, scene.mesh.num_nodes(), scene.num_steps(), scene.integrator);
  const std::atomic<bool>& interrupted = CatchInterrupts();
  Simulator simulator(scene);
  Rollout rollout;
  const int exit_code = SimulateScene("motion", nominal, scene.num_steps(), &simulator, interrupted, &rollout);
  if (exit_code != kExitSuccess) return exit_code;
  *motion = RecordRollout(rollout, scene, text, options);
  WarnOfEnergy("motion", rollout, &simulator);
  return kExitSuccess;
}

}  // namespace

int MotionView(const std::vector<std::string>& arguments) {
  const std::string& path = arguments.front();
  RefuseOverwrite(FLAGS_output, IsScene(path) ? FilesOfScene(path) : std::vector<std::string>{path});
  CheckPageOutput("--output", FLAGS_output);
  ReadMotionOptions options;
  options.smooth_handles = false;
  RecordedMotion motion;
  if (IsScene(path)) {
    MotionTensors simulated;
    const int exit_code = SimulateNominal(path, &simulated);
    if (exit_code != kExitSuccess) return exit_code;
    motion = InterpretMotion(std::move(simulated), path, options);
  } else {
    motion = ReadMotion(path, options);
  }
  WriteFileAtomically(FLAGS_output, {ViewHtml(motion, IsScene(path))});
  std::cout << Escaped(FLAGS_output) << ": " << motion.num_frames() << " frames; open it in a browser\n";
  return kExitSuccess;
}

}  // namespace clothid
