// landscape: scans the cost over two parameters.
#include <gflags/gflags.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "datasets/motion/motion_file.h"
#include "identify/base/command_line.h"
#include "identify/base/fitted_result.h"
#include "identify/base/options.h"
#include "identify/base/output_folder.h"
#include "identify/base/parallel_for.h"
#include "identify/base/version.h"
#include "identify/landscape/landscape.h"
#include "sim/base/error.h"
#include "sim/base/program.h"
#include "sim/scene/parameters.h"
#include "tools/base/count_progress.h"
#include "tools/landscape/landscape_files.h"
#include "tools/landscape/landscape_help.h"
#include "tools/landscape/landscape_plan.h"
#include "tools/landscape/landscape_plot.h"
#include "tools/landscape/landscape_run.h"
#include "tools/landscape/landscape_store.h"
#include "tools/landscape/landscape_summary.h"
#include "tools/landscape/scene_variant.h"

DEFINE_string(target, "", "recording");
DEFINE_string(scene, "", "scene.json to use instead of the one in the recording");
DEFINE_string(x, "", "first axis, NAME=LOWER:UPPER:CELLS[:log]");
DEFINE_string(y, "", "second axis, likewise");
DEFINE_string(zoom_around, "", "center of the zooms, NAME=VALUE,NAME=VALUE");
DEFINE_string(zoom, "", "shares of the axes to zoom into");
DEFINE_bool(zoom_only, false, "leaves out the whole of the axes");
DEFINE_string(sweep, "", "numbers of the scene to vary, KEY=NUMBER[,...][;KEY=...]");
DEFINE_string(set, "", "true parameters, NAME=VALUE[,...]: their rollouts replace the measured data");
DEFINE_string(contact, "", "contact mode: gap, velocity or both; empty: the scene's");
DEFINE_string(sigma, "recorded", "standard deviation of a coordinate: recorded, auto or a number in m");
DEFINE_string(initial, "estimated",
              "where the cloth starts if the scene does not say: estimated, rest, moving, smoothed or first");
DEFINE_string(assimilate, "", "memory of rollouts that the recording corrects, MEMORY[:LENGTH] in s and m");
DEFINE_string(result, "", "result.json of a fit of the recording, whose cost is scanned");
DEFINE_bool(gradients, false, "the adjoint gradient at every cell");
DEFINE_string(shard, "", "I/N: only the cells I, I + N, I + 2 N, ..");
DEFINE_bool(resume, false, "continue a scan that was stopped");
DEFINE_int32(threads, 1, "cells side by side");
DEFINE_string(output, "landscape_result", "folder for the results");

namespace clothid {
namespace {

// Tells what the cells hold and are weighed by; a cost whose frames differ in weight does not tell the rmse.
void TellFit(const LandscapeScanOptions& scan, LandscapeOrigin* origin) {
  origin->fit = ScannedFit{scan.held, scan.model_error, scan.assimilation};
  if (!scan.model_error.is_zero()) origin->sigma->rmse_of_root_cost = std::nan("");
}

Assimilation ParseMemory(const std::string& text, bool has_result) {
  const AssimilationOption option = ParseAssimilation(text);
  if (option.kind == AssimilationOption::Kind::kAuto) {
    throw Error(ErrorKind::kUsage, "--assimilate: expected off or a memory in s, as every cell has the same");
  }
  if (has_result) throw Error(ErrorKind::kUsage, "--assimilate: expected without --result, which has that of the fit");
  return option.given;
}

LandscapeRunOptions OptionsFromFlags() {
  if (FLAGS_threads < 1) throw Error(ErrorKind::kUsage, "--threads: expected a number >= 1");
  if (FLAGS_target.empty()) throw Error(ErrorKind::kUsage, "--target: expected a recording; see landscape --help");
  const auto truth = ParseParameterValues(FLAGS_set, "--set");
  ReadMotionOptions reading;
  reading.scene_path = FLAGS_scene;
  ParseSigma(FLAGS_sigma, &reading);
  reading.start = ParseStartSource(FLAGS_initial);
  LandscapeRunOptions options;
  options.origin.shard = ParseShard(FLAGS_shard);
  const MotionReader read = [](const ReadMotionOptions& how) { return ReadMotion(FLAGS_target, how); };
  if (!FLAGS_result.empty() && !truth.empty()) {
    throw Error(ErrorKind::kUsage, "--set: expected without --result, whose cost is that of what was measured");
  }
  std::optional<FittedResult> result;
  if (!FLAGS_result.empty()) result = ReadFittedResult(FLAGS_result);
  options.scan = SetUpLandscape(
      {FLAGS_x, FLAGS_y, FLAGS_zoom_around, FLAGS_zoom, FLAGS_zoom_only, FLAGS_sweep, FLAGS_contact, FLAGS_gradients},
      read, reading, result ? &*result : nullptr);
  options.scan.num_threads = FLAGS_threads;
  options.scan.cancel = &CatchInterrupts();
  options.origin.version = Version();
  options.origin.git = GitHash();
  options.origin.input_sha256 = options.scan.motions.front().sha256;
  options.origin.truth = truth;
  options.origin.sigma = SigmaOf(options.scan.motions.front());
  if (!FLAGS_assimilate.empty()) options.scan.assimilation = ParseMemory(FLAGS_assimilate, result.has_value());
  if (result || options.scan.assimilation.is_on()) TellFit(options.scan, &options.origin);
  options.origin.fingerprint = LandscapeFingerprint(options.scan, options.origin);
  if (!truth.empty()) MeasureTruth(truth, &options.scan);
  options.folder = FLAGS_output;
  ExpectNotReplaced("--target", FLAGS_target, FLAGS_output, IsLandscapeFile);
  if (!FLAGS_scene.empty()) ExpectNotReplaced("--scene", FLAGS_scene, FLAGS_output, IsLandscapeFile);
  if (result) ExpectNotReplaced("--result", FLAGS_result, FLAGS_output, IsLandscapeFile);
  options.resume = FLAGS_resume;
  return options;
}

// How many cells there are and, of a whole landscape, what it looks like.
void PrintSummary(const LandscapePart& part) {
  const LandscapePlan& plan = part.landscape.plan;
  const LandscapeShard& shard = part.origin.shard;
  int num_failed = 0;
  std::string failure;
  const std::vector<int> cells = shard.Cells(plan);
  for (const int cell : cells) {
    const LandscapeCell& result = part.landscape.cells[cell];
    if (result.failure.empty()) continue;
    if (num_failed++ == 0) failure = "; the first, cell " + std::to_string(cell) + ": " + result.failure;
  }
  std::cout << FLAGS_output << ": " << cells.size() << " cells";
  if (!shard.is_whole()) std::cout << " of shard " << shard.index << " of " << shard.count;
  std::cout << ", " << num_failed << " failed" << failure << "\n";
  if (shard.is_whole()) std::cout << SummaryTable(Summarize(part.landscape));
}

int Scan(const std::vector<std::string>&) {
  LandscapeRunOptions options = OptionsFromFlags();
  LandscapeRunResult result;
  {
    CountProgress progress(&std::cerr, isatty(STDERR_FILENO) != 0, "cells", CountProgress::End::kTold);
    options.on_progress = [&](int num_done, int num_cells, int num_kept) {
      progress.Print(num_done, num_cells, num_kept);
    };
    result = RunLandscape(std::move(options));
  }
  if (!result.is_complete()) {
    std::cerr << "landscape: interrupted with " << result.num_done << " of " << result.num_cells
              << " cells done, kept in " << FLAGS_output << "; add --resume to the same command to go on\n";
    return kExitInterrupted;
  }
  PrintSummary(result.part);
  const int num_new = result.num_done - result.num_kept;
  if (result.num_kept > 0) std::cout << result.num_kept << " cells were done before\n";
  if (num_new == 0) return kExitSuccess;
  std::cout << num_new << " cells in " << result.seconds << " s on " << FLAGS_threads << " thread"
            << (FLAGS_threads > 1 ? "s" : "") << ": " << num_new / result.seconds << " cells/s\n";
  return kExitSuccess;
}

int Merge(const std::vector<std::string>& folders) {
  CatchInterrupts();
  for (const std::string& folder : folders) {
    std::error_code ignored;
    if (std::filesystem::equivalent(folder, FLAGS_output, ignored)) {
      throw Error(ErrorKind::kUsage, "--output: " + FLAGS_output + ": expected another folder than those to be merged");
    }
  }
  if (LandscapeStore::ExistsIn(FLAGS_output)) {
    throw Error(ErrorKind::kUsage, "--output: " + FLAGS_output + ": holds the cells of a scan that was stopped");
  }
  const LandscapePart part = MergeLandscapes(folders);
  OutputFolder output(FLAGS_output);
  WriteLandscape(part.landscape, part.origin, &output);
  output.Commit();
  PrintSummary(part);
  return kExitSuccess;
}

int Plot(const std::vector<std::string>& folders) {
  const std::atomic<bool>& interrupted = CatchInterrupts();
  const LandscapePart part = ReadWholeLandscape(folders.front());
  const LandscapePictures pictures = PlotLandscape(part, Summarize(part.landscape), folders.front());
  std::cout << pictures.html << "\n";
  if (pictures.note.empty()) {
    std::cout << pictures.png << "\n";
  } else {
    std::cerr << "landscape: " << pictures.note << "\n";
  }
  return interrupted ? kExitInterrupted : kExitSuccess;
}

}  // namespace
}  // namespace clothid

int main(int argc, char** argv) {
  clothid::Program program = {"landscape", clothid::kHelp, clothid::kMoreHelp};
  program.commands = {
      {"",
       {},
       "target scene x y zoom_around zoom zoom_only sweep set contact sigma initial result gradients shard "
       "resume threads output",
       clothid::Scan},
      {"merge", {"..."}, "output", clothid::Merge},
      {"plot", {"one folder"}, "", clothid::Plot}};
  program.lists = {{"zoom_around", ','}, {"zoom", ','}, {"set", ','}, {"sweep", ';'}};
  clothid::RunCommandLine(program, argc, argv);
}
