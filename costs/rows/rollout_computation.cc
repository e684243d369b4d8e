#include "costs/rows/rollout_computation.h"

#include <cmath>
#include <exception>
#include <stdexcept>
#include <utility>

#include "costs/rows/evaluated_residuals.h"
#include "costs/rows/forward_rows.h"
#include "costs/rows/numeric_rows.h"

namespace clothid {
namespace {

// J^T r of rows that cover `active`.
Eigen::VectorXd GradientOf(const ResidualRows& rows, const std::vector<int>& active) {
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(active.size()));
  for (std::size_t i = 0; i < active.size(); ++i) {
    const auto column = std::lower_bound(rows.active.begin(), rows.active.end(), active[i]) - rows.active.begin();
    gradient[static_cast<Eigen::Index>(i)] = rows.jacobian.col(column).dot(rows.residuals);
  }
  if (!gradient.allFinite()) throw std::runtime_error("the gradient is not finite");
  return gradient;
}

}  // namespace

RolloutComputation::RolloutComputation(const RecordedMotion& motion, std::vector<ParameterBlock> blocks,
                                       const RolloutCostOptions& options)
    : options_(options),
      model_(motion, std::move(blocks), options.on_step),
      latest_rollout_(&model_, &options_),
      adjoint_rows_(&model_, &options_) {
  model_.SetNumThreads(options.num_threads);
  for (int i = 0; i < model_.num_blocks(); ++i) {
    if (!model_.blocks()[i].frozen) free_blocks_.push_back(i);
  }
  free_coordinates_ = free_blocks_;
  for (int i = model_.num_blocks(); i < model_.num_coordinates(); ++i) free_coordinates_.push_back(i);
}

int RolloutComputation::num_rows() const {
  return options_.jacobian == JacobianMethod::kAdjoint ? adjoint_rows_.num_rows() : model_.num_coordinates() + 1;
}

bool RolloutComputation::TakesFirstJacobian(const EvaluationKey& key) const {
  return key.need == EvaluationNeed::kRows && options_.jacobian == JacobianMethod::kAdjoint &&
         options_.starts_with_sensitivities && adjoint_rows_.last_jacobian().size() == 0 && !free_blocks_.empty();
}

bool RolloutComputation::StartsWithForwardSweep(const EvaluationKey& key) const {
  switch (options_.jacobian) {
    case JacobianMethod::kAdjoint:
      // With the columns of an unknown start the sweep is not as exact as the rollout.
      return TakesFirstJacobian(key) ||
             (key.need == EvaluationNeed::kExactRows && model_.num_start_unknowns() == 0 && !free_blocks_.empty());
    case JacobianMethod::kSensitivity:
      // Nearly every trial point is accepted and asked for its Jacobian next.
      return !TakesAdjointGradient(key);
    case JacobianMethod::kNumeric:
      break;
  }
  return false;
}

bool RolloutComputation::TakesAdjointGradient(const EvaluationKey& key) const {
  return key.need == EvaluationNeed::kGradient && model_.num_start_unknowns() > 0;
}

int RolloutComputation::PassesAfterRollout(const EvaluationKey& key) const {
  if (key.need == EvaluationNeed::kCost) return 0;
  if (TakesAdjointGradient(key)) return 1;
  const bool is_numeric = options_.jacobian == JacobianMethod::kNumeric && key.need != EvaluationNeed::kExactRows;
  return is_numeric ? static_cast<int>(key.active.size()) : 1;
}

void RolloutComputation::Complete(const EvaluationKey& key, const EvaluationCache& recent,
                                  RolloutEvaluation* evaluation, CostStatistics* statistics) {
  try {
    if (!key.coordinates.allFinite()) throw std::runtime_error("a parameter is not finite");
    latest_rollout_.DropUnless(key.precision);
    Add(key, recent, evaluation, statistics);
    if (!std::isfinite(evaluation->cost)) throw std::runtime_error("the cost is not finite");
  } catch (const std::runtime_error& error) {
    evaluation->failure = model_.name() + ": " + error.what();
  }
}

void RolloutComputation::AddPrediction(const EvaluationKey& key, RolloutEvaluation* evaluation,
                                       CostStatistics* statistics) {
  if (StartsWithForwardSweep(key)) return AddForwardRows(key, evaluation, statistics);
  AddCost(key, evaluation, statistics);
}

Eigen::MatrixXd RolloutComputation::PredictAgain(const EvaluationKey& key) {
  RolloutEvaluation evaluation;
  evaluation.coordinates = key.coordinates;
  evaluation.precision = key.precision;
  CostStatistics counted_before;
  AddPrediction(key, &evaluation, &counted_before);
  return std::move(evaluation.predicted);
}

void RolloutComputation::Add(const EvaluationKey& key, const EvaluationCache& recent, RolloutEvaluation* evaluation,
                             CostStatistics* statistics) {
  if (evaluation->is_new()) AddPrediction(key, evaluation, statistics);
  if (!evaluation->Lacks(key.need, key.active)) return;
  switch (key.need) {
    case EvaluationNeed::kCost:
      return;
    case EvaluationNeed::kRows:
      return AddRows(key, recent, evaluation, statistics);
    case EvaluationNeed::kGradient:
      return AddGradient(key, recent, evaluation, statistics);
    case EvaluationNeed::kExactRows:
      return AddExactRows(key, evaluation, statistics);
  }
}

void RolloutComputation::AddCost(const EvaluationKey& key, RolloutEvaluation* evaluation, CostStatistics* statistics) {
  evaluation->counts =
      latest_rollout_.At(evaluation->coordinates, evaluation->precision, PassesAfterRollout(key), statistics).counts;
  evaluation->predicted = latest_rollout_.predicted();
  evaluation->forces = latest_rollout_.forces().predicted;
  SetCost(options_.loss, model_.observation(), evaluation);
}

void RolloutComputation::AddForwardRows(const EvaluationKey& key, RolloutEvaluation* evaluation,
                                        CostStatistics* statistics) {
  const bool is_first = TakesFirstJacobian(key);
  const bool takes_all = is_first || key.need == EvaluationNeed::kCost;
  ForwardRows forward =
      SweepForward(evaluation->coordinates, takes_all ? free_blocks_ : key.active, LastPass(evaluation->precision),
                   options_.loss, num_rows(), /*keeps_jacobian=*/is_first, &model_, statistics);
  if (evaluation->is_new()) {
    evaluation->predicted = std::move(forward.predicted);
    evaluation->forces = std::move(forward.forces);
    evaluation->counts = forward.counts;
    SetCost(options_.loss, model_.observation(), evaluation);
  }
  evaluation->rows = std::move(forward.rows);
  evaluation->has_rows = true;
  evaluation->exact_rows = evaluation->rows;
  evaluation->has_exact_rows = true;
  if (is_first) adjoint_rows_.SetLastJacobian(std::move(forward.jacobian));
}

void RolloutComputation::AddRows(const EvaluationKey& key, const EvaluationCache& recent, RolloutEvaluation* evaluation,
                                 CostStatistics* statistics) {
  switch (options_.jacobian) {
    case JacobianMethod::kAdjoint:
      if (TakesFirstJacobian(key)) return AddForwardRows(key, evaluation, statistics);
      evaluation->rows = adjoint_rows_.At(*evaluation, key.active, recent, &latest_rollout_, statistics);
      break;
    case JacobianMethod::kSensitivity:
      return AddForwardRows(key, evaluation, statistics);
    case JacobianMethod::kNumeric:
      evaluation->rows =
          NumericRows(*evaluation, key.active, num_rows(), options_, model_, latest_rollout_, statistics);
      break;
  }
  evaluation->has_rows = true;
}

void RolloutComputation::AddGradient(const EvaluationKey& key, const EvaluationCache& recent,
                                     RolloutEvaluation* evaluation, CostStatistics* statistics) {
  Eigen::VectorXd gradient;
  if (options_.jacobian == JacobianMethod::kAdjoint || model_.num_start_unknowns() > 0) {
    gradient = adjoint_rows_.GradientAt(*evaluation, key.active, &latest_rollout_, statistics);
  } else {
    if (evaluation->Lacks(EvaluationNeed::kRows, key.active)) AddRows(key, recent, evaluation, statistics);
    gradient = GradientOf(evaluation->rows, key.active);
  }
  evaluation->gradient = Eigen::VectorXd::Zero(model_.num_coordinates());
  evaluation->gradient(key.active) = gradient;
  evaluation->has_gradient = true;
}

void RolloutComputation::AddExactRows(const EvaluationKey& key, RolloutEvaluation* evaluation,
                                      CostStatistics* statistics) {
  if (options_.jacobian == JacobianMethod::kSensitivity) return AddForwardRows(key, evaluation, statistics);
  const int num_exact_rows = static_cast<int>(key.active.size()) + 1;
  evaluation->exact_rows =
      SweepForward(evaluation->coordinates, key.active, LastPass(evaluation->precision), options_.loss, num_exact_rows,
                   /*keeps_jacobian=*/false, &model_, statistics)
          .rows;
  evaluation->has_exact_rows = true;
}

ResidualRows RolloutComputation::RowsAlong(const Eigen::VectorXd& coordinates, Precision precision,
                                           const Eigen::MatrixXd& follow, CostStatistics* statistics) {
  const Eigen::MatrixXd own = follow(Eigen::all, free_blocks_);
  return SweepForward(coordinates, free_blocks_, LastPass(precision), options_.loss,
                      static_cast<int>(free_blocks_.size()) + 1, /*keeps_jacobian=*/false, &model_, statistics, &own)
      .rows;
}

void RolloutComputation::Resume(const EvaluationKey& key, EvaluationOutcome outcome, bool took_first_jacobian,
                                const EvaluationCache& recent, const RolloutEvaluation& evaluation) {
  if (took_first_jacobian) {
    if (outcome.first_jacobian.size() > 0) adjoint_rows_.SetLastJacobian(std::move(outcome.first_jacobian));
  } else if (key.need == EvaluationNeed::kRows && options_.jacobian == JacobianMethod::kAdjoint && evaluation.ok()) {
    adjoint_rows_.Resume(evaluation, recent);
  }
  latest_rollout_.Resume(outcome.rollout_coordinates, key.precision);
}

}  // namespace clothid
