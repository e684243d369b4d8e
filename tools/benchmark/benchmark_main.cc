// benchmark: accuracy, time and stability of the simulation and its derivatives.
#include <gflags/gflags.h>

#include <chrono>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "identify/base/command_line.h"
#include "identify/base/output_folder.h"
#include "sim/base/error.h"
#include "sim/base/program.h"
#include "tools/benchmark/benchmark_flags.h"
#include "tools/benchmark/benchmark_help.h"

DECLARE_string(output);

namespace clothid {
namespace {

// Thrown out of a benchmark after a signal: it ends with the item that it is at.
struct Interrupted {};

// Prints every item: "3 of 128: wind, 48 nodes; 310 s left", where the time is right for items of one size. Throws
// `Interrupted` after a signal.
BenchmarkProgress ReportProgress() {
  return [start = std::chrono::steady_clock::now()](const std::string& item, int num_done, int num_items) {
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    std::cerr << Format("%d of %d: %s; %.0f s left\n", num_done, num_items, item.c_str(),
                        seconds.count() / num_done * (num_items - num_done));
    if (IsInterrupted()) throw Interrupted();
  };
}

BenchmarkProgress* ProgressOf(BackpropOptions* options) { return &options->cases.on_progress; }
template <typename Options>
BenchmarkProgress* ProgressOf(Options* options) {
  return &options->on_progress;
}

// Runs the mode `name`, prints its table and, on request, writes NAME.csv.
template <auto options_from_flags, auto run, auto table, auto csv>
int RunMode(const std::string& name) {
  auto options = options_from_flags();
  options.Validate();
  CatchInterrupts();
  std::optional<OutputFolder> folder;  // before the benchmark, so that it does not run in vain
  if (!FLAGS_output.empty()) folder.emplace(FLAGS_output);
  *ProgressOf(&options) = ReportProgress();
  const auto benchmark = run(options);
  if (folder) {
    folder->Write(name + ".csv", csv(benchmark));
    folder->Commit();
  }
  std::cout << table(benchmark);
  return kExitSuccess;
}

struct Subcommand {
  const char* name;
  const char* help;
  const char* flags;  // that it takes, separated by blanks
  int (*run)(const std::string& name);
};

constexpr Subcommand kSubcommands[] = {
    {"forward", kForwardHelp, "scene integrator nodes steps repeats output",
     RunMode<ForwardOptionsFromFlags, RunForwardBenchmark, ForwardTable, ForwardCsv>},
    {"backprop", kBackpropHelp, "scene settings nodes steps methods repeats output",
     RunMode<BackpropOptionsFromFlags, RunBackpropBenchmark, BackpropTable, BackpropCsv>},
    {"accuracy", kAccuracyHelp, "scene settings quantities integrator nodes repeats output",
     RunMode<AccuracyOptionsFromFlags, RunAccuracyBenchmark, AccuracyTable, AccuracyCsv>},
    {"stability", kStabilityHelp,
     "settings scene integrator contact k_stretch stiffening steps mu nodes threads output",
     RunMode<StabilityOptionsFromFlags, RunStabilityBenchmark, StabilityTable, StabilityCsv>},
};

int Run(const Subcommand& command) {
  try {
    return command.run(command.name);
  } catch (const Interrupted&) {
    std::cerr << "benchmark: interrupted, nothing is written\n";
    return kExitInterrupted;
  }
}

}  // namespace
}  // namespace clothid

int main(int argc, char** argv) {
  clothid::Program program = {"benchmark", clothid::kBenchmarkHelp, clothid::kBenchmarkMore};
  for (const clothid::Subcommand& each : clothid::kSubcommands) {
    program.commands.push_back({each.name,
                                {},
                                each.flags,
                                [&each](const std::vector<std::string>&) { return clothid::Run(each); },
                                each.help});
  }
  clothid::RunCommandLine(program, argc, argv);
}
