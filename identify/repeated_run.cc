#include "identify/repeated_run.h"

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>

#include "identify/base/output_folder.h"
#include "identify/base/parallel_for.h"
#include "identify/card/card_of_fit.h"
#include "identify/problem/problem_blocks.h"
#include "identify/repetition/finished_fits.h"
#include "identify/report/report.h"

namespace clothid {
namespace {

constexpr char kPredictionName[] = "predicted.bin";

std::vector<std::string> NamesIn(const Scene& scene, const std::vector<std::string>& names) {
  std::vector<std::string> own;
  for (const std::string& name : names) {
    if (HasParameter(scene, name)) own.push_back(name);
  }
  return own;
}

// What is given for recording `index`, to which a fit of it alone gives no number: "drag@2" of the second is its
// "drag".
template <typename Value>
std::map<std::string, Value> GivenFor(const Scene& scene, int index, const std::map<std::string, Value>& given) {
  std::map<std::string, Value> own;
  for (const auto& [name, value] : given) {
    if (BaseName(name) == name && HasParameter(scene, name)) own.emplace(name, value);
  }
  const std::string suffix = "@" + std::to_string(index + 1);
  for (const auto& [name, value] : given) {
    const std::string base = BaseName(name);
    if (name == base + suffix && HasParameter(scene, base)) own.insert_or_assign(base, value);
  }
  return own;
}

// A run of `motion` alone.
RunOptions SingleRun(const RunOptions& options, const RecordedMotion& motion, int index) {
  RunOptions single;
  single.targets = {motion};
  single.holdout_frames = options.holdout_frames;
  single.holdout_draws = options.holdout_draws;
  single.calibrates_bands = options.calibrates_bands && options.holdout_frames.has_value();
  single.time_step = options.time_step;
  single.step_tolerance = options.step_tolerance;
  single.check_recordings = false;      // the joint run has looked
  single.finds_missing_forces = false;  // nobody predicts by it, but for what it holds out
  single.wind = options.wind;
  single.discretization = options.discretization;
  single.fit = options.fit;
  single.fit.parameters = NamesIn(motion.scene, options.fit.parameters);
  single.fit.each = NamesIn(motion.scene, options.fit.each);
  ParameterOverrides* const overrides = &single.fit.overrides;
  overrides->start = GivenFor(motion.scene, index, overrides->start);
  overrides->lower_bounds = GivenFor(motion.scene, index, overrides->lower_bounds);
  overrides->upper_bounds = GivenFor(motion.scene, index, overrides->upper_bounds);
  overrides->priors = GivenFor(motion.scene, index, overrides->priors);
  single.fit.num_threads = 1;
  single.fit.on_iteration = nullptr;  // whose iterations these are nobody could tell
  single.fit.on_start = nullptr;
  single.fit.on_stage = nullptr;
  single.fit.on_progress = nullptr;
  return single;
}

RecordedMotion RecordingOf(const RunOptions& options, std::size_t r) {
  return options.targets.empty() ? ReadMotion(options.target_paths[r], options.reading) : options.targets[r];
}

// What the fit of a recording, with the others held out, has predicted of them.
TransferRow DescribeTransfer(const std::string& name, const RunResult& result) {
  TransferRow row;
  row.name = name;
  if (!result.checks.held_bands) {
    row.why_not = result.summary.has_estimate() ? "its fit tells no interval" : result.summary.message;
    return row;
  }
  row.why_not = result.checks.held_bands->why_not;
  row.predicted = result.checks.held_bands->recordings;
  row.has_only_forces = result.checks.holdout && result.checks.holdout->has_only_forces;
  return row;
}

struct OneFit {
  SingleFit fit;
  TransferRow row;
};

OneFit FitOne(const RunOptions& options, const RunCall& identify, int index, int num) {
  const RecordedMotion motion = RecordingOf(options, static_cast<std::size_t>(index));
  RunOptions single = SingleRun(options, motion, index);
  if (single.fit.parameters.empty() && !options.fit.parameters.empty() && single.fit.each.empty()) {
    SingleFit none;
    none.name = motion.name;
    none.why_not_used = "it has no parameter of --fit";
    return {none, {motion.name, none.why_not_used, {}}};
  }
  for (int other = 0; options.transfer && other < num; ++other) {
    if (other != index) single.holdouts.push_back(RecordingOf(options, static_cast<std::size_t>(other)));
  }
  const RunResult result = identify(single);
  return {DescribeSingleFit(motion.name, motion.sha256, result), DescribeTransfer(motion.name, result)};
}

FitSummary SummaryOfMeans(const Repetitions& repetitions) {
  FitSummary summary;
  summary.status = FitStatus::kConverged;
  summary.message = "pooled from " + std::to_string(repetitions.fits.size()) + " finished fits";
  for (const PooledParameter& pooled : repetitions.parameters) {
    FittedParameter parameter;
    parameter.name = pooled.name;
    parameter.value = pooled.mean;
    parameter.scale = pooled.scale;
    summary.parameters.push_back(parameter);
  }
  return summary;
}

std::unique_ptr<OutputFolder> OpenOutput(const RunOptions& options, const std::vector<std::string>& folders) {
  if (options.output.empty()) return nullptr;
  for (const std::string& folder : folders) {
    const std::string result = (std::filesystem::path(folder) / "result.json").string();
    ExpectNotReplaced("--target", result, options.output, IsReportFile);
  }
  return std::make_unique<OutputFolder>(options.output);
}

// The cloth for exports: that of the first fit.
std::optional<Scene> SceneOf(const RunOptions& options, const std::string& folder) {
  if (options.simulators.empty()) return std::nullopt;
  return ReadMotion((std::filesystem::path(folder) / kPredictionName).string()).scene;
}

// Of all of them; none where one has no card, as older fits, or another law.
std::optional<FabricCard> CardOf(const std::vector<std::string>& folders, const Repetitions& repetitions) {
  std::vector<FabricCard> cards;
  for (const std::string& folder : folders) {
    const std::filesystem::path path = std::filesystem::path(folder) / kFabricCardName;
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored)) return std::nullopt;
    cards.push_back(ReadFabricCard(path.string()));
    if (cards.back().membrane != cards.front().membrane) return std::nullopt;
  }
  return PooledCard(cards, repetitions);
}

}  // namespace

EachFit FitEach(const RunOptions& options, const RunCall& identify) {
  const auto num = static_cast<int>(std::max(options.targets.size(), options.target_paths.size()));
  std::vector<OneFit> fits(static_cast<std::size_t>(num));
  const auto fit = [&](int r) {
    if (!options.fit.is_cancelled()) fits[static_cast<std::size_t>(r)] = FitOne(options, identify, r, num);
  };
  const auto tell = [&](int r, int num_done) {
    const bool is_told = options.on_repetition && !options.fit.is_cancelled();
    if (is_told) options.on_repetition(fits[static_cast<std::size_t>(r)].fit, num_done, num);
  };
  ParallelFor(num, options.fit.num_threads, fit, tell);
  EachFit each;
  if (options.fit.is_cancelled()) return each;
  for (OneFit& one : fits) {
    each.fits.push_back(std::move(one.fit));
    if (options.transfer) each.transfer.rows.push_back(std::move(one.row));
  }
  return each;
}

SingleFit DescribeSingleFit(const std::string& name, const std::string& sha256, const RunResult& result) {
  SingleFit fit;
  fit.name = name;
  fit.sha256 = sha256;
  const FitSummary& summary = result.summary;
  if (!summary.has_estimate()) {
    fit.why_not_used = summary.message;
  } else if (result.exit_code == kExitNotConverged || result.exit_code == kExitDoNotUse) {
    fit.why_not_used = result.verdict.line;
  }
  for (int i = 0; i < static_cast<int>(summary.parameters.size()); ++i) {
    const FittedParameter& parameter = summary.parameters[static_cast<std::size_t>(i)];
    SingleEstimate estimate;
    estimate.name = parameter.name;
    estimate.scale = parameter.scale;
    estimate.is_frozen = parameter.frozen;
    estimate.value = parameter.value;
    estimate.lower_bound = parameter.lower_bound;
    estimate.upper_bound = parameter.upper_bound;
    if (HasInterval(summary, result.checks, i)) {
      const ParameterUncertainty& uncertainty = summary.uncertainty->parameters[static_cast<std::size_t>(i)];
      estimate.std = uncertainty.std;
      estimate.lower95 = uncertainty.lower95;
      estimate.upper95 = uncertainty.upper95;
      estimate.step_error = uncertainty.step_error;
      estimate.mesh_error = uncertainty.mesh_error;
    }
    fit.estimates.push_back(estimate);
  }
  return fit;
}

std::vector<std::string> SharedParameters(const FitSummary& summary) {
  std::vector<std::string> names;
  for (const FittedParameter& parameter : summary.parameters) {
    const bool is_shared = BaseName(parameter.name) == parameter.name;
    if (is_shared && !parameter.frozen && !parameter.is_knot) names.push_back(parameter.name);
  }
  return names;
}

RunResult JudgeFinishedFits(const RunOptions& options) {
  const std::vector<std::string> folders = FindFinishedFits(options.target_paths);
  ExpectUsage(folders.size() > 1, "--repeat: expected at least two finished fits");
  const std::vector<SingleFit> fits = ReadFinishedFits(folders);
  ExpectDifferentRecordings(fits);
  const std::vector<std::string> names = SharedParameters(fits, options.fit.parameters, options.fit.each);
  ExpectUsage(!names.empty(), "--repeat: expected a parameter that all fits share; see --fit and --each");
  const std::optional<Scene> scene = SceneOf(options, folders.front());
  const std::unique_ptr<OutputFolder> output = OpenOutput(options, folders);
  RunResult result;
  result.checks.repetitions = Pool(fits, names);
  result.checks.repetitions->is_of_folders = true;
  result.checks.flags = options.command_line;
  result.checks.num_threads = options.fit.num_threads;
  result.summary = SummaryOfMeans(*result.checks.repetitions);
  result.verdict = Judge(result.summary, result.checks);
  result.exit_code = result.verdict.exit_code;
  result.table = PooledTable(result.checks, result.verdict);
  if (options.on_table) options.on_table(result.table);
  if (output != nullptr) {
    ReportOptions report;
    report.page = options.report_page;
    report.simulators = options.simulators;
    const std::optional<FabricCard> card = CardOf(folders, *result.checks.repetitions);
    WritePooledReport(result.summary, result.checks, result.verdict, scene ? &*scene : nullptr, card ? &*card : nullptr,
                      output.get(), report);
  }
  return result;
}

}  // namespace clothid
