// Which rollouts and sweeps an evaluation takes, and what they leave behind for the next one.
#ifndef CLOTHID_COSTS_ROWS_ROLLOUT_COMPUTATION_H_
#define CLOTHID_COSTS_ROWS_ROLLOUT_COMPUTATION_H_

#include <vector>

#include "costs/prediction/parameter_block.h"
#include "costs/prediction/recording_model.h"
#include "costs/prediction/rollout_cost_options.h"
#include "costs/rows/adjoint_rows.h"
#include "costs/rows/curvature_product.h"
#include "costs/rows/evaluation_cache.h"
#include "costs/rows/forward_rows.h"
#include "costs/rows/latest_rollout.h"
#include "costs/rows/rollout_evaluation.h"
#include "datasets/motion/recorded_motion.h"

namespace clothid {

class RolloutComputation {
 public:
  // Throws `Error` where `RecordingModel` does.
  RolloutComputation(const RecordedMotion& motion, std::vector<ParameterBlock> blocks,
                     const RolloutCostOptions& options);
  RolloutComputation(const RolloutComputation&) = delete;
  RolloutComputation& operator=(const RolloutComputation&) = delete;

  // Adds what `key` asks for and `evaluation` lacks. What went wrong stands in `failure`, and all else is as it was
  // then; only internal errors are thrown: no memory left, what a callback throws. `recent`: evaluations that may help.
  // `statistics`: what it took is added, also of a failure.
  void Complete(const EvaluationKey& key, const EvaluationCache& recent, RolloutEvaluation* evaluation,
                CostStatistics* statistics);

  // The prediction of a point, made as `Complete` makes that of a new one, bit by bit; with it, the first Jacobian
  // where `Complete` takes it. Throws `std::runtime_error` where it fails. What is known of the latest rollout is void
  // until `Resume`.
  Eigen::MatrixXd PredictAgain(const EvaluationKey& key);

  // From now on; rollouts and Jacobians of before stay what they are.
  void SetModelError(const ModelError& error) { model_.SetModelError(error); }

  // From now on; what is known of the latest rollout must have been forgotten.
  void Assimilate(const Assimilation& assimilation);

  // Whether `Complete` takes the first Jacobian, by a forward sweep.
  bool TakesFirstJacobian(const EvaluationKey& key) const;
  // The next points are far from those before: the subspace of the adjoint starts afresh.
  void ForgetJacobian() { adjoint_rows_.SetLastJacobian(Eigen::MatrixXd()); }
  // As if nothing had been computed before.
  void Forget() {
    latest_.Drop();
    curvature_.Forget();
    ForgetJacobian();
  }

  // The latest rollout is made again where it is needed.
  void DropRollout() { latest_.Drop(); }

  // What an outcome tells beside its evaluation, and the way back: as if `Complete` had just computed `evaluation`.
  // `took_first_jacobian`: in doing so; where the outcome does not have it, it was made again.
  const Eigen::VectorXd& rollout_coordinates() const { return latest_.coordinates; }
  const Eigen::MatrixXd& last_jacobian() const { return adjoint_rows_.last_jacobian(); }
  void Resume(const EvaluationKey& key, EvaluationOutcome outcome, bool took_first_jacobian,
              const EvaluationCache& recent, const RolloutEvaluation& evaluation);

  int num_rows() const;                                                 // without the row of the loss
  const std::vector<int>& free_blocks() const { return free_blocks_; }  // not frozen
  // The same, and all unknowns.
  const std::vector<int>& free_coordinates() const { return free_coordinates_; }
  const RolloutCostOptions& options() const { return options_; }
  const RecordingModel& model() const { return model_; }

 private:
  // Each of these adds its part or throws.
  void Add(const EvaluationKey& key, const EvaluationCache& recent, RolloutEvaluation* evaluation,
           CostStatistics* statistics);
  // Prediction and cost of a point that is new, with rows where they come along.
  void AddPrediction(const EvaluationKey& key, RolloutEvaluation* evaluation, CostStatistics* statistics);
  void AddCost(const EvaluationKey& key, RolloutEvaluation* evaluation, CostStatistics* statistics);
  // Rows, which are exact, and to a point that is new its prediction and cost.
  void AddForwardRows(const EvaluationKey& key, RolloutEvaluation* evaluation, CostStatistics* statistics);
  void AddRows(const EvaluationKey& key, const EvaluationCache& recent, RolloutEvaluation* evaluation,
               CostStatistics* statistics);
  void AddGradient(const EvaluationKey& key, const EvaluationCache& recent, RolloutEvaluation* evaluation,
                   CostStatistics* statistics);
  void AddExactRows(const EvaluationKey& key, RolloutEvaluation* evaluation, CostStatistics* statistics);
  // Runs the rollout of a point, with `passes_left` further passes to come, and counts it. Throws `std::runtime_error`
  // where it fails. The rest as of RecordingModel::Simulate.
  Rollout Simulate(const Eigen::VectorXd& coordinates, Precision precision, int passes_left, Eigen::MatrixXd* predicted,
                   Eigen::MatrixXd* velocities, ForceTrack* forces, CostStatistics* statistics);
  // The rollout of an evaluation: the latest if it is that, else it is run, and the latest from then on.
  const LatestRollout& RolloutOf(const RolloutEvaluation& evaluation, int passes_left, CostStatistics* statistics);
  // Whether the columns of a sweep for `key` are kept, for pull-backs from its point.
  bool KeepsBlockRows(const EvaluationKey& key) const;
  // The columns of a forward sweep that are asked for: of rows, those of the unknowns are some of the unit vectors.
  SweepColumns ColumnsOf(const EvaluationKey& key) const;
  // Along the kept rollout where there are fields, as it keeps its factors for that.
  ForwardRows Sweep(const RolloutEvaluation& evaluation, const SweepColumns& columns, int num_rows, bool keeps_jacobian,
                    CostStatistics* statistics);
  // Whether a forward sweep gives the prediction of a new point, and its rows along with it.
  bool StartsWithForwardSweep(const EvaluationKey& key) const;
  // Unknowns are too many for a column each: their gradient comes from the adjoint, whatever the method.
  bool TakesAdjointGradient(const EvaluationKey& key) const;
  // How many passes give the derivatives that are asked for, once there is a rollout.
  int PassesAfterRollout(const EvaluationKey& key) const;
  PassOptions LastPass(Precision precision) const { return {precision, options_.cancel, /*passes_left=*/0}; }

  RolloutCostOptions options_;
  RecordingModel model_;
  std::vector<int> free_blocks_, free_coordinates_;
  LatestRollout latest_;
  AdjointRows adjoint_rows_;
  CurvatureProduct curvature_;
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_ROWS_ROLLOUT_COMPUTATION_H_
