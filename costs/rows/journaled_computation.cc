#include "costs/rows/journaled_computation.h"

namespace clothid {

void JournaledComputation::Complete(const EvaluationKey& key, const EvaluationCache& recent,
                                    RolloutEvaluation* evaluation, CostStatistics* statistics) {
  if (journal_ == nullptr || computation_->options().is_cancelled()) {
    return computation_->Complete(key, recent, evaluation, statistics);
  }
  try {
    if (error_) throw *error_;
    if (const auto outcome = journal_->Replay(key)) {
      Replay(key, *outcome, recent, evaluation);
      *statistics += outcome->statistics;
    } else {
      ComputeAndAppend(key, recent, evaluation, statistics);
    }
  } catch (const Error& error) {
    error_ = error;
    evaluation->failure = error.what();
  }
}

void JournaledComputation::Replay(const EvaluationKey& key, const EvaluationOutcome& outcome,
                                  const EvaluationCache& recent, RolloutEvaluation* evaluation) {
  Eigen::MatrixXd predicted = std::move(evaluation->predicted);
  *evaluation = outcome.evaluation;
  if (evaluation->is_new()) evaluation->predicted = std::move(predicted);
  if (!evaluation->is_new()) {
    evaluation->residuals = computation_->model().observation().Residuals(evaluation->predicted);
  }
  computation_->Resume(key, outcome, recent, *evaluation);
}

void JournaledComputation::ComputeAndAppend(const EvaluationKey& key, const EvaluationCache& recent,
                                            RolloutEvaluation* evaluation, CostStatistics* statistics) {
  const bool was_new = evaluation->is_new();
  const bool takes_first_jacobian = was_new && computation_->TakesFirstJacobian();
  EvaluationOutcome outcome;
  computation_->Complete(key, recent, evaluation, &outcome.statistics);
  *statistics += outcome.statistics;
  if (computation_->options().is_cancelled()) return;
  outcome.evaluation = *evaluation;
  outcome.rollout_coordinates = computation_->rollout_coordinates();
  if (takes_first_jacobian) outcome.first_jacobian = computation_->last_jacobian();
  if (!was_new || !evaluation->ok()) outcome.evaluation.predicted.resize(0, 0);
  journal_->Append(key, std::move(outcome));
}

}  // namespace clothid
