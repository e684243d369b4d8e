#include "costs/rows/evaluation_cache.h"

#include <algorithm>
#include <utility>

namespace clothid {

RolloutEvaluation* EvaluationCache::Find(const Eigen::VectorXd& coordinates, Precision precision) {
  for (RolloutEvaluation& evaluation : evaluations_) {
    if (evaluation.coordinates == coordinates && evaluation.precision == precision) return &evaluation;
  }
  return nullptr;
}

RolloutEvaluation* EvaluationCache::Add(const Eigen::VectorXd& coordinates, Precision precision) {
  for (RolloutEvaluation& evaluation : evaluations_) evaluation.residuals.resize(0);
  RolloutEvaluation evaluation;
  evaluation.coordinates = coordinates;
  evaluation.precision = precision;
  evaluations_.push_front(std::move(evaluation));
  if (static_cast<int>(evaluations_.size()) > capacity_) evaluations_.pop_back();
  return &evaluations_.front();
}

void EvaluationCache::Remove(const RolloutEvaluation* evaluation) {
  evaluations_.erase(std::find_if(evaluations_.begin(), evaluations_.end(),
                                  [&](const RolloutEvaluation& other) { return &other == evaluation; }));
}

void EvaluationCache::KeepOnly(const Eigen::VectorXd& coordinates) {
  const auto is_other = [&](const RolloutEvaluation& evaluation) { return evaluation.coordinates != coordinates; };
  evaluations_.erase(std::remove_if(evaluations_.begin(), evaluations_.end(), is_other), evaluations_.end());
}

}  // namespace clothid
