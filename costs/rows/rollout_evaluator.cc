#include "costs/rows/rollout_evaluator.h"

#include <utility>

#include "costs/rows/evaluated_residuals.h"

namespace clothid {

RolloutEvaluator::RolloutEvaluator(const RecordedMotion& motion, std::vector<ParameterBlock> blocks,
                                   const RolloutCostOptions& options)
    : computation_(motion, std::move(blocks), options), cache_(options.num_differences + 1) {
  if (options.journal != nullptr) journaled_.emplace(&computation_, options.journal);
}

void RolloutEvaluator::SetModelError(const ModelError& error) {
  computation_.SetModelError(error);
  for (RolloutEvaluation& evaluation : *cache_.mutable_evaluations()) {
    evaluation.has_rows = evaluation.has_gradient = evaluation.has_exact_rows = false;
    if (!evaluation.ok() || evaluation.is_new()) continue;
    SetCost(options().loss, model().observation(), &evaluation);
    evaluation.residuals.resize(0);
  }
}

RolloutEvaluation* RolloutEvaluator::FindOrAdd(const EvaluationKey& key) {
  RolloutEvaluation* const known = cache_.Find(key.coordinates, key.precision);
  if (known == nullptr) return cache_.Add(key.coordinates, key.precision);
  if (known->ok() && !known->is_new() && known->residuals.size() == 0) {
    known->residuals = model().observation().Residuals(known->predicted, known->forces);
  }
  return known;
}

const RolloutEvaluation& RolloutEvaluator::At(const EvaluationKey& key) {
  RolloutEvaluation* const evaluation = FindOrAdd(key);
  if (evaluation->ok() && evaluation->Lacks(key)) {
    if (journaled_ && !options().is_cancelled()) {
      journaled_->Complete(key, cache_, evaluation, &statistics_);
    } else {
      computation_.Complete(key, cache_, evaluation, &statistics_);
    }
    last_failure_ = evaluation->failure;
    if (!evaluation->ok() && options().is_cancelled()) return TakeFailure(evaluation);
  }
  last_failure_ = evaluation->failure;
  return *evaluation;
}

const RolloutEvaluation& RolloutEvaluator::TakeFailure(RolloutEvaluation* evaluation) {
  cancelled_ = RolloutEvaluation();
  cancelled_.coordinates = evaluation->coordinates;
  cancelled_.precision = evaluation->precision;
  cancelled_.failure = std::exchange(evaluation->failure, {});
  if (evaluation->is_new()) cache_.Remove(evaluation);
  return cancelled_;
}

}  // namespace clothid
