#include "identify/fit/fit.h"

#include "identify/estimate/fit_uncertainty.h"
#include "identify/fit/continued_fit.h"
#include "identify/fit/descent.h"
#include "identify/fit/first_frames.h"
#include "identify/fit/memory_search.h"
#include "identify/fit/plan.h"
#include "identify/problem/memory_trial.h"
#include "identify/problem/model_errors.h"
#include "identify/uncertainty/discretization_error.h"

namespace clothid {
namespace {

// Led by first frames where `motions` are known.
FitSummary DescendFromStart(const FitOptions& options, FitProblem* problem,
                            const std::vector<RecordedMotion>* motions) {
  const bool is_led = motions != nullptr && options.growing_horizon && options.max_iterations > 0;
  if (!is_led) return Descend(options, problem);
  Descent descent(options, problem);
  Lead lead;
  if (descent.Begin(MakePlan(options, *problem, is_led))) {
    lead = LeadByFirstFrames(*motions, options, *problem, &descent);
    descent.RunStages();
    descent.GoOnFromLowerStart();
  }
  FitSummary summary = descent.End(/*is_answer=*/true);
  AddLead(lead, &summary);
  return summary;
}

// A fit that has an estimate, with all that the steps after it read and change.
struct FitState {
  const FitOptions& options;
  const std::vector<RecordedMotion>* motions;  // those of the problem; may be null
  FitProblem* problem;
  FitSummary* summary;
};

bool LeavesMoreThanNoise(const FitState& fit) { return MayAssimilate(fit.options, *fit.problem, *fit.summary); }
void TryMemories(const FitState& fit) { AssimilateFit(fit.options, fit.motions, fit.problem, fit.summary); }

bool IsAlways(const FitState&) { return true; }
void WeighFrames(const FitState& fit) { WeighByModelError(fit.options, fit.problem, fit.summary); }

// Whether what is said of the uncertainty is of other weights, or was not found out.
bool IsToBeJudged(const FitState& fit) {
  return (fit.problem->finds_model_error() && fit.problem->has_model_error()) || !fit.summary->uncertainty;
}
// How sure it is, and on from the lower points that the check of that meets.
void JudgeEstimate(const FitState& fit) {
  AddUncertainty(fit.options, *fit.problem, fit.summary);
  ContinueFromLowerPoints(fit.options, fit.problem, fit.summary);
}

bool HasDrift(const FitState& fit) {
  return fit.summary->uncertainty && fit.problem->assimilation().is_on() && !fit.summary->memory_trials.empty();
}
void AddDrift(const FitState& fit) {
  const std::vector<ParameterBlock>& blocks = fit.problem->blocks();
  const Eigen::VectorXd end = fit.summary->coordinates.head(fit.problem->num_blocks());
  AddMemoryErrors(blocks, end, DriftOf(fit.summary->memory_trials, end), &*fit.summary->uncertainty);
}

struct FitStep {
  bool (*is_needed)(const FitState& fit);
  void (*run)(const FitState& fit);
};

constexpr FitStep kJudgeSteps[] = {
    {&LeavesMoreThanNoise, &TryMemories},
    {&IsAlways, &JudgeEstimate},
};
// Memories are tried here where the fit before was not asked to, as one that chooses the time step is not.
constexpr FitStep kWeighSteps[] = {
    {&LeavesMoreThanNoise, &TryMemories},
    {&IsAlways, &WeighFrames},
    {&IsToBeJudged, &JudgeEstimate},
    {&HasDrift, &AddDrift},
};

template <std::size_t n>
void RunSteps(const FitStep (&steps)[n], const FitState& fit) {
  for (const FitStep& step : steps) {
    if (step.is_needed(fit)) step.run(fit);
  }
}

}  // namespace

FitSummary Fit(const FitOptions& options, FitProblem* problem) { return Fit(options, problem, nullptr); }

FitSummary Fit(const FitOptions& options, FitProblem* problem, const std::vector<RecordedMotion>* motions) {
  if (options.assimilate.kind == AssimilationOption::Kind::kAuto) problem->Assimilate({});
  if (problem->finds_model_error() && problem->has_model_error()) problem->SetModelErrors(NoModelErrors(*problem));
  FitSummary summary = DescendFromStart(options, problem, motions);
  if (options.estimate_uncertainty && summary.has_estimate()) FinishFit(options, problem, &summary, motions);
  return summary;
}

void FinishFit(const FitOptions& options, FitProblem* problem, FitSummary* summary,
               const std::vector<RecordedMotion>* motions) {
  RunSteps(kJudgeSteps, {options, motions, problem, summary});
  WeighFit(options, problem, summary, motions);
}

void WeighFit(const FitOptions& options, FitProblem* problem, FitSummary* summary,
              const std::vector<RecordedMotion>* motions) {
  RunSteps(kWeighSteps, {options, motions, problem, summary});
}

}  // namespace clothid
