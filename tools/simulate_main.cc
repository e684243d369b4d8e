// simulate: makes a recording with known parameters from a scene.
#include <gflags/gflags.h>

#include <atomic>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "datasets/atomic_file.h"
#include "datasets/motion_file.h"
#include "datasets/synthetic.h"
#include "sim/json_document.h"
#include "sim/parameters.h"
#include "sim/program.h"
#include "sim/rollout.h"
#include "sim/scene_json.h"
#include "sim/simulator.h"
#include "sim/text_file.h"
#include "tools/command_line.h"

DEFINE_string(scene, "", "scene.json to simulate");
DEFINE_string(output, "", "motion.bin to write");
DEFINE_double(noise, 0.0, "standard deviation of Gaussian noise on every coordinate, m");
DEFINE_double(frame_rate, 0.0, "frames per second; 0: one per time step");
DEFINE_double(drop, 0.0, "fraction of points missing in a frame, [0, 1)");
DEFINE_int32(markers, 0, "number of free nodes seen, chosen by --seed; 0: every node");
DEFINE_uint64(seed, 1, "seed of markers, noise and drops");
DEFINE_bool(float32, false, "store positions in single precision");
DEFINE_string(set, "", "true parameters in place of the scene's, NAME=VALUE[,...]");
DEFINE_int32(threads, 1, "accepted for symmetry with the other tools: one rollout runs on one thread");

namespace clothid {
namespace {

constexpr char kHelp[] = R"(simulate: makes a recording with known parameters from a scene.

  simulate --scene FILE --output FILE [flags]

  --scene FILE       scene.json (every key: datasets/README.md)
  --output FILE      motion.bin to write
  --set LIST         true parameters in place of the scene's nominal ones: mu, mu.OBSTACLE, k_stretch, k_bend,
                     density, drag, damping. They are written nowhere in the recording.
  --noise SIGMA      Gaussian noise on every coordinate, standard deviation in m (0)
  --frame_rate HZ    frames per second; 0: one per time step (0)
  --drop FRACTION    chance of a point to be missing in a frame, [0, 1) (0)
  --markers N        N free nodes are seen, chosen by the seed; 0: every node (0)
  --seed S           seed of markers, noise and drops (1)
  --float32          positions in single precision: half the size, truth recoverable to about 1e-7 m
  --threads N        accepted; one rollout runs on one thread (1)
  --help, --version

Exit codes: 0 written; 1 usage, or a file that cannot be opened or written; 2 bad content; 3 a time step did not
converge, 130 interrupted: nothing is written.

Example:
  simulate --scene datasets/drape.scene.json --set mu=0.3,k_stretch=300 --noise 0.001 --output /tmp/drape.motion.bin
)";

// The scene's nominal parameters with the assignments of --set, in alphabetical order: "mu.NAME" overrides "mu". A
// wrong value is a wrong flag, not bad data. Gives `scene` the true material, so that it has the terms that the truth
// has.
Parameters SetTruth(Scene* scene) {
  Parameters parameters = scene->nominal_parameters();
  for (const auto& [name, value] : ParseParameterValues(FLAGS_set, "--set")) {
    const ParameterId id = ParseParameter(name, scene->obstacle_names());
    SetParameter(id, value, &parameters);
    if (GetParameter(parameters, id) != value) {
      throw Error(ErrorKind::kUsage, "--set: '" + name + "': the scene has no obstacle");
    }
  }
  scene->material = parameters.material;
  try {
    ValidateParameters(parameters, *scene, FLAGS_set.empty() ? FLAGS_scene : "--set");
  } catch (const Error& error) {
    throw Error(FLAGS_set.empty() ? error.kind() : ErrorKind::kUsage, error.what());
  }
  return parameters;
}

SyntheticOptions OptionsFromFlags() {
  SyntheticOptions options;
  options.noise_sigma = FLAGS_noise;
  options.frame_rate = FLAGS_frame_rate;
  options.drop_fraction = FLAGS_drop;
  options.num_markers = FLAGS_markers;
  options.seed = FLAGS_seed;
  options.single_precision = FLAGS_float32;
  return options;
}

// Nodes sticking at the end of a solve, summed over the solves.
int CountStick(const Rollout& rollout) {
  int num_stick = 0;
  for (const StepRecord& record : rollout.records) {
    for (const ContactRecord& contact : record.contacts) num_stick += contact.branch == ContactBranch::kStick;
  }
  return num_stick;
}

void PrintSummary(const Rollout& rollout, const MotionTensors& motion) {
  const RolloutCounts& counts = rollout.counts;
  const int num_stick = CountStick(rollout);
  std::cout << FLAGS_output << ": " << motion.times.size() << " frames of " << motion.positions.rows() / 3
            << " points; " << counts.steps << " steps of " << rollout.time_step << " s with "
            << static_cast<double>(counts.newton_iterations) / counts.steps << " Newton iterations each, "
            << counts.fallbacks << " fallbacks, " << counts.substeps
            << " substeps; contacts over all steps: " << num_stick << " stick, " << counts.contacts - num_stick
            << " slip, " << counts.nodes_joined << " joined, " << counts.nodes_left << " left, "
            << counts.branch_switches << " branch switches, " << counts.obstacle_switches << " obstacle switches\n";
}

int Run(const std::vector<std::string>& arguments) {
  if (!arguments.empty()) throw Error(ErrorKind::kUsage, "unexpected argument '" + arguments.front() + "'");
  if (FLAGS_scene.empty()) throw Error(ErrorKind::kUsage, "--scene is missing; see simulate --help");
  if (FLAGS_output.empty()) throw Error(ErrorKind::kUsage, "--output is missing; see simulate --help");
  const std::string scene_text = ReadFile(FLAGS_scene, kMaxJsonBytes);
  Scene scene = ParseScene(scene_text, FLAGS_scene, std::filesystem::path(FLAGS_scene).parent_path().string());
  const Parameters truth = SetTruth(&scene);
  const std::atomic<bool>& interrupted = CatchInterrupts();
  CheckFileCanBeWritten(FLAGS_output);
  Simulator simulator(scene);
  const Rollout rollout = Simulate(truth, scene.num_steps(), &simulator, &interrupted);
  if (interrupted) {
    std::cerr << "simulate: interrupted, nothing is written\n";
    return kExitInterrupted;
  }
  if (!rollout.ok()) {
    std::cerr << "simulate: " << rollout.failure->ToString() << "\n";
    return kExitNotConverged;
  }
  const MotionTensors motion = RecordRollout(rollout, scene, scene_text, OptionsFromFlags());
  WriteMotion(motion, FLAGS_output);
  PrintSummary(rollout, motion);
  return kExitSuccess;
}

}  // namespace
}  // namespace clothid

int main(int argc, char** argv) { return clothid::RunCommand("simulate", clothid::kHelp, argc, argv, clothid::Run); }
