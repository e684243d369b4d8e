#include "costs/rows/rollout_computation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>
#include <stdexcept>
#include <utility>

#include "costs/rows/evaluated_residuals.h"
#include "costs/rows/numeric_rows.h"
#include "sim/base/phase_seconds.h"

namespace clothid {
namespace {

// With fields, products run along a rollout again and again: bytes for its steps, and as many for their factors.
constexpr RolloutStorage kFieldStorage = {std::size_t{512} << 20, /*keep_factors=*/true};

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
      model_(motion, std::move(blocks), options.on_step, nullptr, options.fields),
      adjoint_rows_(&model_, &options_),
      curvature_(&model_, &options_) {
  model_.SetNumThreads(options.num_threads);
  model_.Assimilate(options.assimilation, options.loss);
  for (int i = 0; i < model_.num_blocks(); ++i) {
    if (!model_.blocks()[i].frozen) free_blocks_.push_back(i);
  }
  free_coordinates_ = free_blocks_;
  for (int i = model_.num_blocks(); i < model_.num_coordinates(); ++i) free_coordinates_.push_back(i);
}

void RolloutComputation::Assimilate(const Assimilation& assimilation) {
  options_.assimilation = assimilation;
  model_.Assimilate(assimilation, options_.loss);
}

int RolloutComputation::num_rows() const {
  return options_.jacobian == JacobianMethod::kAdjoint ? adjoint_rows_.num_rows() : model_.num_coordinates() + 1;
}

bool RolloutComputation::TakesFirstJacobian(const EvaluationKey& key) const {
  return key.need == EvaluationNeed::kRows && options_.jacobian == JacobianMethod::kAdjoint &&
         options_.starts_with_sensitivities && options_.fields.empty() && adjoint_rows_.last_jacobian().size() == 0 &&
         !free_blocks_.empty();
}

bool RolloutComputation::StartsWithForwardSweep(const EvaluationKey& key) const {
  if (key.need == EvaluationNeed::kCostAlone) return false;
  if (!options_.fields.empty()) return false;  // sweeps run along the kept rollout
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
  return key.need == EvaluationNeed::kGradient && model_.num_unknowns() > 0;
}

int RolloutComputation::PassesAfterRollout(const EvaluationKey& key) const {
  if (key.need == EvaluationNeed::kCost || key.need == EvaluationNeed::kCostAlone) return 0;
  if (TakesAdjointGradient(key)) return 1;
  const bool is_numeric = options_.jacobian == JacobianMethod::kNumeric && key.need != EvaluationNeed::kExactRows;
  return is_numeric ? static_cast<int>(key.active.size()) : 1;
}

void RolloutComputation::Complete(const EvaluationKey& key, const EvaluationCache& recent,
                                  RolloutEvaluation* evaluation, CostStatistics* statistics) {
  try {
    if (!key.coordinates.allFinite()) throw std::runtime_error("a parameter is not finite");
    latest_.DropUnless(key.precision);
    Add(key, recent, evaluation, statistics);
    if (!std::isfinite(evaluation->cost)) throw std::runtime_error("the cost is not finite");
  } catch (const std::runtime_error& error) {
    evaluation->failure = model_.name() + ": " + error.what();
  }
}

Rollout RolloutComputation::Simulate(const Eigen::VectorXd& coordinates, Precision precision, int passes_left,
                                     Eigen::MatrixXd* predicted, Eigen::MatrixXd* velocities, ForceTrack* forces,
                                     CostStatistics* statistics) {
  const ScopedTimer timer(&statistics->rollout_seconds);
  ++statistics->rollouts;
  const RolloutStorage storage =
      options_.fields.empty() ? RolloutStorage{options_.memory_limit, /*keep_factors=*/false} : kFieldStorage;
  Rollout rollout =
      model_.Simulate(coordinates, {precision, options_.cancel, passes_left}, storage, predicted, velocities, forces);
  statistics->counts += rollout.counts;
  if (!rollout.ok()) throw std::runtime_error(rollout.failure->ToString());
  return rollout;
}

const LatestRollout& RolloutComputation::RolloutOf(const RolloutEvaluation& evaluation, int passes_left,
                                                   CostStatistics* statistics) {
  latest_.DropUnless(evaluation.precision);
  const bool is_known = latest_.IsAt(evaluation.coordinates);
  if (is_known && !latest_.is_pending) return latest_;
  latest_.Drop();
  CostStatistics counted_before;
  latest_.rollout = Simulate(evaluation.coordinates, evaluation.precision, passes_left, &latest_.predicted,
                             &latest_.velocities, &latest_.forces, is_known ? &counted_before : statistics);
  latest_.coordinates = evaluation.coordinates;
  return latest_;
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
  if (!evaluation->Lacks(key)) return;
  switch (key.need) {
    case EvaluationNeed::kCost:
    case EvaluationNeed::kCostAlone:
      return;
    case EvaluationNeed::kRows:
      return AddRows(key, recent, evaluation, statistics);
    case EvaluationNeed::kGradient:
      return AddGradient(key, recent, evaluation, statistics);
    case EvaluationNeed::kExactRows:
      return AddExactRows(key, evaluation, statistics);
    case EvaluationNeed::kProduct:
      evaluation->product = curvature_.At(*evaluation, key.active, key.combinations.col(0),
                                          RolloutOf(*evaluation, CurvatureProduct::kPasses, statistics), statistics);
      return;
    case EvaluationNeed::kPullBack:
      evaluation->product =
          curvature_.KeepsBlockRows(key.active.size())
              ? curvature_.PullBackByBlockRows(*evaluation, key.active, key.combinations.col(0), statistics)
              : curvature_.PullBack(*evaluation, key.active, key.combinations.col(0),
                                    RolloutOf(*evaluation, /*passes_left=*/1, statistics), statistics);
  }
}

void RolloutComputation::AddCost(const EvaluationKey& key, RolloutEvaluation* evaluation, CostStatistics* statistics) {
  const LatestRollout& latest = RolloutOf(*evaluation, PassesAfterRollout(key), statistics);
  evaluation->counts = latest.rollout.counts;
  evaluation->predicted = latest.predicted;
  evaluation->forces = latest.forces.predicted;
  if (key.need == EvaluationNeed::kCostAlone) latest_.Drop();
  SetCost(options_.loss, model_.observation(), evaluation);
}

void RolloutComputation::AddForwardRows(const EvaluationKey& key, RolloutEvaluation* evaluation,
                                        CostStatistics* statistics) {
  const bool is_first = TakesFirstJacobian(key), keeps = KeepsBlockRows(key);
  const bool takes_all = is_first || key.need == EvaluationNeed::kCost;
  const SweepColumns columns = takes_all ? SweepColumns{free_blocks_, {}} : ColumnsOf(key);
  const auto num_columns = static_cast<int>(columns.blocks.size() + columns.combinations.cols());
  ForwardRows forward =
      Sweep(*evaluation, columns, std::max(num_rows(), num_columns + 1), is_first || keeps, statistics);
  if (evaluation->is_new()) {
    evaluation->predicted = std::move(forward.predicted);
    evaluation->forces = std::move(forward.forces);
    evaluation->counts = forward.counts;
    SetCost(options_.loss, model_.observation(), evaluation);
  }
  evaluation->exact_rows = forward.rows;
  evaluation->has_exact_rows = true;
  if (key.need != EvaluationNeed::kExactRows || num_columns == static_cast<int>(key.active.size())) {
    evaluation->rows = std::move(forward.rows);
    evaluation->rows.active = takes_all ? free_blocks_ : key.active;
    evaluation->rows.along.clear();
    evaluation->has_rows = true;
  }
  if (is_first) adjoint_rows_.SetLastJacobian(std::move(forward.jacobian));
  if (keeps) curvature_.KeepBlockRows(*evaluation, std::move(forward.jacobian));
}

void RolloutComputation::AddRows(const EvaluationKey& key, const EvaluationCache& recent, RolloutEvaluation* evaluation,
                                 CostStatistics* statistics) {
  switch (options_.jacobian) {
    case JacobianMethod::kAdjoint:
      if (TakesFirstJacobian(key)) return AddForwardRows(key, evaluation, statistics);
      evaluation->rows = adjoint_rows_.At(*evaluation, key.active, recent,
                                          RolloutOf(*evaluation, /*passes_left=*/1, statistics), statistics);
      break;
    case JacobianMethod::kSensitivity:
      return AddForwardRows(key, evaluation, statistics);
    case JacobianMethod::kNumeric: {
      const auto run = [&](const Eigen::VectorXd& coordinates, int passes_left, Eigen::MatrixXd* predicted,
                           ForceTrack* forces) {
        Simulate(coordinates, evaluation->precision, passes_left, predicted, /*velocities=*/nullptr, forces,
                 statistics);
      };
      evaluation->rows = NumericRows(*evaluation, key.active, num_rows(), options_, model_, run);
      break;
    }
  }
  evaluation->has_rows = true;
}

void RolloutComputation::AddGradient(const EvaluationKey& key, const EvaluationCache& recent,
                                     RolloutEvaluation* evaluation, CostStatistics* statistics) {
  Eigen::VectorXd gradient;
  if (options_.jacobian == JacobianMethod::kAdjoint || model_.num_unknowns() > 0) {
    gradient = adjoint_rows_.GradientAt(*evaluation, key.active, RolloutOf(*evaluation, /*passes_left=*/1, statistics),
                                        statistics);
  } else {
    if (!evaluation->has_rows || !evaluation->rows.Covers(key.active)) AddRows(key, recent, evaluation, statistics);
    gradient = GradientOf(evaluation->rows, key.active);
  }
  evaluation->gradient = Eigen::VectorXd::Zero(model_.num_coordinates());
  evaluation->gradient(key.active) = gradient;
  evaluation->has_gradient = true;
}

void RolloutComputation::AddExactRows(const EvaluationKey& key, RolloutEvaluation* evaluation,
                                      CostStatistics* statistics) {
  if (options_.jacobian == JacobianMethod::kSensitivity) return AddForwardRows(key, evaluation, statistics);
  const SweepColumns columns = ColumnsOf(key);
  const auto num_columns = static_cast<int>(columns.blocks.size() + columns.combinations.cols());
  const bool keeps = KeepsBlockRows(key);
  ForwardRows forward = Sweep(*evaluation, columns, num_columns + 1, keeps, statistics);
  evaluation->exact_rows = std::move(forward.rows);
  evaluation->has_exact_rows = true;
  if (keeps) curvature_.KeepBlockRows(*evaluation, std::move(forward.jacobian));
}

bool RolloutComputation::KeepsBlockRows(const EvaluationKey& key) const {
  return key.need == EvaluationNeed::kExactRows && key.active == free_blocks_ &&
         curvature_.KeepsBlockRows(free_blocks_.size());
}

SweepColumns RolloutComputation::ColumnsOf(const EvaluationKey& key) const {
  if (key.need == EvaluationNeed::kExactRows) return {key.active, key.combinations};
  const auto first_unknown = std::lower_bound(key.active.begin(), key.active.end(), model_.num_blocks());
  SweepColumns columns{{key.active.begin(), first_unknown}, {}};
  columns.combinations = Eigen::MatrixXd::Zero(model_.num_unknowns(), key.active.end() - first_unknown);
  for (Eigen::Index i = 0; i < columns.combinations.cols(); ++i) {
    columns.combinations(first_unknown[i] - model_.num_blocks(), i) = 1.0;
  }
  return columns;
}

ForwardRows RolloutComputation::Sweep(const RolloutEvaluation& evaluation, const SweepColumns& columns, int num_rows,
                                      bool keeps_jacobian, CostStatistics* statistics) {
  const Rollout* const rollout =
      options_.fields.empty() ? nullptr : &RolloutOf(evaluation, /*passes_left=*/1, statistics).rollout;
  return SweepForward(evaluation.coordinates, columns, LastPass(evaluation.precision), options_.loss, num_rows,
                      keeps_jacobian, &model_, statistics, rollout);
}

void RolloutComputation::Resume(const EvaluationKey& key, EvaluationOutcome outcome, bool took_first_jacobian,
                                const EvaluationCache& recent, const RolloutEvaluation& evaluation) {
  if (took_first_jacobian) {
    if (outcome.first_jacobian.size() > 0) adjoint_rows_.SetLastJacobian(std::move(outcome.first_jacobian));
  } else if (key.need == EvaluationNeed::kRows && options_.jacobian == JacobianMethod::kAdjoint && evaluation.ok()) {
    adjoint_rows_.Resume(evaluation, recent);
  }
  const bool has_block_rows = key.need == EvaluationNeed::kProduct || (KeepsBlockRows(key) && evaluation.ok()) ||
                              (key.need == EvaluationNeed::kPullBack && curvature_.KeepsBlockRows(key.active.size()));
  if (has_block_rows) curvature_.Resume(key.coordinates, key.precision);
  latest_.Resume(outcome.rollout_coordinates, key.precision);
}

}  // namespace clothid
