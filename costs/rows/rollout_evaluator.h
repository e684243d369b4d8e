// Rows, cost and gradient of one recording, with a cache by parameter values. The engine of `RolloutCost`.
#ifndef CLOTHID_COSTS_ROWS_ROLLOUT_EVALUATOR_H_
#define CLOTHID_COSTS_ROWS_ROLLOUT_EVALUATOR_H_

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "costs/prediction/recording_model.h"
#include "costs/prediction/rollout_cost_options.h"
#include "costs/rows/compressed_jacobian.h"
#include "datasets/motion/recorded_motion.h"
#include "sim/base/error.h"
#include "sim/rollout/rollout.h"

namespace clothid {

struct EvaluationOutcome;

// The rows for Ceres, without the row of the loss.
struct ResidualRows {
  std::vector<int> active;    // the blocks that were differentiated, increasing
  Eigen::VectorXd residuals;  // [r]
  Eigen::MatrixXd jacobian;   // [r x q]
  // [q x T] J_i^T e_i over the rows of frame i, weighted by the loss: their sum is the gradient. Of forward sweeps
  // alone.
  Eigen::MatrixXd frame_scores;
};

// One point of the parameter space and what is known about it.
struct RolloutEvaluation {
  Eigen::VectorXd coordinates;
  Precision precision = Precision::kFull;
  std::string failure;        // not empty: nothing else is valid
  Eigen::MatrixXd predicted;  // [R x T] m, see Observation
  Eigen::VectorXd residuals;  // [m] e of the prediction; empty where others were asked for since
  RolloutCounts counts;       // of the rollout
  double cost = 0.0;          // L
  double loss_row = 0.0;      // sqrt(2 L - |w e|^2), see costs/prediction/robust_loss.h
  bool has_rows = false;
  ResidualRows rows;
  bool has_gradient = false;
  Eigen::VectorXd gradient;  // [p] dL/dq
  bool has_exact_rows = false;
  ResidualRows exact_rows;  // of the sensitivities, whatever the method of `rows`

  bool ok() const { return failure.empty(); }
};

class RolloutEvaluator {
 public:
  // Throws `Error` where `RecordingModel` does.
  RolloutEvaluator(const RecordedMotion& motion, std::vector<ParameterBlock> blocks, const RolloutCostOptions& options);
  RolloutEvaluator(const RolloutEvaluator&) = delete;
  RolloutEvaluator& operator=(const RolloutEvaluator&) = delete;

  enum class Need { kCost, kRows, kGradient, kExactRows };
  // What is needed at `coordinates` [p], the derivatives for the blocks `active` at least. What went wrong stands
  // in `failure`; only errors of the program itself are thrown (no memory left, what a callback throws). The reference
  // is valid until the next call. With a journal, what it holds is replayed in its order, counts included, and what is
  // computed is added to it before it is used; not once `RolloutCostOptions::cancel` is set.
  const RolloutEvaluation& At(const Eigen::VectorXd& coordinates, Need need, const std::vector<int>& active);

  // Of the evaluations from now on; those of the other precision are not mistaken for them.
  void SetPrecision(Precision precision);
  // Forgets what the last Jacobian was: the next points are far from it.
  void ForgetJacobian() { last_jacobian_.resize(0, 0); }

  int num_rows() const;                                                 // without the row of the loss
  const std::vector<int>& free_blocks() const { return free_blocks_; }  // not frozen
  const RolloutCostOptions& options() const { return options_; }
  const RecordingModel& model() const { return model_; }
  const CostStatistics& statistics() const { return statistics_; }
  const std::string& last_failure() const { return last_failure_; }
  // What is wrong with the journal; once it is set every evaluation fails with its message.
  const std::optional<Error>& journal_error() const { return journal_error_; }

 private:
  RolloutEvaluation& FindOrAdd(const Eigen::VectorXd& coordinates);
  // Whether `Complete` has anything to do.
  bool Lacks(Need need, const std::vector<int>& active, const RolloutEvaluation& evaluation) const;
  // `Complete` by way of the journal, where there is one.
  void CompleteOrReplay(Need need, const std::vector<int>& active, RolloutEvaluation* evaluation);
  void Restore(const EvaluationOutcome& outcome, Need need, RolloutEvaluation* evaluation);
  // `Complete` whose exceptions end in `failure`.
  void CompleteOrFail(Need need, const std::vector<int>& active, RolloutEvaluation* evaluation);
  // Each of these fills its part of `evaluation` or throws.
  void Complete(Need need, const std::vector<int>& active, RolloutEvaluation* evaluation);
  // How many passes give the derivatives that are needed.
  int PassesAfterRollout(Need need, const std::vector<int>& active) const;
  void ComputeCost(RolloutEvaluation* evaluation);
  void ComputeWithSensitivities(const std::vector<int>& active, RolloutEvaluation* evaluation);
  void ComputeExactRows(const std::vector<int>& active, RolloutEvaluation* evaluation);
  void ComputeAdjointRows(const std::vector<int>& active, RolloutEvaluation* evaluation);
  void ComputeNumericRows(const std::vector<int>& active, RolloutEvaluation* evaluation);
  void ComputeGradient(const std::vector<int>& active, RolloutEvaluation* evaluation);

  Rollout Run(const Eigen::VectorXd& coordinates, Eigen::MatrixXd* predicted, Eigen::MatrixXd* velocities = nullptr);
  const Rollout& RolloutAt(const Eigen::VectorXd& coordinates);
  // Weighted residuals w e and weights w of the loss at an evaluated point.
  Eigen::VectorXd WeightedResiduals(const RolloutEvaluation& evaluation, Eigen::VectorXd* weights) const;
  Eigen::MatrixXd BasisVectors(const RolloutEvaluation& evaluation) const;
  // The change of the residual from an evaluated point to another prediction: [m].
  Eigen::VectorXd ResidualChange(const RolloutEvaluation& from, const Eigen::MatrixXd& to) const;
  // The basis B of the adjoint rows at an evaluated point, and the weights w of the loss: B^T w e are the rows.
  Eigen::MatrixXd Basis(const RolloutEvaluation& evaluation, Eigen::VectorXd* weights) const;
  // Sets `last_jacobian_` to what adjoint rows in `basis` tell of it.
  void KeepJacobian(const Eigen::VectorXd& weights, const Eigen::MatrixXd& basis, const ResidualRows& rows);
  bool TakesFirstJacobian() const;
  // Prediction, cost and loss row of `evaluation`, and [J e] compressed, in one forward sweep. `jacobian` may be null:
  // J without the weights of the loss [m x q]. `frame_scores`: see `ResidualRows`.
  CompressedJacobian SweepForward(const std::vector<int>& active, RolloutEvaluation* evaluation,
                                  Eigen::MatrixXd* jacobian, Eigen::MatrixXd* frame_scores);
  static ResidualRows CompressedRows(const std::vector<int>& active, int num_rows, CompressedJacobian* compressed);

  RolloutCostOptions options_;
  Precision precision_ = Precision::kFull;
  RecordingModel model_;
  int passes_left_ = 0;  // of what `Complete` is at, beside the pass under way
  std::vector<int> free_blocks_;
  std::deque<RolloutEvaluation> recent_;  // the latest first; bounded
  Eigen::MatrixXd last_jacobian_;         // [m x q] without the weights of the loss, as far as known; empty: not at all
  Rollout rollout_;                       // of `rollout_coordinates_`: trajectories are large, so there is one
  Eigen::MatrixXd rollout_predicted_;
  Eigen::MatrixXd rollout_velocities_;  // see RecordingModel::Simulate
  Eigen::VectorXd rollout_coordinates_;
  bool rollout_was_replayed_ = false;  // so `rollout_` has yet to be made
  std::string last_failure_;
  std::optional<Error> journal_error_;
  CostStatistics statistics_;
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_ROWS_ROLLOUT_EVALUATOR_H_
