// Evaluations of a fit that has a journal: what it holds is replayed, what is computed is added to it before it is
// used.
#ifndef CLOTHID_COSTS_ROWS_JOURNALED_COMPUTATION_H_
#define CLOTHID_COSTS_ROWS_JOURNALED_COMPUTATION_H_

#include <memory>
#include <optional>
#include <utility>

#include "costs/rows/evaluation_cache.h"
#include "costs/rows/evaluation_journal.h"
#include "costs/rows/rollout_computation.h"
#include "costs/rows/rollout_evaluation.h"
#include "sim/base/error.h"

namespace clothid {

class JournaledComputation {
 public:
  // `computation` must outlive it.
  JournaledComputation(RolloutComputation* computation, std::shared_ptr<EvaluationJournal> journal)
      : computation_(computation), journal_(std::move(journal)) {}

  // As RolloutComputation::Complete, in the order of the journal, counts included. Not to be called once
  // `RolloutCostOptions::cancel` is set: nothing is replayed or added then.
  void Complete(const EvaluationKey& key, const EvaluationCache& recent, RolloutEvaluation* evaluation,
                CostStatistics* statistics);

  // What is wrong with the journal; once it is set every evaluation fails with its message.
  const std::optional<Error>& error() const { return error_; }

 private:
  void Replay(const EvaluationKey& key, EvaluationOutcome outcome, const EvaluationCache& recent,
              RolloutEvaluation* evaluation);
  void ComputeAndAppend(const EvaluationKey& key, const EvaluationCache& recent, RolloutEvaluation* evaluation,
                        CostStatistics* statistics);
  // `outcome`: all but the evaluation, which is as it was afterwards.
  void Append(const EvaluationKey& key, bool with_prediction, EvaluationOutcome outcome, RolloutEvaluation* evaluation);

  RolloutComputation* computation_;
  std::shared_ptr<EvaluationJournal> journal_;
  std::optional<Error> error_;
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_ROWS_JOURNALED_COMPUTATION_H_
