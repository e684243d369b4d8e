#include "costs/rows/rollout_evaluator.h"

#include <utility>

namespace clothid {

RolloutEvaluator::RolloutEvaluator(const RecordedMotion& motion, std::vector<ParameterBlock> blocks,
                                   const RolloutCostOptions& options)
    : computation_(motion, std::move(blocks), options),
      journaled_(&computation_, options.journal),
      cache_(options.num_differences + 1) {}

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
    journaled_.Complete(key, cache_, evaluation, &statistics_);
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
