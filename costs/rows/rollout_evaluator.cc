#include "costs/rows/rollout_evaluator.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "costs/prediction/prediction_cost.h"
#include "costs/rows/evaluation_journal.h"
#include "costs/rows/residual_basis.h"
#include "sim/base/phase_seconds.h"

namespace clothid {
namespace {

// Differences that enter the subspace beside the last Jacobian, which holds the older ones.
constexpr int kFreshDifferences = 2;
// Forward differences do not step below this, in an internal coordinate of order one.
constexpr double kLeastDifferenceStep = 1e-6;

double LossRow(double cost, double weighted_squared_norm) {
  return std::sqrt(std::max(0.0, 2.0 * cost - weighted_squared_norm));
}

bool Covers(const std::vector<int>& have, const std::vector<int>& wanted) {
  return std::includes(have.begin(), have.end(), wanted.begin(), wanted.end());
}

}  // namespace

CostStatistics& CostStatistics::operator+=(const CostStatistics& other) {
  rollouts += other.rollouts;
  sweeps += other.sweeps;
  counts += other.counts;
  rollout_seconds += other.rollout_seconds;
  derivative_seconds += other.derivative_seconds;
  return *this;
}

CostStatistics& CostStatistics::operator-=(const CostStatistics& other) {
  rollouts -= other.rollouts;
  sweeps -= other.sweeps;
  counts -= other.counts;
  rollout_seconds -= other.rollout_seconds;
  derivative_seconds -= other.derivative_seconds;
  return *this;
}

double ForwardDifferenceStep(const SolverOptions& solver) {
  return std::max(kLeastDifferenceStep, std::sqrt(solver.step_tolerance));
}

RolloutEvaluator::RolloutEvaluator(const RecordedMotion& motion, std::vector<ParameterBlock> blocks,
                                   const RolloutCostOptions& options)
    : options_(options), model_(motion, std::move(blocks)) {
  for (int i = 0; i < model_.num_blocks(); ++i) {
    if (!model_.blocks()[i].frozen) free_blocks_.push_back(i);
  }
  if (!options_.on_step) return;
  model_.SetObserver([this](PassStep step) {
    step.passes_left = passes_left_;
    options_.on_step(step);
  });
}

int RolloutEvaluator::num_rows() const {
  if (options_.jacobian != JacobianMethod::kAdjoint) return model_.num_blocks() + 1;
  return 1 + options_.num_differences + std::max(kNumDisplacementModes, model_.num_blocks());
}

void RolloutEvaluator::SetPrecision(Precision precision) {
  if (precision == precision_) return;
  precision_ = precision;
  model_.SetPrecision(precision);
  rollout_coordinates_.resize(0);
}

Rollout RolloutEvaluator::Run(const Eigen::VectorXd& coordinates, Eigen::MatrixXd* predicted,
                              Eigen::MatrixXd* velocities) {
  const ScopedTimer timer(&statistics_.rollout_seconds);
  ++statistics_.rollouts;
  Rollout result = model_.Simulate(coordinates, options_.cancel, options_.memory_limit, options_.keep_factors,
                                   predicted, velocities);
  statistics_.counts += result.counts;
  if (!result.ok()) throw std::runtime_error(result.failure->ToString());
  return result;
}

const Rollout& RolloutEvaluator::RolloutAt(const Eigen::VectorXd& coordinates) {
  if (rollout_coordinates_.size() == 0 || rollout_coordinates_ != coordinates) {
    rollout_coordinates_.resize(0);
    rollout_ = Rollout();  // so that there are never two
    rollout_ = Run(coordinates, &rollout_predicted_, &rollout_velocities_);
    rollout_coordinates_ = coordinates;
    rollout_was_replayed_ = false;
  } else if (rollout_was_replayed_) {
    // Its journal has counted it already.
    rollout_ = model_.Simulate(coordinates, options_.cancel, options_.memory_limit, options_.keep_factors,
                               &rollout_predicted_, &rollout_velocities_);
    if (!rollout_.ok()) throw std::runtime_error(rollout_.failure->ToString());
    rollout_was_replayed_ = false;
  }
  return rollout_;
}

Eigen::VectorXd RolloutEvaluator::WeightedResiduals(const RolloutEvaluation& evaluation,
                                                    Eigen::VectorXd* weights) const {
  LossWeights(options_.loss, model_.observation(), 0, evaluation.residuals, weights);
  return weights->cwiseProduct(evaluation.residuals);
}

void RolloutEvaluator::ComputeCost(RolloutEvaluation* evaluation) {
  evaluation->counts = RolloutAt(evaluation->coordinates).counts;
  evaluation->predicted = rollout_predicted_;
  PredictionCost cost = CostOfPrediction(options_.loss, model_.observation(), evaluation->predicted);
  evaluation->cost = cost.value;
  evaluation->loss_row = LossRow(cost.value, cost.WeightedResiduals().squaredNorm());
  evaluation->residuals = std::move(cost.residuals);
}

// Nothing of the size [m x p] is stored unless it is asked for.
CompressedJacobian RolloutEvaluator::SweepForward(const std::vector<int>& active, RolloutEvaluation* evaluation,
                                                  Eigen::MatrixXd* full_jacobian, Eigen::MatrixXd* frame_scores) {
  const ScopedTimer timer(&statistics_.derivative_seconds);
  const Observation& observation = model_.observation();
  CompressedJacobian compressed(static_cast<int>(active.size()));
  evaluation->predicted.resize(observation.num_predicted(), observation.num_frames());
  evaluation->residuals.resize(observation.num_residuals());
  evaluation->cost = 0.0;
  frame_scores->setZero(static_cast<Eigen::Index>(active.size()), observation.num_frames());
  if (full_jacobian != nullptr) {
    full_jacobian->resize(observation.num_residuals(), static_cast<Eigen::Index>(active.size()));
  }
  double weighted_squared_norm = 0.0;
  const auto add_frame = [&](int frame, const Eigen::VectorXd& points, const Eigen::VectorXd& residuals,
                             const Eigen::MatrixXd& jacobian) {
    evaluation->predicted.col(frame) = points;
    evaluation->residuals.segment(observation.first_row(frame), residuals.size()) = residuals;
    Eigen::VectorXd weights;
    evaluation->cost += LossWeights(options_.loss, observation, observation.first_row(frame), residuals, &weights);
    const Eigen::VectorXd weighted = residuals.cwiseProduct(weights);
    weighted_squared_norm += weighted.squaredNorm();
    compressed.Add(weights.asDiagonal() * jacobian, weighted);
    frame_scores->col(frame) = jacobian.transpose() * weights.cwiseProduct(weighted);
    if (full_jacobian != nullptr) full_jacobian->middleRows(observation.first_row(frame), jacobian.rows()) = jacobian;
  };
  ++statistics_.rollouts;
  ++statistics_.sweeps;
  passes_left_ = 0;
  const SensitivityResult result = model_.PushForward(evaluation->coordinates, active, add_frame, options_.cancel);
  statistics_.counts += result.counts;
  evaluation->counts = result.counts;
  if (result.failure) throw std::runtime_error(result.failure->ToString());
  evaluation->loss_row = LossRow(evaluation->cost, weighted_squared_norm);
  return compressed;
}

ResidualRows RolloutEvaluator::CompressedRows(const std::vector<int>& active, int num_rows,
                                              CompressedJacobian* compressed) {
  const Eigen::MatrixXd& factor = compressed->Factor();
  const Eigen::Index num_active = static_cast<Eigen::Index>(active.size());
  ResidualRows rows;
  rows.active = active;
  rows.residuals = Eigen::VectorXd::Zero(num_rows);
  rows.jacobian = Eigen::MatrixXd::Zero(num_rows, num_active);
  rows.residuals.head(num_active + 1) = factor.col(num_active);
  rows.jacobian.topRows(num_active + 1) = factor.leftCols(num_active);
  if (!rows.jacobian.allFinite()) throw std::runtime_error("the Jacobian is not finite");
  return rows;
}

void RolloutEvaluator::ComputeWithSensitivities(const std::vector<int>& active, RolloutEvaluation* evaluation) {
  Eigen::MatrixXd jacobian;
  const bool is_first = TakesFirstJacobian();
  Eigen::MatrixXd frame_scores;
  CompressedJacobian compressed = SweepForward(active, evaluation, is_first ? &jacobian : nullptr, &frame_scores);
  evaluation->rows = CompressedRows(active, num_rows(), &compressed);
  evaluation->rows.frame_scores = std::move(frame_scores);
  evaluation->has_rows = true;
  if (is_first) last_jacobian_ = std::move(jacobian);
}

void RolloutEvaluator::ComputeExactRows(const std::vector<int>& active, RolloutEvaluation* evaluation) {
  if (options_.jacobian == JacobianMethod::kSensitivity) {
    evaluation->exact_rows = evaluation->rows;
  } else {
    // The evaluation keeps the cost that it was given before, which differs in rounding.
    RolloutEvaluation sweep;
    sweep.coordinates = evaluation->coordinates;
    Eigen::MatrixXd frame_scores;
    CompressedJacobian compressed = SweepForward(active, &sweep, /*full_jacobian=*/nullptr, &frame_scores);
    evaluation->exact_rows = CompressedRows(active, static_cast<int>(active.size()) + 1, &compressed);
    evaluation->exact_rows.frame_scores = std::move(frame_scores);
  }
  evaluation->has_exact_rows = true;
}

// Distances of clouds are not linear in the prediction.
Eigen::VectorXd RolloutEvaluator::ResidualChange(const RolloutEvaluation& from, const Eigen::MatrixXd& to) const {
  const Observation& observation = model_.observation();
  if (observation.has_clouds()) return observation.Residuals(to) - from.residuals;
  return observation.Whiten(to - from.predicted);
}

// e first, so that it is in the span to rounding whatever follows.
Eigen::MatrixXd RolloutEvaluator::BasisVectors(const RolloutEvaluation& evaluation) const {
  const Observation& observation = model_.observation();
  const bool has_jacobian = last_jacobian_.size() > 0;
  Eigen::MatrixXd modes;
  if (!has_jacobian) modes = DisplacementModes(observation, observation.LinearizeClouds(evaluation.predicted));
  const Eigen::MatrixXd& others = has_jacobian ? last_jacobian_ : modes;
  const int max_differences =
      has_jacobian ? std::min(kFreshDifferences, options_.num_differences) : options_.num_differences;
  Eigen::MatrixXd vectors = Eigen::MatrixXd::Zero(observation.num_residuals(), 1 + max_differences + others.cols());
  vectors.col(0) = evaluation.residuals;
  Eigen::Index column = 1;
  for (const RolloutEvaluation& other : recent_) {
    if (column > max_differences) break;
    if (other.coordinates == evaluation.coordinates || !other.ok()) continue;
    vectors.col(column++) = ResidualChange(evaluation, other.predicted);
  }
  vectors.rightCols(others.cols()) = others;
  return vectors;
}

Eigen::MatrixXd RolloutEvaluator::Basis(const RolloutEvaluation& evaluation, Eigen::VectorXd* weights) const {
  WeightedResiduals(evaluation, weights);
  Eigen::MatrixXd vectors = BasisVectors(evaluation);
  vectors.array().colwise() *= weights->array();
  return OrthonormalBasis(std::move(vectors));
}

void RolloutEvaluator::KeepJacobian(const Eigen::VectorXd& weights, const Eigen::MatrixXd& basis,
                                    const ResidualRows& rows) {
  const bool has_residual = rows.residuals[num_rows() - 1] > 0.0;
  const Eigen::Index num_directions = basis.cols() - (has_residual ? 1 : 0);
  last_jacobian_ = basis.rightCols(num_directions) * rows.jacobian.topRows(num_directions);
  if (has_residual) last_jacobian_ += basis.leftCols(1) * rows.jacobian.bottomRows(1);
  last_jacobian_ = (weights.cwiseInverse().asDiagonal() * last_jacobian_).eval();
}

bool RolloutEvaluator::TakesFirstJacobian() const {
  return options_.jacobian == JacobianMethod::kAdjoint && options_.starts_with_sensitivities &&
         last_jacobian_.size() == 0 && !free_blocks_.empty();
}

void RolloutEvaluator::ComputeAdjointRows(const std::vector<int>& active, RolloutEvaluation* evaluation) {
  const Rollout& rollout = RolloutAt(evaluation->coordinates);
  passes_left_ = 0;
  const ScopedTimer timer(&statistics_.derivative_seconds);
  Eigen::VectorXd weights;
  const Eigen::MatrixXd basis = Basis(*evaluation, &weights);
  const double norm = weights.cwiseProduct(evaluation->residuals).norm();
  ++statistics_.sweeps;
  // (B^T w J)^T = J^T w B: the seeds are the columns of w B. Where no weight differs from one they are B, which is
  // large.
  Eigen::MatrixXd weighted_basis;
  if (options_.loss.is_robust()) weighted_basis = weights.asDiagonal() * basis;
  const Eigen::MatrixXd gradients =
      model_.PullBack(rollout, evaluation->predicted, evaluation->coordinates, active,
                      options_.loss.is_robust() ? weighted_basis : basis, options_.adjoint, &rollout_velocities_);
  if (!gradients.allFinite()) throw std::runtime_error("the adjoint sweep gave a gradient that is not finite");

  // B^T e is |e| in the row of e, the first column of B, and zero in the others by construction.
  const Eigen::Index num_directions = basis.cols() - (norm > 0.0 ? 1 : 0);
  ResidualRows rows;
  rows.active = active;
  rows.residuals = Eigen::VectorXd::Zero(num_rows());
  rows.jacobian = Eigen::MatrixXd::Zero(num_rows(), static_cast<Eigen::Index>(active.size()));
  rows.residuals[num_rows() - 1] = norm;
  rows.jacobian.topRows(num_directions) = gradients.rightCols(num_directions).transpose();
  if (norm > 0.0) rows.jacobian.bottomRows(1) = gradients.leftCols(1).transpose();
  KeepJacobian(weights, basis, rows);
  evaluation->rows = std::move(rows);
  evaluation->has_rows = true;
}

void RolloutEvaluator::ComputeNumericRows(const std::vector<int>& active, RolloutEvaluation* evaluation) {
  const Observation& observation = model_.observation();
  const double step = ForwardDifferenceStep(model_.scene().solver);
  Eigen::MatrixXd jacobian(observation.num_residuals(), static_cast<Eigen::Index>(active.size()));
  for (Eigen::Index i = 0; i < jacobian.cols(); ++i) {
    Eigen::VectorXd shifted = evaluation->coordinates;
    shifted[active[i]] += step;
    passes_left_ = static_cast<int>(jacobian.cols() - 1 - i);
    Eigen::MatrixXd predicted;
    Run(shifted, &predicted);
    jacobian.col(i) = ResidualChange(*evaluation, predicted) / step;
  }
  Eigen::VectorXd weights;
  const Eigen::VectorXd weighted = WeightedResiduals(*evaluation, &weights);
  CompressedJacobian compressed(static_cast<int>(active.size()));
  compressed.Add(weights.asDiagonal() * jacobian, weighted);
  evaluation->rows = CompressedRows(active, num_rows(), &compressed);
  evaluation->has_rows = true;
}

void RolloutEvaluator::ComputeGradient(const std::vector<int>& active, RolloutEvaluation* evaluation) {
  Eigen::VectorXd gradient;
  if (options_.jacobian == JacobianMethod::kAdjoint) {
    const Rollout& rollout = RolloutAt(evaluation->coordinates);
    passes_left_ = 0;
    const ScopedTimer timer(&statistics_.derivative_seconds);
    Eigen::VectorXd weights;
    const Eigen::VectorXd weighted = WeightedResiduals(*evaluation, &weights);
    ++statistics_.sweeps;
    gradient = model_.PullBack(rollout, evaluation->predicted, evaluation->coordinates, active,
                               weights.cwiseProduct(weighted), options_.adjoint, &rollout_velocities_);
  } else {
    Complete(Need::kRows, active, evaluation);
    gradient = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(active.size()));
    for (std::size_t i = 0; i < active.size(); ++i) {
      const auto& have = evaluation->rows.active;
      const auto column = std::lower_bound(have.begin(), have.end(), active[i]) - have.begin();
      gradient[i] = evaluation->rows.jacobian.col(column).dot(evaluation->rows.residuals);
    }
  }
  if (!gradient.allFinite()) throw std::runtime_error("the adjoint sweep gave a gradient that is not finite");
  evaluation->gradient = Eigen::VectorXd::Zero(model_.num_blocks());
  for (std::size_t i = 0; i < active.size(); ++i) evaluation->gradient[active[i]] = gradient[i];
  evaluation->has_gradient = true;
}

RolloutEvaluation& RolloutEvaluator::FindOrAdd(const Eigen::VectorXd& coordinates) {
  for (RolloutEvaluation& evaluation : recent_) {
    if (evaluation.coordinates != coordinates || evaluation.precision != precision_) continue;
    if (evaluation.ok() && evaluation.predicted.size() > 0 && evaluation.residuals.size() == 0) {
      evaluation.residuals = model_.observation().Residuals(evaluation.predicted);
    }
    return evaluation;
  }
  for (RolloutEvaluation& evaluation : recent_) evaluation.residuals.resize(0);
  RolloutEvaluation evaluation;
  evaluation.coordinates = coordinates;
  evaluation.precision = precision_;
  recent_.push_front(std::move(evaluation));
  if (static_cast<int>(recent_.size()) > options_.num_differences + 1) recent_.pop_back();
  return recent_.front();
}

void RolloutEvaluator::Complete(Need need, const std::vector<int>& active, RolloutEvaluation* evaluation) {
  const bool is_new = evaluation->predicted.size() == 0;
  const bool lacks_rows = !evaluation->has_rows || !Covers(evaluation->rows.active, active);
  passes_left_ = PassesAfterRollout(need, active);
  if (is_new && TakesFirstJacobian()) {
    ComputeWithSensitivities(free_blocks_, evaluation);
    return Complete(need, active, evaluation);
  }
  if (options_.jacobian == JacobianMethod::kSensitivity) {
    // Nearly every trial point is accepted and asked for its Jacobian next, so it comes along with the rollout.
    if (is_new || (need != Need::kCost && lacks_rows)) {
      ComputeWithSensitivities(need == Need::kCost ? free_blocks_ : active, evaluation);
    }
  } else if (is_new) {
    ComputeCost(evaluation);
  }
  if (need == Need::kRows && lacks_rows && options_.jacobian == JacobianMethod::kAdjoint) {
    ComputeAdjointRows(active, evaluation);
  }
  if (need == Need::kRows && lacks_rows && options_.jacobian == JacobianMethod::kNumeric) {
    ComputeNumericRows(active, evaluation);
  }
  if (need == Need::kGradient && !evaluation->has_gradient) ComputeGradient(active, evaluation);
  if (need == Need::kExactRows && Lacks(need, active, *evaluation)) ComputeExactRows(active, evaluation);
}

int RolloutEvaluator::PassesAfterRollout(Need need, const std::vector<int>& active) const {
  if (need == Need::kCost || options_.jacobian == JacobianMethod::kSensitivity) return 0;
  const bool is_numeric = options_.jacobian == JacobianMethod::kNumeric && need != Need::kExactRows;
  return is_numeric ? static_cast<int>(active.size()) : 1;
}

bool RolloutEvaluator::Lacks(Need need, const std::vector<int>& active, const RolloutEvaluation& evaluation) const {
  if (evaluation.predicted.size() == 0) return true;
  switch (need) {
    case Need::kCost:
      return false;
    case Need::kRows:
      return !evaluation.has_rows || !Covers(evaluation.rows.active, active);
    case Need::kGradient:
      return !evaluation.has_gradient;
    case Need::kExactRows:
      return !evaluation.has_exact_rows || !Covers(evaluation.exact_rows.active, active);
  }
  return true;
}

void RolloutEvaluator::CompleteOrFail(Need need, const std::vector<int>& active, RolloutEvaluation* evaluation) {
  try {
    if (!evaluation->coordinates.allFinite()) throw std::runtime_error("a parameter is not finite");
    Complete(need, active, evaluation);
    if (!std::isfinite(evaluation->cost)) throw std::runtime_error("the cost is not finite");
  } catch (const std::runtime_error& error) {
    evaluation->failure = model_.name() + ": " + error.what();
  }
}

void RolloutEvaluator::Restore(const EvaluationOutcome& outcome, Need need, RolloutEvaluation* evaluation) {
  Eigen::MatrixXd predicted = std::move(evaluation->predicted);
  *evaluation = outcome.evaluation;
  if (evaluation->predicted.size() == 0) evaluation->predicted = std::move(predicted);
  if (evaluation->predicted.size() > 0) evaluation->residuals = model_.observation().Residuals(evaluation->predicted);
  if (outcome.first_jacobian.size() > 0) {
    last_jacobian_ = outcome.first_jacobian;
  } else if (need == Need::kRows && options_.jacobian == JacobianMethod::kAdjoint && evaluation->ok()) {
    Eigen::VectorXd weights;
    const Eigen::MatrixXd basis = Basis(*evaluation, &weights);
    KeepJacobian(weights, basis, evaluation->rows);
  }
  statistics_ += outcome.statistics;
  rollout_coordinates_ = outcome.rollout_coordinates;
  rollout_was_replayed_ = true;
}

void RolloutEvaluator::CompleteOrReplay(Need need, const std::vector<int>& active, RolloutEvaluation* evaluation) {
  EvaluationJournal* journal = options_.journal.get();
  const auto is_cancelled = [this] { return options_.cancel != nullptr && options_.cancel->load(); };
  if (journal == nullptr || is_cancelled()) return CompleteOrFail(need, active, evaluation);
  const bool was_predicted = evaluation->predicted.size() > 0;
  const EvaluationKey key{evaluation->coordinates, evaluation->precision, need, active};
  try {
    if (journal_error_) throw *journal_error_;
    if (const auto outcome = journal->Replay(key)) return Restore(*outcome, need, evaluation);
    const bool takes_first_jacobian = !was_predicted && TakesFirstJacobian();
    const CostStatistics before = std::exchange(statistics_, CostStatistics());
    CompleteOrFail(need, active, evaluation);
    EvaluationOutcome outcome{*evaluation, statistics_, rollout_coordinates_, {}};
    statistics_ = before;
    statistics_ += outcome.statistics;
    if (is_cancelled()) return;
    if (takes_first_jacobian) outcome.first_jacobian = last_jacobian_;
    if (was_predicted || !evaluation->ok()) outcome.evaluation.predicted.resize(0, 0);
    journal->Append(key, std::move(outcome));
  } catch (const Error& error) {
    journal_error_ = error;
    evaluation->failure = error.what();
  }
}

const RolloutEvaluation& RolloutEvaluator::At(const Eigen::VectorXd& coordinates, Need need,
                                              const std::vector<int>& active) {
  RolloutEvaluation& evaluation = FindOrAdd(coordinates);
  if (evaluation.ok() && Lacks(need, active, evaluation)) CompleteOrReplay(need, active, &evaluation);
  last_failure_ = evaluation.failure;
  return evaluation;
}

}  // namespace clothid
