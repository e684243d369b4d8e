// benchmark: accuracy, cost and time of the methods against each other.
#include <gflags/gflags.h>
#include <glog/logging.h>

#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "identify/base/output_folder.h"
#include "identify/base/parallel_for.h"
#include "sim/base/error.h"
#include "sim/base/program.h"
#include "tools/base/command_line.h"
#include "tools/benchmark/benchmark_flags.h"
#include "tools/benchmark/benchmark_help.h"
#include "tools/benchmark/benchmark_progress.h"
#include "tools/benchmark/fits/coverage_table.h"

DECLARE_string(output);
DECLARE_int32(threads);

namespace clothid {
namespace {

template <typename Benchmark>
struct CsvFile {
  std::string name;
  std::string (*text)(const Benchmark&);
};

// Runs the benchmark `run`, prints its table and, on request, writes its files.
template <typename Options, typename Benchmark>
int RunBenchmark(Options options, Benchmark (*run)(const Options&), std::string (*table)(const Benchmark&),
                 const std::vector<CsvFile<Benchmark>>& files) {
  options.Validate();
  CatchInterrupts();
  std::optional<OutputFolder> folder;  // before the fits, so that they do not run in vain
  if (!FLAGS_output.empty()) folder.emplace(FLAGS_output);
  ReportProgress(&options);
  const Benchmark benchmark = run(options);
  if (folder) {
    for (const CsvFile<Benchmark>& file : files) folder->Write(file.name, file.text(benchmark));
    folder->Commit();
  }
  std::cout << table(benchmark);
  return kExitSuccess;
}

struct Subcommand {
  const char* name;
  const char* flags;  // that it takes, separated by blanks
  int (*run)();
};

constexpr Subcommand kSubcommands[] = {
    {"jacobian", "scene set noise starts methods precision seed threads output",
     [] {
       return RunBenchmark<JacobianBenchmarkOptions, JacobianBenchmark>(
           JacobianOptionsFromFlags(), RunJacobianBenchmark, JacobianTable, {{"jacobian.csv", JacobianCsv}});
     }},
    {"coverage",
     "scene set sensor initial cut handle_sigma seeds settings noise sigma frame_rate markers truth_steps truth_levels "
     "discretization start_factor seed "
     "threads output",
     [] {
       return RunBenchmark<CoverageOptions, CoverageBenchmark>(CoverageOptionsFromFlags(), RunCoverageBenchmark,
                                                               CoverageTable, {{"coverage.csv", CoverageCsv}});
     }},
    {"fields", "scene set nodes settings sigma seed output",
     [] {
       return RunBenchmark<FieldsOptions, FieldsBenchmark>(FieldsOptionsFromFlags(), RunFieldsBenchmark, FieldsTable,
                                                           {{"fields.csv", FieldsCsv}});
     }},
    {"forward", "scene integrator bending nodes steps repeats output",
     [] {
       return RunBenchmark<ForwardBenchmarkOptions, ForwardBenchmark>(ForwardOptionsFromFlags(), RunForwardBenchmark,
                                                                      ForwardTable, {{"forward.csv", ForwardCsv}});
     }},
    {"backprop", "scene settings nodes steps methods repeats output",
     [] {
       return RunBenchmark<BackpropOptions, BackpropBenchmark>(BackpropOptionsFromFlags(), RunBackpropBenchmark,
                                                               BackpropTable, {{"backprop.csv", BackpropCsv}});
     }},
    {"accuracy", "scene settings quantities integrator nodes repeats output",
     [] {
       return RunBenchmark<AccuracyOptions, AccuracyBenchmark>(AccuracyOptionsFromFlags(), RunAccuracyBenchmark,
                                                               AccuracyTable, {{"curve.csv", AccuracyCsv}});
     }},
    {"stability", "settings scene integrator contact k_stretch steps mu nodes gradients seed threads output",
     [] {
       return RunBenchmark<StabilityOptions, StabilityBenchmark>(
           StabilityOptionsFromFlags(), RunStabilityBenchmark, StabilityTable,
           {{"stability.csv", StabilityCsv}, {"stability_extremes.csv", StabilityExtremesCsv}});
     }},
};

// Throws `Error` (kUsage), naming all commands, unless `arguments` are the name of one of them.
const Subcommand& FindSubcommand(const std::vector<std::string>& arguments) {
  std::string known;
  for (const Subcommand& command : kSubcommands) known += (known.empty() ? "" : ", ") + std::string(command.name);
  known = "; there is: " + known + "; see benchmark --help";
  if (arguments.empty()) throw Error(ErrorKind::kUsage, "a command is missing" + known);
  if (arguments.size() > 1) throw Error(ErrorKind::kUsage, "'" + arguments[1] + "': unexpected argument");
  for (const Subcommand& command : kSubcommands) {
    if (arguments[0] == command.name) return command;
  }
  throw Error(ErrorKind::kUsage, "'" + arguments[0] + "': unknown command" + known);
}

int Run(const std::vector<std::string>& arguments) {
  const Subcommand& command = FindSubcommand(arguments);
  std::vector<CommandFlags> flags;
  for (const Subcommand& each : kSubcommands) flags.push_back({each.name, each.flags});
  RejectOtherFlags(command.name, flags);
  try {
    return command.run();
  } catch (const Interrupted&) {
    std::cerr << "benchmark: interrupted, nothing is written\n";
    return kExitInterrupted;
  }
}

}  // namespace
}  // namespace clothid

int main(int argc, char** argv) {
  // Ceres logs through glog: to stderr, and only what is fatal.
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = google::GLOG_FATAL;
  google::InitGoogleLogging(argv[0]);
  return clothid::RunCommand("benchmark", clothid::kBenchmarkHelp, argc, argv, clothid::Run);
}
