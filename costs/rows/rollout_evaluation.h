// One point of the parameter space: what is asked of it, and what is known about it.
#ifndef CLOTHID_COSTS_ROWS_ROLLOUT_EVALUATION_H_
#define CLOTHID_COSTS_ROWS_ROLLOUT_EVALUATION_H_

#include <Eigen/Core>
#include <algorithm>
#include <string>
#include <vector>

#include "costs/prediction/rollout_cost_options.h"
#include "sim/rollout/rollout.h"

namespace clothid {

enum class EvaluationNeed {
  kCost,       // prediction, residuals and cost
  kRows,       // and the rows of the method that the cost has
  kGradient,   // and the gradient
  kExactRows,  // and rows by sensitivities, whatever the method; of a new point with adjoint rows they are its rows
  kProduct,    // and a product with the Gauss-Newton matrix, made anew every time; never of a new point
  kPullBack,   // likewise one with the transposed Jacobian
  kCostAlone,  // as kCost, of a point that nothing else will be asked of: its rollout is not kept
};

// What is asked: the derivatives for the blocks `active` at least.
struct EvaluationKey {
  Eigen::VectorXd coordinates;  // [p + n + f]
  Precision precision = Precision::kFull;
  EvaluationNeed need = EvaluationNeed::kCost;
  std::vector<int> active;  // increasing; of exact rows blocks alone
  // Of exact rows: of the unknowns [(n + f) x c], more columns behind those of `active`. Of a product: the direction
  // [(p + n + f) x 1]. Of a pull-back: a change of the residual [m x 1].
  Eigen::MatrixXd combinations = {};
};

// Whether it is a product, of which nothing is known beforehand, and that adds nothing else to an evaluation.
inline bool IsProduct(EvaluationNeed need) {
  return need == EvaluationNeed::kProduct || need == EvaluationNeed::kPullBack;
}

// Tells matrices of combinations apart, by their bytes; empty where they have no columns.
std::string DigestOf(const Eigen::MatrixXd& combinations);

// A few rows that stand for the whole residual, without the row of the loss. Whatever the method and the basis:
//   |residuals| = |w e|,  jacobian^T residuals = dL/dq,  w: the weights of the loss (costs/prediction/robust_loss.h).
struct ResidualRows {
  std::vector<int> active;    // the coordinates that were differentiated, increasing
  std::string along;          // DigestOf the combinations whose columns follow those of `active`
  Eigen::VectorXd residuals;  // [r]
  Eigen::MatrixXd jacobian;   // [r x (q + c)]
  // [(q + c) x T] J_i^T e_i over the rows of frame i, weighted by the loss: their sum is the gradient. Of forward
  // sweeps alone.
  Eigen::MatrixXd frame_scores;

  bool Covers(const std::vector<int>& wanted) const {
    return std::includes(active.begin(), active.end(), wanted.begin(), wanted.end());
  }
};

struct RolloutEvaluation {
  Eigen::VectorXd coordinates;
  Precision precision = Precision::kFull;
  std::string failure;        // not empty: nothing else is valid
  Eigen::MatrixXd predicted;  // [R x T] m, see Observation; empty: nothing is known yet
  Eigen::MatrixXd forces;     // [3G x F] N, likewise; of a recording that has none, empty
  Eigen::VectorXd residuals;  // [m] e of the prediction; empty where others were asked for since
  RolloutCounts counts;       // of the rollout
  double cost = 0.0;          // L
  double loss_row = 0.0;      // sqrt(2 L - |w e|^2), see costs/prediction/robust_loss.h
  bool has_rows = false;
  ResidualRows rows;
  bool has_gradient = false;
  Eigen::VectorXd gradient;  // [p + n + f] dL/dq
  bool has_exact_rows = false;
  ResidualRows exact_rows;  // of the sensitivities, whatever the method of `rows`
  Eigen::VectorXd product;  // [p + n + f] the latest, of either kind

  bool ok() const { return failure.empty(); }
  bool is_new() const { return predicted.size() == 0; }

  // Whether anything is missing that `key` asks for.
  bool Lacks(const EvaluationKey& key) const;
};

// What became of a question: an evaluation, and what it left behind for those that follow.
struct EvaluationOutcome {
  // `predicted` is empty where it was known before, the evaluation failed, or a journal had no room for it.
  RolloutEvaluation evaluation;
  CostStatistics statistics;            // what it added
  Eigen::VectorXd rollout_coordinates;  // whose rollout was kept afterwards; empty: none
  // J [m x q] where the evaluation took the first one, which those that follow need, and a journal had room for it.
  Eigen::MatrixXd first_jacobian;
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_ROWS_ROLLOUT_EVALUATION_H_
