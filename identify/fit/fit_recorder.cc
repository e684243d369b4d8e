#include "identify/fit/fit_recorder.h"

#include "identify/problem/gauss_newton.h"

namespace clothid {

FitRecorder::FitRecorder(const FitOptions& options, const FitProblem& problem, const FitEvaluator& evaluator)
    : options_(options), problem_(problem), evaluator_(evaluator), start_(std::chrono::steady_clock::now()) {}

ceres::CallbackReturnType FitRecorder::operator()(const ceres::IterationSummary& summary) {
  num_failures_ = evaluator_.num_failures();
  Add(goal_.first_iteration + summary.iteration);
  if (options_.is_cancelled()) return ceres::SOLVER_ABORT;
  const bool has_model = goal_.has_rows && summary.step_is_successful;
  return has_model && NextStepIsNegligible(problem_, evaluator_.model(), goal_.step, goal_.function_tolerance)
             ? ceres::SOLVER_TERMINATE_SUCCESSFULLY
             : ceres::SOLVER_CONTINUE;
}

void FitRecorder::AddStart() { Add(0); }

void FitRecorder::StartStage(const StageGoal& goal) {
  goal_ = goal;
  num_failures_ = evaluator_.num_failures();
}

std::string FitRecorder::failure() const {
  return evaluator_.num_failures() > num_failures_ ? evaluator_.last_failure() : std::string();
}

void FitRecorder::AddLast() {
  if (!evaluator_.best().is_valid() || evaluator_.best_is_superseded()) return;
  if (iterations_.empty() || iterations_.back().precision != evaluator_.best().precision ||
      evaluator_.best().cost < iterations_.back().cost) {
    Add(iterations_.empty() ? 0 : iterations_.back().iteration + 1);
  }
}

double FitRecorder::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void FitRecorder::Add(int iteration) {
  FitIteration row;
  row.iteration = iteration;
  row.precision = evaluator_.best().precision;
  row.seconds = seconds();
  row.cost = evaluator_.best().cost;
  row.values = problem_.Values(evaluator_.best().coordinates);
  row.gradient_norm = evaluator_.best_gradient_norm();
  row.rollouts = evaluator_.statistics().rollouts;
  iterations_.push_back(row);
  if (options_.on_iteration) options_.on_iteration(row);
}

}  // namespace clothid
