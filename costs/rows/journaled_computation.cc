#include "costs/rows/journaled_computation.h"

#include <cstdint>
#include <stdexcept>

namespace clothid {

void JournaledComputation::Complete(const EvaluationKey& key, const EvaluationCache& recent,
                                    RolloutEvaluation* evaluation, CostStatistics* statistics) {
  try {
    if (error_) throw *error_;
    if (auto outcome = journal_->Replay(key)) {
      const CostStatistics counted_before = outcome->statistics;
      Replay(key, *std::move(outcome), recent, evaluation);
      *statistics += counted_before;
    } else {
      ComputeAndAppend(key, recent, evaluation, statistics);
    }
  } catch (const Error& error) {
    error_ = error;
    evaluation->failure = error.what();
  } catch (const std::runtime_error& error) {  // of a prediction that was to be made again
    evaluation->failure = computation_->model().name() + ": " + error.what();
    if (!computation_->options().is_cancelled()) error_ = Error(ErrorKind::kBadData, evaluation->failure);
  }
}

// A prediction or a first Jacobian that the journal had no room for is made again.
void JournaledComputation::Replay(const EvaluationKey& key, EvaluationOutcome outcome, const EvaluationCache& recent,
                                  RolloutEvaluation* evaluation) {
  if (IsProduct(key.need)) {
    evaluation->failure = std::move(outcome.evaluation.failure);
    evaluation->product = std::move(outcome.evaluation.product);
    return computation_->Resume(key, std::move(outcome), /*took_first_jacobian=*/false, recent, *evaluation);
  }
  const bool took_first_jacobian = computation_->TakesFirstJacobian(key);
  Eigen::MatrixXd predicted = std::move(evaluation->predicted);
  *evaluation = std::move(outcome.evaluation);
  if (evaluation->is_new()) evaluation->predicted = std::move(predicted);
  const bool lacks_jacobian = took_first_jacobian && outcome.first_jacobian.size() == 0;
  if (evaluation->ok() && (evaluation->is_new() || lacks_jacobian)) {
    evaluation->predicted = computation_->PredictAgain(key);
  }
  if (!evaluation->is_new()) {
    evaluation->residuals = computation_->model().observation().Residuals(evaluation->predicted, evaluation->forces);
  }
  computation_->Resume(key, std::move(outcome), took_first_jacobian, recent, *evaluation);
}

void JournaledComputation::ComputeAndAppend(const EvaluationKey& key, const EvaluationCache& recent,
                                            RolloutEvaluation* evaluation, CostStatistics* statistics) {
  const bool was_new = evaluation->is_new();
  const bool takes_first_jacobian = computation_->TakesFirstJacobian(key);
  EvaluationOutcome outcome;
  computation_->Complete(key, recent, evaluation, &outcome.statistics);
  *statistics += outcome.statistics;
  if (computation_->options().is_cancelled()) return;
  outcome.rollout_coordinates = computation_->rollout_coordinates();
  if (IsProduct(key.need)) {  // all else of the point is known
    outcome.evaluation.failure = evaluation->failure;
    outcome.evaluation.product = evaluation->product;
    return journal_->Append(key, &outcome);
  }
  const Eigen::Index num_first = takes_first_jacobian ? computation_->last_jacobian().size() : 0;
  const Eigen::Index num_predicted = was_new ? evaluation->predicted.size() : 0;
  const bool has_room = journal_->HasRoomFor(static_cast<std::uint64_t>(num_predicted + num_first));
  if (has_room && num_first > 0) outcome.first_jacobian = computation_->last_jacobian();
  Append(key, was_new && evaluation->ok() && has_room, std::move(outcome), evaluation);
}

// Predictions are large, so they are moved there and back.
void JournaledComputation::Append(const EvaluationKey& key, bool with_prediction, EvaluationOutcome outcome,
                                  RolloutEvaluation* evaluation) {
  Eigen::MatrixXd predicted;
  if (!with_prediction) predicted.swap(evaluation->predicted);
  outcome.evaluation = std::move(*evaluation);
  const auto give_back = [&] {
    *evaluation = std::move(outcome.evaluation);
    if (!with_prediction) predicted.swap(evaluation->predicted);
  };
  try {
    journal_->Append(key, &outcome);
  } catch (...) {
    give_back();
    throw;
  }
  give_back();
}

}  // namespace clothid
