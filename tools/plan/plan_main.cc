// plan: tells before the laboratory which motion would tell which parameter.
#include <gflags/gflags.h>
#include <malloc.h>
#include <unistd.h>

#include <iostream>
#include <string>
#include <vector>

#include "identify/base/command_line.h"
#include "identify/base/options.h"
#include "identify/base/version.h"
#include "identify/experiment/experiment_plan.h"
#include "sim/base/error.h"
#include "sim/base/program.h"
#include "sim/scene/parameters.h"
#include "tools/base/count_progress.h"
#include "tools/plan/plan_help.h"

DEFINE_string(scenes, "", "candidates, scene.json each");
DEFINE_string(fit, "", "parameters to be told");
DEFINE_string(each, "", "parameters of which every recording has its own");
DEFINE_string(start, "", "nominal values, NAME=VALUE[,...]");
DEFINE_string(lower, "", "lower bounds, NAME=VALUE[,...]");
DEFINE_string(upper, "", "upper bounds, NAME=VALUE[,...]");
DEFINE_string(prior, "", "what is believed, NAME=CENTER:SPREAD[,...]");
DEFINE_double(sigma, 0.0, "standard deviation of a measured coordinate, m");
DEFINE_double(frame_rate, 0.0, "frames per second; 0: one per time step");
DEFINE_int32(markers, 0, "number of free nodes seen; 0: every node");
DEFINE_bool(forces, false, "the forces on the handles, too");
DEFINE_double(force_sigma, 0.01, "standard deviation of a component of the forces, N");
DEFINE_double(handle_sigma, 0.0, "standard deviation of the measured path of handles, m");
DEFINE_string(initial, "estimated", "scene, estimated, rest or moving");
DEFINE_int32(draws, 8, "cloths beside the nominal one");
DEFINE_uint64(seed, 1, "seed of draws and markers");
DEFINE_int32(threads, 1, "cloths side by side");
DEFINE_string(output, "", "folder of plan.json");

namespace clothid {
namespace {

PlanOptions OptionsFromFlags() {
  PlanOptions options;
  options.scene_paths = ParseNames(FLAGS_scenes, "--scenes");
  options.fit.parameters = ParseNames(FLAGS_fit, "--fit");
  options.fit.each = ParseNames(FLAGS_each, "--each");
  options.fit.overrides.start = ParseParameterValues(FLAGS_start, "--start");
  options.fit.overrides.lower_bounds = ParseParameterValues(FLAGS_lower, "--lower");
  options.fit.overrides.upper_bounds = ParseParameterValues(FLAGS_upper, "--upper");
  options.fit.overrides.priors = ParseParameterPriors(FLAGS_prior, "--prior");
  options.fit.num_threads = FLAGS_threads;
  options.sigma = FLAGS_sigma;
  options.frame_rate = FLAGS_frame_rate;
  options.num_markers = FLAGS_markers;
  options.has_forces = FLAGS_forces;
  options.force_sigma = FLAGS_force_sigma;
  options.handle_sigma = FLAGS_handle_sigma;
  options.start = FLAGS_initial == "scene" ? StartSource::kScene : ParseStartSource(FLAGS_initial);
  options.num_draws = FLAGS_draws;
  options.seed = FLAGS_seed;
  options.output = FLAGS_output;
  return options;
}

// A sweep makes and drops matrices of some megabytes in every step. Given back to the system each time, and asked for
// again, they take a quarter of the time of a plan.
void KeepFreedMemory() {
#ifdef __GLIBC__
  constexpr int kMegabyte = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, 32 * kMegabyte);  // the largest that it takes
  mallopt(M_TRIM_THRESHOLD, 1024 * kMegabyte);
#endif
}

int Run(const std::string& command_line) {
  if (FLAGS_scenes.empty()) throw Error(ErrorKind::kUsage, "--scenes is missing; see plan --help");
  PlanOptions options = OptionsFromFlags();
  options.command_line = command_line;
  options.fit.cancel = &CatchInterrupts();
  KeepFreedMemory();
  Plan plan;
  {
    CountProgress progress(&std::cerr, isatty(STDERR_FILENO) != 0, "cloths", CountProgress::End::kQuiet);
    options.on_progress = [&](int num_done, int num_cloths) { progress.Print(num_done, num_cloths); };
    plan = PlanExperiment(options);
  }
  if (options.fit.is_cancelled()) {
    std::cerr << "plan: interrupted, nothing is written\n";
    return kExitInterrupted;
  }
  std::cout << PlanTable(plan);
  return plan.has_any() ? kExitSuccess : kExitNotConverged;
}

std::string CommandLine(int argc, char** argv) {
  std::string line;
  for (int i = 1; i < argc; ++i) line += (i > 1 ? " " : "") + std::string(argv[i]);
  return line;
}

}  // namespace
}  // namespace clothid

int main(int argc, char** argv) {
  const std::string command_line = clothid::CommandLine(argc, argv);
  const auto run = [&](const std::vector<std::string>&) { return clothid::Run(command_line); };
  clothid::Program program = {"plan", clothid::kHelp, clothid::kMoreHelp, {{"", {}, "", run}}};
  for (const char* list : {"scenes", "fit", "each", "start", "lower", "upper", "prior"}) program.lists[list] = ',';
  clothid::RunCommandLine(program, argc, argv);
}
