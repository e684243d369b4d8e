// simulate: makes a recording with known parameters from a scene.
#include <gflags/gflags.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "datasets/fabric/scene_with_fabric.h"
#include "datasets/files/atomic_file.h"
#include "datasets/files/overwrite.h"
#include "datasets/formats/track_file.h"
#include "datasets/importing/force_file.h"
#include "datasets/motion/motion_file.h"
#include "datasets/motion/motion_name.h"
#include "datasets/synthetic/capture.h"
#include "datasets/synthetic/sensor.h"
#include "datasets/synthetic/synthetic.h"
#include "datasets/synthetic/true_parameters.h"
#include "identify/base/command_line.h"
#include "identify/base/join_words.h"
#include "identify/base/parallel_for.h"
#include "identify/view/view_page.h"
#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/base/program.h"
#include "sim/base/text_file.h"
#include "sim/path/handle_csv.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/self_contact_audit.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/parameters.h"
#include "sim/scene/scene_json.h"
#include "tools/base/scene_rollout.h"
#include "tools/simulate/force_flags.h"
#include "tools/simulate/predict.h"
#include "tools/simulate/simulate_help.h"
#include "tools/simulate/true_fields.h"

DEFINE_string(scene, "", "scene.json to simulate");
DEFINE_string(fabric, "",
              "kind of cloth whose measured constants stand in for those that the scene does not give, or a card");
DEFINE_string(output, "", "motion.bin to write");
DEFINE_double(noise, 0.0, "standard deviation of Gaussian noise on every coordinate, m");
DEFINE_double(frame_rate, 0.0, "frames per second; 0: one per time step");
DEFINE_double(drop, 0.0, "fraction of points missing in a frame, [0, 1)");
DEFINE_int32(markers, 0, "number of free nodes seen, chosen by --seed; 0: every node");
DEFINE_int32(cloud, 0, "points per frame of an unordered cloud on the surface, in place of the nodes; 0: none");
DEFINE_uint64(seed, 1, "seed of markers, noise, drops and clouds");
DEFINE_bool(float32, false, "store positions in single precision");
DEFINE_string(set, "", "true parameters in place of the scene's, NAME=VALUE[,...]");
DEFINE_string(set_field, "", "true fields in place of the scene's, NAME=FILE.npy[,...]");
DEFINE_string(result, "", "result.json of a fit, by which the scene is predicted");
DEFINE_int32(draws, 50, "with --result: rollouts, each with parameters of its own");
DEFINE_string(sources, "force,step,mesh,start,handles", "with --result: what spreads the rollouts beside parameters");
DEFINE_string(of, "", "with --result: what to tell beside the positions of nodes");
DEFINE_string(bands, "", "with --result: bands.npz to write");
DEFINE_bool(keep_draws, false, "with --bands: every rollout, too");
DEFINE_string(view, "", "page to write beside the recording");
DEFINE_string(sensor, "", "sensor.json of a camera and a gripper that see a finer simulation");
DEFINE_string(handles_output, "", "with --sensor: CSV file for the path of the gripper");
DEFINE_string(forces_output, "", "with --sensor: CSV file for the forces on the handles");
DEFINE_int32(threads, 1, "that share the work of a step; with --result: that run rollouts side by side");

namespace clothid {
namespace {

// What --set and --set_field say. A wrong value is a wrong flag, not bad data.
Parameters SetTruth(Scene* scene) {
  SetTrueFields(FLAGS_set_field, scene);
  return SetTrueParameters(ParseParameterValues(FLAGS_set, "--set"), "--set", FLAGS_scene, scene);
}

SyntheticOptions OptionsFromFlags() {
  SyntheticOptions options;
  options.noise_sigma = FLAGS_noise;
  options.frame_rate = FLAGS_frame_rate;
  options.drop_fraction = FLAGS_drop;
  options.num_markers = FLAGS_markers;
  options.num_cloud_points = FLAGS_cloud;
  options.force_sensor = ForceSensorFromFlags();
  options.seed = FLAGS_seed;
  options.single_precision = FLAGS_float32;
  return options;
}

// Nodes sticking at the end of a step or substep, summed over them.
int CountStick(const Rollout& rollout) {
  int num_stick = 0;
  for (const StepRecord& record : rollout.records) {
    if (!record.ends_step()) continue;
    for (const ContactRecord& contact : record.contacts.nodes) num_stick += contact.branch == ContactBranch::kStick;
  }
  return num_stick;
}

// Where the cloth touches itself: how often, and whether it has stayed out of itself.
void PrintSelfContact(const Rollout& rollout, Simulator* simulator) {
  const SelfContactAudit audit = AuditSelfContact(rollout, simulator);
  std::cout << "the cloth with itself: " << rollout.counts.self_contacts << " contacts over all steps, "
            << rollout.counts.pair_changes << " changes of them, " << rollout.counts.second_solves
            << " solves repeated with pairs that were left out, " << audit.dependent_steps
            << " steps whose derivative is not certain for them, " << audit.intersections
            << " pairs of triangles that cut each other";
  if (audit.num_cut > 0) std::cout << ", from step " << audit.first_cut << " on";
  std::cout << ", nearer than the thickness by up to " << MillimetreText(audit.violation, 2) << ", pushed apart with "
            << NumberText(audit.push, 3) << " J\n";
}

void PrintSummary(const Rollout& rollout, const MotionTensors& motion) {
  const RolloutCounts& counts = rollout.counts;
  const int num_stick = CountStick(rollout);
  std::cout << FLAGS_output << ": " << motion.times.size() << " frames of " << motion.positions.rows() / 3 << " points"
            << (FLAGS_cloud > 0 ? " and clouds of up to " + std::to_string(FLAGS_cloud) : "") << "; " << counts.steps
            << " steps of " << rollout.time_step << " s with "
            << static_cast<double>(counts.newton_iterations) / counts.steps << " Newton iterations each, "
            << counts.fallbacks << " fallbacks, " << counts.substeps
            << " substeps; contacts over all steps: " << num_stick << " stick, " << counts.contacts - num_stick
            << " slip, " << counts.nodes_joined << " joined, " << counts.nodes_left << " left, "
            << counts.branch_switches << " branch switches, " << counts.obstacle_switches << " obstacle switches\n";
}

// The recording as `motion view` shows it.
void WriteView(MotionTensors motion) {
  ReadMotionOptions options;
  options.smooth_handles = false;
  WriteFileAtomically(FLAGS_view, {ViewHtml(InterpretMotion(std::move(motion), FLAGS_output, options))});
  std::cout << FLAGS_view << ": a page to look at it\n";
}

void WritePredictionView(PredictionOutput output) {
  RecordedMotion median = InterpretMotion(std::move(output.median), FLAGS_output);
  WriteFileAtomically(FLAGS_view, {PredictionHtml(std::move(median), output.view)});
  std::cout << FLAGS_view << ": a page to look at it\n";
}

// No input is to be lost to an output, and no output to the other one.
void CheckOutputs() {
  std::vector<std::string> inputs = FilesOfScene(FLAGS_scene);
  inputs.push_back(FLAGS_sensor);
  inputs.push_back(FLAGS_result);
  const std::vector<std::string> outputs = FLAGS_sensor.empty() ? std::vector{FLAGS_output} : TrackPaths(FLAGS_output);
  std::vector<std::pair<std::string, std::string>> taken;  // flags and files
  for (const std::string& output : outputs) {
    RefuseOverwrite(output, inputs);
    taken.emplace_back("--output", output);
  }
  const std::pair<std::string, std::string> others[] = {{"--handles_output", FLAGS_handles_output},
                                                        {"--forces_output", FLAGS_forces_output},
                                                        {"--bands", FLAGS_bands},
                                                        {"--view", FLAGS_view}};
  for (const auto& [flag, file] : others) {
    RefuseOverwrite(file, inputs);
    for (const auto& [other_flag, other] : taken) {
      if (!IsSameFile(file, other)) continue;
      throw Error(ErrorKind::kUsage, flag + ": " + file + ": expected another file than " + other_flag);
    }
    taken.emplace_back(flag, file);
  }
}

// The files of a laboratory.
int RunSensor() {
  const GridScene grid_scene = ReadGridScene(FLAGS_scene);
  const bool has_path = grid_scene.scene.handles.path.num_handles() > 0;
  if (has_path == FLAGS_handles_output.empty()) {
    throw Error(ErrorKind::kUsage, has_path ? "--handles_output is missing: the scene moves its handles"
                                            : "--handles_output: the scene moves no handles");
  }
  const Sensor sensor = ParseSensor(ReadText(FLAGS_sensor, kMaxJsonBytes), FLAGS_sensor);
  if (sensor.force_sensor.has_value() == FLAGS_forces_output.empty()) {
    throw Error(ErrorKind::kUsage, sensor.force_sensor ? "--forces_output is missing: the sensor reads forces"
                                                       : "--forces_output: the sensor reads no forces");
  }
  const std::map<std::string, double> truth = ParseParameterValues(FLAGS_set, "--set");
  CheckRolloutMemory(FLAGS_scene, (2.0 * grid_scene.nodes[0] - 1.0) * (2.0 * grid_scene.nodes[1] - 1.0),
                     kTrueStepDivisor * static_cast<double>(grid_scene.scene.num_steps()), grid_scene.scene.integrator);
  CheckFileCanBeWritten(FLAGS_output);
  if (has_path) CheckFileCanBeWritten(FLAGS_handles_output);
  if (sensor.force_sensor) CheckFileCanBeWritten(FLAGS_forces_output);
  const FineTruth fine_truth = [&] {
    StepProgress progress;
    return SimulateFineTruth(grid_scene, truth, progress.options(kTrueStepDivisor * grid_scene.scene.num_steps()));
  }();
  const Capture capture = TakeCapture(grid_scene, fine_truth, sensor, FLAGS_seed);
  WriteTracks(capture.points, FLAGS_output);  // first: not every format can hold every motion
  if (has_path) {
    WriteFileAtomically(FLAGS_handles_output, {HandleCsv(capture.handles.times, capture.handles.positions)});
  }
  if (sensor.force_sensor) WriteFileAtomically(FLAGS_forces_output, {ForceCsv(capture.forces)});
  std::cout << FLAGS_output << ": " << capture.points.num_frames() << " frames of " << capture.points.num_points()
            << " points\n";
  return kExitSuccess;
}

// The scene by what a fit has learnt.
int RunPrediction(const Scene& scene, const std::string& scene_text) {
  PredictionOptions options;
  SetSources(FLAGS_sources, "--sources", &options);
  if (!FLAGS_of.empty()) options.derived = ParseDerived(FLAGS_of, "--of", scene);
  options.num_draws = FLAGS_draws;
  options.seed = FLAGS_seed;
  options.keeps_draws = FLAGS_keep_draws;
  options.frame_rate = FLAGS_frame_rate;
  options.num_threads = FLAGS_threads;
  options.cancel = &CatchInterrupts();
  CheckRolloutMemory(FLAGS_scene, static_cast<double>(FLAGS_threads) * scene.mesh.num_nodes(), scene.num_steps(),
                     scene.integrator);
  CheckFileCanBeWritten(FLAGS_output);
  if (!FLAGS_bands.empty()) CheckFileCanBeWritten(FLAGS_bands);
  if (!FLAGS_view.empty()) CheckPageOutput("--view", FLAGS_view);
  PredictionOutput output;
  const int exit_code = PredictScene({scene, scene_text, FLAGS_scene}, FLAGS_result, options, &output);
  if (exit_code != kExitSuccess) return exit_code;
  WriteMotion(output.median, FLAGS_output);
  if (!FLAGS_bands.empty()) WriteFileAtomically(FLAGS_bands, {output.bands});
  if (!FLAGS_view.empty()) WritePredictionView(std::move(output));
  return kExitSuccess;
}

int Run(const std::vector<std::string>&) {
  if (FLAGS_scene.empty()) throw Error(ErrorKind::kUsage, "--scene is missing; see simulate --help");
  if (FLAGS_output.empty()) throw Error(ErrorKind::kUsage, "--output is missing; see simulate --help");
  if (FLAGS_threads < 1 || FLAGS_threads > kMaxThreads) {
    throw Error(ErrorKind::kUsage, "--threads: expected a number from 1 to " + std::to_string(kMaxThreads));
  }
  if (FLAGS_sensor.empty()) {
    ExpectMotionName(FLAGS_output);
  } else {
    OutputFormatOf(FLAGS_output);
  }
  CheckOutputs();
  if (!FLAGS_sensor.empty()) return RunSensor();
  std::string scene_text = ReadText(FLAGS_scene, kMaxJsonBytes);
  if (!FLAGS_fabric.empty()) scene_text = WithFabricOrCard(scene_text, FLAGS_fabric, "--fabric", FLAGS_scene);
  Scene scene = ParseScene(scene_text, FLAGS_scene, std::filesystem::path(FLAGS_scene).parent_path().string());
  if (!FLAGS_result.empty()) return RunPrediction(scene, scene_text);
  const Parameters truth = SetTruth(&scene);
  CheckSyntheticOptions(OptionsFromFlags(), scene, scene_text);
  CheckRolloutMemory(FLAGS_scene, scene.mesh.num_nodes(), scene.num_steps(), scene.integrator);
  const std::atomic<bool>& interrupted = CatchInterrupts();
  CheckFileCanBeWritten(FLAGS_output);
  if (!FLAGS_view.empty()) CheckPageOutput("--view", FLAGS_view);
  Simulator simulator(scene);
  simulator.SetNumThreads(FLAGS_threads);
  Rollout rollout;
  const int exit_code = SimulateScene("simulate", truth, scene.num_steps(), &simulator, interrupted, &rollout);
  if (exit_code != kExitSuccess) return exit_code;
  const MotionTensors motion = RecordRollout(rollout, scene, scene_text, OptionsFromFlags());
  WriteMotion(motion, FLAGS_output);
  PrintSummary(rollout, motion);
  if (scene.self_contact) PrintSelfContact(rollout, &simulator);
  WarnOfEnergy("simulate", rollout, &simulator);
  if (!FLAGS_view.empty()) WriteView(motion);
  return kExitSuccess;
}

}  // namespace
}  // namespace clothid

int main(int argc, char** argv) {
  using Rule = clothid::FlagRule;
  clothid::Program program = {"simulate", clothid::kHelp, clothid::kMoreHelp, {{"", {}, "", clothid::Run}}};
  program.rules = {
      {"view noise frame_rate drop markers cloud float32 set_field fabric forces force_sigma force_rate force_bias "
       "force_nodes threads",
       Rule::kWithout, "sensor"},
      {"noise drop markers cloud float32 set set_field forces sensor", Rule::kWithout, "result"},
      {"draws sources of bands", Rule::kWith, "result"},
      {"keep_draws", Rule::kWith, "bands"},
      {"force_sigma force_rate force_bias force_nodes", Rule::kWith, "forces"},
      {"handles_output forces_output", Rule::kWith, "sensor"}};
  program.lists = {{"set", ','}, {"set_field", ','}};
  clothid::RunCommandLine(program, argc, argv);
}
