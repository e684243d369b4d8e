#include "costs/rollout_cost.h"

#include <cmath>
#include <utility>

#include "costs/rows/reflected_rows.h"
#include "costs/rows/rollout_evaluator.h"

namespace clothid {

using Need = EvaluationNeed;

RolloutCost::RolloutCost(const RecordedMotion& motion, std::vector<ParameterBlock> blocks,
                         const RolloutCostOptions& options)
    : RolloutCost(std::make_shared<RolloutEvaluator>(motion, std::move(blocks), options), Precision::kFull) {}

RolloutCost::RolloutCost(std::shared_ptr<RolloutEvaluator> evaluator, Precision precision)
    : evaluator_(std::move(evaluator)), precision_(precision) {
  for (int i = 0; i < model().num_blocks(); ++i) mutable_parameter_block_sizes()->push_back(1);
  set_num_residuals(evaluator_->num_rows() + (evaluator_->options().loss.is_robust() ? 1 : 0));
}

RolloutCost::~RolloutCost() = default;

std::unique_ptr<RolloutCost> RolloutCost::AtPrecision(Precision precision) const {
  return std::unique_ptr<RolloutCost>(new RolloutCost(evaluator_, precision));
}

bool RolloutCost::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  Eigen::VectorXd coordinates(model().num_blocks());
  std::vector<int> active;
  for (int i = 0; i < model().num_blocks(); ++i) {
    coordinates[i] = parameters[i][0];
    if (jacobians != nullptr && jacobians[i] != nullptr) active.push_back(i);
  }
  const RolloutEvaluation& evaluation =
      evaluator_->At({coordinates, precision_, active.empty() ? Need::kCost : Need::kRows, active});
  if (!evaluation.ok()) return false;

  Eigen::Map<Eigen::VectorXd> out(residuals, num_residuals());
  out.setZero();
  out[num_residuals() - 1] = std::sqrt(2.0 * evaluation.cost);
  if (active.empty()) return true;
  const Eigen::MatrixXd rows = RowsOf(evaluation);
  for (std::size_t column = 0; column < evaluation.rows.active.size(); ++column) {
    double* const jacobian = jacobians[evaluation.rows.active[column]];
    if (jacobian == nullptr) continue;
    Eigen::Map<Eigen::VectorXd>(jacobian, num_residuals()) = rows.col(static_cast<Eigen::Index>(column));
  }
  return true;
}

Eigen::MatrixXd RolloutCost::RowsOf(const RolloutEvaluation& evaluation) const {
  const int num_rows = evaluator_->num_rows();
  Eigen::VectorXd residuals(num_residuals());
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(num_residuals(), evaluation.rows.jacobian.cols());
  residuals.head(num_rows) = evaluation.rows.residuals;
  if (num_residuals() > num_rows) residuals[num_rows] = evaluation.loss_row;
  jacobian.topRows(num_rows) = evaluation.rows.jacobian;
  return ReflectedJacobian(residuals, std::move(jacobian));
}

bool RolloutCost::EvaluateGradient(const Eigen::VectorXd& coordinates, double* cost, Eigen::VectorXd* gradient) const {
  const Need need = gradient == nullptr ? Need::kCost : Need::kGradient;
  const RolloutEvaluation& evaluation = evaluator_->At({coordinates, precision_, need, evaluator_->free_blocks()});
  if (!evaluation.ok()) return false;
  *cost = evaluation.cost;
  if (gradient != nullptr) *gradient = evaluation.gradient;
  return true;
}

bool RolloutCost::Linearize(const Eigen::VectorXd& coordinates, Eigen::MatrixXd* jacobian, Eigen::VectorXd* residuals,
                            Eigen::MatrixXd* frame_scores) const {
  const RolloutEvaluation& evaluation =
      evaluator_->At({coordinates, precision_, Need::kExactRows, evaluator_->free_blocks()});
  if (!evaluation.ok()) return false;
  const ResidualRows& rows = evaluation.exact_rows;
  *jacobian = Eigen::MatrixXd::Zero(rows.jacobian.rows(), coordinates.size());
  (*jacobian)(Eigen::all, rows.active) = rows.jacobian;
  *residuals = rows.residuals;
  if (frame_scores != nullptr) {
    *frame_scores = Eigen::MatrixXd::Zero(coordinates.size(), rows.frame_scores.cols());
    (*frame_scores)(rows.active, Eigen::all) = rows.frame_scores;
  }
  return true;
}

bool RolloutCost::Predict(const Eigen::VectorXd& coordinates, Eigen::MatrixXd* predicted, RolloutCounts* counts) const {
  const RolloutEvaluation& evaluation = evaluator_->At({coordinates, precision_, Need::kCost, {}});
  if (!evaluation.ok()) return false;
  *predicted = evaluation.predicted;
  if (counts != nullptr) *counts = evaluation.counts;
  return true;
}

void RolloutCost::Restart() { evaluator_->ForgetJacobian(); }

const std::string& RolloutCost::last_failure() const { return evaluator_->last_failure(); }

void RolloutCost::CheckJournal() const {
  if (evaluator_->journal_error()) throw *evaluator_->journal_error();
}

const CostStatistics& RolloutCost::statistics() const { return evaluator_->statistics(); }

const RecordingModel& RolloutCost::model() const { return evaluator_->model(); }

}  // namespace clothid
