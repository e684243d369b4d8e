// The latest evaluations of one recording, by coordinates and precision.
#ifndef CLOTHID_COSTS_ROWS_EVALUATION_CACHE_H_
#define CLOTHID_COSTS_ROWS_EVALUATION_CACHE_H_

#include <Eigen/Core>
#include <deque>

#include "costs/prediction/rollout_cost_options.h"
#include "costs/rows/rollout_evaluation.h"

namespace clothid {

class EvaluationCache {
 public:
  explicit EvaluationCache(int capacity) : capacity_(capacity) {}  // >= 1

  // Null where the point is not known. Coordinates are compared number by number: a point next to it is another one.
  RolloutEvaluation* Find(const Eigen::VectorXd& coordinates, Precision precision);
  // A new evaluation, of which nothing is known. The oldest goes where there are too many, and of the others the
  // residuals, which their predictions give again. Pointers to others are void.
  RolloutEvaluation* Add(const Eigen::VectorXd& coordinates, Precision precision);
  // Pointers to others are void.
  void Remove(const RolloutEvaluation* evaluation);
  void Clear() { evaluations_.clear(); }
  // All but those of a point.
  void KeepOnly(const Eigen::VectorXd& coordinates);

  // The latest first.
  const std::deque<RolloutEvaluation>& evaluations() const { return evaluations_; }
  std::deque<RolloutEvaluation>* mutable_evaluations() { return &evaluations_; }

 private:
  int capacity_;
  std::deque<RolloutEvaluation> evaluations_;
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_ROWS_EVALUATION_CACHE_H_
