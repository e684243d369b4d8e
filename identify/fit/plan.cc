#include "identify/fit/plan.h"

#include <algorithm>

#include "identify/problem/memory_trial.h"
#include "identify/problem/unknown_basis.h"

namespace clothid {
namespace {

constexpr double kShares[] = {0.125, 0.25, 0.5};  // of the time that was recorded
// Half waves a side of the smoothest modes that fields have at first, then; after that all.
constexpr int kCoarseModes[] = {4, 8};

// What is estimated beside the parameters: the stages with loose rollouts, or of the only precision, and the last.
void AddJointStages(const FitProblem& problem, Precision first, FitPlan* plan) {
  FitStage joint;
  joint.precision = first;
  joint.is_rough = true;
  joint.with_starts = problem.num_start_unknowns() > 0 && !problem.assimilation().is_on();
  joint.with_weights = problem.chooses_weights();
  int side = 0;  // of the largest control grid
  for (const FieldRequest& field : problem.fields()) side = std::max({side, field.rows, field.columns});
  for (const int modes : kCoarseModes) {
    if (modes >= side) continue;
    joint.field_modes = modes;
    plan->push_back(joint);
  }
  joint.field_modes = side > 0 ? kAllModes : 0;
  const bool has_weights_alone = problem.num_unknowns() == 0;
  if (first == Precision::kLoose && !has_weights_alone) plan->push_back(joint);
  joint.precision = Precision::kFull;
  joint.is_rough = false;
  plan->push_back(joint);
  if (!has_weights_alone) return;
  FitStage last;  // with the weights that were chosen the parameters go to their end as any
  plan->push_back(last);
}

}  // namespace

FitPlan MakePlan(const FitOptions& options, const FitProblem& problem, bool is_led) {
  FitPlan plan;
  const bool has_free = !problem.is_all_frozen();
  const bool is_loose =
      has_free && options.precision != FitPrecision::kFull && options.jacobian != JacobianMethod::kNumeric;
  const bool ends_loosely = is_loose && options.precision == FitPrecision::kLoose;
  for (const double share : kShares) {
    if (!is_led || !has_free || problem.assimilation().is_on()) break;
    FitStage first;
    first.share = share;
    first.precision = is_loose ? Precision::kLoose : Precision::kFull;
    first.is_rough = true;
    plan.push_back(first);
  }
  const double memory = problem.assimilation().memory;
  const bool has_unknowns = problem.num_unknowns() > (memory > 0.0 ? problem.num_start_unknowns() : 0);
  const bool has_others = !ends_loosely && (has_unknowns || problem.chooses_weights());
  const bool is_weighed = problem.has_model_error();
  FitStage alone;
  alone.precision = is_loose ? Precision::kLoose : Precision::kFull;
  alone.is_rough = (is_loose && !ends_loosely) || has_others;
  // Where frames are weighed, everything is near its place.
  if (has_free && !(is_weighed && has_others)) plan.push_back(alone);
  if (has_others) {
    AddJointStages(problem, alone.precision, &plan);
  } else if (is_loose && !ends_loosely) {
    alone.precision = Precision::kFull;
    alone.is_rough = false;
    plan.push_back(alone);
  }
  for (FitStage& stage : plan) {
    stage.is_weighed = is_weighed;
    stage.memory = memory;
  }
  return plan;
}

FitPlan PlanMemoryTrials(const FitProblem& problem) {
  FitPlan plan;
  if (problem.is_all_frozen()) return plan;
  for (const double memory : MemoriesOf(problem)) {
    FitStage stage;
    stage.memory = memory;
    stage.is_trial = true;
    plan.push_back(stage);
  }
  return plan;
}

}  // namespace clothid
