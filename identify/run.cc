#include "identify/run.h"

#include <cmath>
#include <memory>
#include <utility>

#include "datasets/checking/motion_check.h"
#include "datasets/motion/motion_validation.h"
#include "identify/base/output_folder.h"
#include "identify/checks/discretization_check.h"
#include "identify/checks/excluded_side.h"
#include "identify/checks/gradient_check.h"
#include "identify/checks/multi_start.h"
#include "identify/checks/prediction_check.h"
#include "identify/checks/profile.h"
#include "identify/checks/step_error.h"
#include "identify/export/export.h"
#include "identify/fit/fit.h"
#include "identify/landscape/fit_landscape.h"
#include "identify/prediction/force_match.h"
#include "identify/prediction/judge_bands.h"
#include "identify/prediction/posterior.h"
#include "identify/problem/memory_trial.h"
#include "identify/problem/problem.h"
#include "identify/problem/problem_blocks.h"
#include "identify/repeated_run.h"
#include "identify/report/node_prediction.h"
#include "identify/report/report.h"
#include "identify/wind/wind_request.h"
#include "identify/wind/wind_result.h"
#include "sim/base/phase_seconds.h"
#include "sim/scene/refinement.h"

namespace clothid {
namespace {

std::vector<RecordedMotion> ReadAll(const std::vector<std::string>& paths, const RunOptions& options) {
  std::vector<RecordedMotion> motions;
  for (const std::string& path : paths) motions.push_back(ReadMotion(path, options.reading));
  return motions;
}

// What is found in a recording. Throws `Error` (kBadData) where it is a problem.
std::vector<Finding> CheckRecording(const RunOptions& options, const RecordedMotion& motion) {
  ValidateMotion(motion);
  std::vector<Finding> findings = CheckMotion(motion);
  for (const Finding& finding : findings) {
    if (finding.severity == Severity::kProblem) {
      throw Error(ErrorKind::kBadData, motion.name + ": cannot be fitted as it is: " + finding.what + ": " +
                                           finding.value + "; " + finding.hint + " (--check=false fits it anyway)");
    }
    if (finding.severity == Severity::kWarning && options.on_finding) options.on_finding(motion.name, finding);
  }
  return findings;
}

// The recordings to fit and those, or their frames, to judge on, and landscapes of the first.
struct RunInputs {
  std::vector<RecordedMotion> fitted, held_out;
  std::vector<std::vector<Finding>> findings;  // of those that are fitted
  std::vector<FitLandscape> landscapes;
};

// As yet without estimates.
std::vector<SingleFit> NamesOf(const std::vector<RecordedMotion>& motions) {
  std::vector<SingleFit> fits(motions.size());
  for (std::size_t r = 0; r < motions.size(); ++r) {
    fits[r].name = motions[r].name;
    fits[r].sha256 = motions[r].sha256;
  }
  return fits;
}

RunInputs ReadInputs(const RunOptions& options) {
  RunInputs inputs;
  inputs.fitted = options.targets.empty() ? ReadAll(options.target_paths, options) : options.targets;
  inputs.held_out = options.holdouts.empty() ? ReadAll(options.holdout_paths, options) : options.holdouts;
  if (options.check_recordings) {
    for (const RecordedMotion& motion : inputs.fitted) inputs.findings.push_back(CheckRecording(options, motion));
    for (const RecordedMotion& motion : inputs.held_out) CheckRecording(options, motion);
  }
  for (std::vector<RecordedMotion>* motions : {&inputs.fitted, &inputs.held_out}) {
    for (RecordedMotion& motion : *motions) {
      if (options.step_tolerance > 0.0) motion.scene.solver.step_tolerance = options.step_tolerance;
      if (options.time_step.seconds > 0.0) motion.scene.time_step = options.time_step.seconds;
    }
  }
  if (options.wind.is_given()) SetWindProfile(options.wind, &inputs.fitted);
  if (!options.fit.fields.empty()) SetFlatFields(options.fit, &inputs.fitted);
  for (const std::string& folder : options.landscape_paths) {
    inputs.landscapes.push_back(ReadFitLandscape(folder, inputs.fitted));
  }
  if (options.repeat || options.transfer) ExpectDifferentRecordings(NamesOf(inputs.fitted));
  if (options.holdout_frames) inputs.held_out = HoldOutFrames(*options.holdout_frames, &inputs.fitted);
  return inputs;
}

// One run, from the recordings that were read to the files that are written.
class Run {
 public:
  // Throws `Error` where something that was asked for cannot be done.
  explicit Run(const RunOptions& options)
      : options_(options),
        inputs_(ReadInputs(options)),
        folder_(OpenFolder(options)),
        fit_options_(FitOptionsOf(options, folder_.get())),
        problem_(std::make_unique<FitProblem>(inputs_.fitted, fit_options_)) {
    // The gradient of all unknowns but the parameters is that of the adjoint, whatever the Jacobian.
    const bool has_sweeps = fit_options_.jacobian == JacobianMethod::kAdjoint || options.check_gradients ||
                            problem_->num_unknowns() > 0 || problem_->chooses_weights();
    ExpectUsage(
        has_sweeps || (fit_options_.adjoint.method == AdjointMethod::kReduced && !fit_options_.adjoint.threshold),
        "--adjoint: expected with --jacobian adjoint, or with other unknowns than parameters");
    for (const std::string& name : options.profiles) FindFreeBlock(*problem_, name, "--profile");
    for (const RecordedMotion& motion : inputs_.fitted) {
      if (options.discretization.mesh) ExpectRefinable(motion.scene, "--discretization: " + motion.name);
      if (!options.simulators.empty()) ExpectExportable(motion.scene, "--export: " + motion.name);
    }
    for (FitLandscape& landscape : inputs_.landscapes) MatchLandscape(problem_->blocks(), &landscape);
    checks_.landscapes = std::move(inputs_.landscapes);
    checks_.findings = std::move(inputs_.findings);
    checks_.jacobian = fit_options_.jacobian;
    checks_.flags = options.command_line;
    checks_.seed = fit_options_.seed;
    checks_.num_threads = fit_options_.num_threads;
  }

  void SetEachFit(EachFit each) {
    if (options_.repeat) single_fits_ = std::move(each.fits);
    if (!each.transfer.rows.empty()) checks_.transfer = std::move(each.transfer);
  }

  RunResult Finish() {
    TellParameters();
    if (CheckGradientsAtStart()) RunFit();
    if (summary_.has_estimate()) Examine();
    if (options_.on_examined) options_.on_examined(summary_);
    RunResult result;
    if (summary_.has_estimate()) result.table = ResultTable(summary_, checks_);
    if (summary_.has_estimate() && options_.on_table) options_.on_table(result.table);
    const bool keeps = summary_.has_estimate() && options_.keep_recordings;
    if (summary_.has_estimate() && (keeps || folder_ != nullptr)) PredictWholeCloth();
    SetFittedFields(&inputs_.fitted);  // until here the problem's unknowns make them
    if (summary_.has_estimate() && folder_ != nullptr) Write();
    if (keeps) result.recordings = std::move(inputs_.fitted);
    result.verdict = Judge(summary_, checks_);
    result.exit_code = result.verdict.exit_code;
    result.summary = std::move(summary_);
    result.checks = std::move(checks_);
    return result;
  }

 private:
  static std::unique_ptr<OutputFolder> OpenFolder(const RunOptions& options) {
    if (options.output.empty()) return nullptr;
    for (const std::string& path : options.target_paths)
      ExpectNotReplaced("--target", path, options.output, IsReportFile);
    for (const std::string& path : options.holdout_paths)
      ExpectNotReplaced("--holdout", path, options.output, IsReportFile);
    ExpectNotReplaced("--scene", options.reading.scene_path, options.output, IsReportFile);
    ExpectNotReplaced("--fabric", options.fabric_card, options.output, IsReportFile);
    return std::make_unique<OutputFolder>(options.output);
  }

  static FitOptions FitOptionsOf(const RunOptions& options, const OutputFolder* folder) {
    FitOptions fit = options.fit;
    if (options.resume) fit.journal_folder = folder->path();
    if (options.wind.is_given()) AddKnots(options.wind, &fit);
    fit.chooses_wind_smoothness = options.wind.is_given() && fit.wind_smoothness == 0.0;
    if (fit.chooses_wind_smoothness) fit.wind_smoothness = kFirstWindSmoothness;
    return fit;
  }

  void TellParameters() const {
    if (!options_.on_problem) return;
    std::vector<std::string> names;
    for (const ParameterBlock& block : problem_->blocks()) names.push_back(block.name);
    options_.on_problem(names);
  }

  // False where a rollout failed, and the fit could not even start.
  bool CheckGradientsAtStart() {
    if (!options_.check_gradients) return true;
    checks_.gradient_check = CheckGradients(inputs_.fitted, fit_options_);
    if (checks_.gradient_check->failure.empty()) return true;
    summary_.status = fit_options_.is_cancelled() ? FitStatus::kInterrupted : FitStatus::kFailed;
    summary_.message = checks_.gradient_check->failure;
    return false;
  }

  void RunFit() {
    FitOptions options = fit_options_;
    if (options_.time_step.is_automatic) {  // the step's error is to be compared with noise
      options.weighs_model_error = false;
      if (options.assimilate.kind == AssimilationOption::Kind::kAuto) options.assimilate = {};
    }
    summary_ = fit_options_.num_starts == 1
                   ? Fit(options, problem_.get(), &inputs_.fitted)
                   : FitFromStarts(options, inputs_.fitted, problem_.get(), &checks_.starts.emplace());
    if (options_.time_step.is_automatic) FitWithChosenStep();
    SetFittedFields(&inputs_.held_out);  // what is held out moves with the same cloth
    if (options_.on_fitted) options_.on_fitted(summary_);
  }

  void SetFittedFields(std::vector<RecordedMotion>* motions) const {
    if (!summary_.fields) return;
    for (const FittedField& field : summary_.fields->fields) SetField({field.request.kind, field.values}, motions);
  }

  void FitWithChosenStep() {
    checks_.step_choice = ChooseTimeStep(inputs_.fitted, fit_options_, *problem_, &summary_);
    const StepChoice& choice = *checks_.step_choice;
    if (fit_options_.is_cancelled()) return;
    if (choice.level == 0) {
      if (summary_.uncertainty) WeighFit(fit_options_, problem_.get(), &summary_, &inputs_.fitted);
      return;
    }
    const double factor = std::exp2(choice.level);
    for (std::vector<RecordedMotion>* motions : {&inputs_.fitted, &inputs_.held_out}) {
      for (RecordedMotion& motion : *motions) motion.scene.time_step *= factor;
    }
    fit_options_.journal_tag = "chosen_step";
    const FitSummary first = std::move(summary_);
    const std::unique_ptr<FitProblem> before =
        std::exchange(problem_, std::make_unique<FitProblem>(inputs_.fitted, fit_options_));
    problem_->TakeWeights(*before);
    problem_->SetStart(choice.start);
    FitOptions options = fit_options_;
    options.growing_horizon = false;
    summary_ = Fit(options, problem_.get(), &inputs_.fitted);
    for (FitStage& stage : summary_.plan) stage.step_factor = factor;
    AddEarlierFit(first, &summary_);
  }

  // What was asked for beside the fit.
  void Examine() {
    const ScopedTimer timer(&summary_.total_seconds);
    problem_->KeepOnly(summary_.coordinates);  // rollouts of other steps and scenes need the memory
    checks_.recordings = DescribeRecordings(inputs_.fitted, summary_, fit_options_.loss);
    AddExcludedSides(fit_options_, problem_.get(), &summary_);
    checks_.step_error = AddStepError(inputs_.fitted, fit_options_, *problem_, &summary_);
    if (options_.wind.is_given()) {
      checks_.wind = DescribeWind(inputs_.fitted, summary_, *problem_);
    }
    PredictionCheck prediction = CheckPredictions(inputs_.fitted, *problem_, summary_, fit_options_.cancel);
    checks_.energy = std::move(prediction.energy);
    checks_.self_contact = std::move(prediction.self_contact);
    for (const std::string& name : options_.profiles) {
      if (!summary_.uncertainty || fit_options_.is_cancelled()) break;
      checks_.profiles.push_back(ProfileParameter(fit_options_, summary_, name, problem_.get(), &summary_.statistics));
    }
    // What the choice has fitted at other steps tells of rollouts without corrections.
    const bool has_step = checks_.step_choice && checks_.step_choice->found && !summary_.assimilation.is_on();
    if ((options_.discretization.any() || has_step) && !fit_options_.is_cancelled()) {
      const DiscretizationCheck known = has_step ? checks_.step_choice->check : DiscretizationCheck();
      checks_.discretization =
          CheckDiscretization(inputs_.fitted, fit_options_, options_.discretization, *problem_, &summary_, known);
    }
    if (!inputs_.held_out.empty()) {
      const HeldOut held_out = options_.holdout_frames ? HeldOut::kFrames : HeldOut::kRecordings;
      LeadTimes ahead(LastAssimilation(summary_), fit_options_.loss);
      checks_.holdout = EvaluateHoldout(inputs_.held_out, problem_->blocks(), summary_.values(), held_out,
                                        options_.holdout_frames ? FittedStarts() : std::vector<HeldOutStart>(),
                                        fit_options_.loss, options_.holdout_frames ? nullptr : &ahead);
    }
    checks_.uncorrected_error = PredictUncorrected(inputs_.fitted, *problem_, &summary_);
    checks_.lead_times = PredictAhead(inputs_.fitted, *problem_, summary_, fit_options_.loss);
    checks_.corrections = CheckCorrections(inputs_.fitted, *problem_, summary_, fit_options_.loss);
    const bool predicts = options_.finds_missing_forces || !inputs_.held_out.empty();
    if (predicts && summary_.uncertainty && !fit_options_.is_cancelled()) MatchMissingForces();
    if (checks_.holdout && summary_.uncertainty && options_.holdout_draws > 0) JudgeBands();
    if (!single_fits_.empty()) checks_.repetitions = Pool(single_fits_, SharedParameters(summary_));
    if (fit_options_.is_cancelled()) {
      summary_.status = FitStatus::kInterrupted;
      summary_.message = kInterruptedMessage;
    }
  }

  // Where noise is all that the fit leaves, nothing is missing. Of a fit that must not be used nobody predicts, but for
  // what it holds out.
  void MatchMissingForces() {
    const std::optional<LastingForce> told = MeanForce(checks_.corrections);
    if (told) checks_.missing_forces = {*told};
    if (inputs_.held_out.empty() && Judge(summary_, checks_).overall == Usability::kDoNotUse) return;
    if (!summary_.assimilation.is_on() && LeavesNoise(*problem_, summary_.predicted, summary_.cost)) return;
    ForceMatchOptions options;
    options.seed = fit_options_.seed;
    options.num_threads = fit_options_.num_threads;
    options.cancel = fit_options_.cancel;
    const auto match = [&](const std::vector<RecordedMotion>& motions) {
      return MatchForces(motions, problem_->blocks(), summary_.values(), FittedStarts(), told, options);
    };
    if (!summary_.fields) {
      checks_.missing_forces = match(inputs_.fitted);
      return;
    }
    std::vector<RecordedMotion> with_fields = inputs_.fitted;
    SetFittedFields(&with_fields);
    checks_.missing_forces = match(with_fields);
  }

  void JudgeBands() {
    HeldBandOptions options;
    options.num_draws = options_.holdout_draws;
    options.seed = fit_options_.seed;
    options.num_threads = fit_options_.num_threads;
    options.calibrates = options_.calibrates_bands;
    options.cancel = fit_options_.cancel;
    checks_.held_bands = JudgeByBands(inputs_.held_out, problem_->blocks(), summary_.values(),
                                      PosteriorOf(summary_, checks_.missing_forces),
                                      options_.holdout_frames ? HeldOut::kFrames : HeldOut::kRecordings,
                                      options_.holdout_frames ? FittedStarts() : std::vector<HeldOutStart>(), options);
    if (fit_options_.is_cancelled()) checks_.held_bands.reset();
  }

  // Where the recordings were found to start.
  std::vector<HeldOutStart> FittedStarts() const {
    std::vector<HeldOutStart> starts;
    for (int r = 0; r < problem_->num_recordings(); ++r) {
      const RecordingModel& model = problem_->cost(r).model();
      starts.push_back({model.shared_start(), model.StartUnknowns(problem_->CoordinatesOf(r, summary_.coordinates))});
    }
    return starts;
  }

  // For the replay of the page, and for how far the cloth was strained.
  void PredictWholeCloth() {
    if (options_.report_page || folder_ != nullptr)
      checks_.predicted_nodes = PredictNodes(inputs_.fitted, *problem_, summary_);
  }

  void Write() {
    if (summary_.status == FitStatus::kInterrupted) folder_->KeepJournals();
    problem_->CheckJournals();
    ReportOptions report;
    report.page = options_.report_page;
    report.simulators = options_.simulators;
    problem_.reset();  // what is to be written takes memory of its own
    WriteReport(summary_, checks_, inputs_.fitted, folder_.get(), report);
  }

  const RunOptions& options_;
  RunInputs inputs_;
  std::vector<SingleFit> single_fits_;    // of repetitions
  std::unique_ptr<OutputFolder> folder_;  // null: nothing is written
  FitOptions fit_options_;
  std::unique_ptr<FitProblem> problem_;  // until the files are written
  FitSummary summary_;
  FitChecks checks_;
};

}  // namespace

RunResult Identify(const RunOptions& options) {
  options.Validate();
  if (options.judges_folders()) return JudgeFinishedFits(options);
  Run run(options);
  if (options.repeat || options.transfer) run.SetEachFit(FitEach(options, Identify));
  return run.Finish();
}

}  // namespace clothid
