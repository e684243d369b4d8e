// Rows, cost and gradient of one recording, with a cache by parameter values. The engine of `RolloutCost`.
//
// From above: the cache (costs/rows/evaluation_cache.h), what is computed (costs/rows/rollout_computation.h) and how:
// costs/rows/adjoint_rows.h, forward_rows.h, numeric_rows.h. Where there is a journal, it is asked before anything is
// computed (costs/rows/journaled_computation.h).
#ifndef CLOTHID_COSTS_ROWS_ROLLOUT_EVALUATOR_H_
#define CLOTHID_COSTS_ROWS_ROLLOUT_EVALUATOR_H_

#include <optional>
#include <string>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "costs/prediction/recording_model.h"
#include "costs/prediction/rollout_cost_options.h"
#include "costs/rows/evaluation_cache.h"
#include "costs/rows/journaled_computation.h"
#include "costs/rows/rollout_computation.h"
#include "costs/rows/rollout_evaluation.h"
#include "datasets/motion/recorded_motion.h"
#include "sim/base/error.h"

namespace clothid {

class RolloutEvaluator {
 public:
  // Throws `Error` where `RecordingModel` does.
  RolloutEvaluator(const RecordedMotion& motion, std::vector<ParameterBlock> blocks, const RolloutCostOptions& options);

  // What `key` asks for. What went wrong stands in `failure`; only internal errors are thrown: no memory left, what a
  // callback throws. The reference is valid until the next call.
  // A failure is remembered, but not where `RolloutCostOptions::cancel` was set: then the point is as it was before.
  const RolloutEvaluation& At(const EvaluationKey& key);

  // Weighs the rows of all that was evaluated and of what will be by it.
  void SetModelError(const ModelError& error);

  // Of all that will be evaluated; what was is forgotten.
  void Assimilate(const Assimilation& assimilation) {
    Forget();
    computation_.Assimilate(assimilation);
  }

  // Forgets what the last Jacobian was: the next points are far from it.
  void ForgetJacobian() { computation_.ForgetJacobian(); }
  // As if nothing had been evaluated before, but for the counts: what the next points take does not depend on it.
  void Forget() {
    cache_.Clear();
    computation_.Forget();
  }

  // Other points of any precision as if they had not been evaluated, but for the counts; no rollout is kept.
  void KeepOnly(const Eigen::VectorXd& coordinates) {
    cache_.KeepOnly(coordinates);
    computation_.DropRollout();
  }

  int num_rows() const { return computation_.num_rows(); }  // without the row of the loss
  const std::vector<int>& free_blocks() const { return computation_.free_blocks(); }
  const std::vector<int>& free_coordinates() const { return computation_.free_coordinates(); }
  const RolloutCostOptions& options() const { return computation_.options(); }
  const RecordingModel& model() const { return computation_.model(); }
  const CostStatistics& statistics() const { return statistics_; }
  const std::string& last_failure() const { return last_failure_; }
  // See JournaledComputation::error; null where nothing is wrong, or there is no journal.
  const Error* journal_error() const { return journaled_ && journaled_->error() ? &*journaled_->error() : nullptr; }

 private:
  // The cached evaluation with its residuals, or a new one.
  RolloutEvaluation* FindOrAdd(const EvaluationKey& key);
  // A copy that has failed, of an evaluation that has not.
  const RolloutEvaluation& TakeFailure(RolloutEvaluation* evaluation);

  RolloutComputation computation_;
  std::optional<JournaledComputation> journaled_;  // absent without a journal
  EvaluationCache cache_;
  RolloutEvaluation cancelled_;  // the last one that was
  std::string last_failure_;
  CostStatistics statistics_;
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_ROWS_ROLLOUT_EVALUATOR_H_
