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
  if (model().unknown_start() != nullptr) mutable_parameter_block_sizes()->push_back(model().num_start_unknowns());
  set_num_residuals(num_prior_rows() + evaluator_->num_rows() + (evaluator_->options().loss.is_robust() ? 1 : 0));
}

double RolloutCost::PriorAt(const Eigen::VectorXd& coordinates) const {
  const UnknownStart* const start = model().unknown_start();
  return start == nullptr ? 0.0 : start->PriorAt(model().StartUnknowns(coordinates));
}

int RolloutCost::num_prior_rows() const {
  const UnknownStart* const start = model().unknown_start();
  return start == nullptr ? 0 : static_cast<int>(start->prior_jacobian().rows());
}

RolloutCost::~RolloutCost() = default;

std::unique_ptr<RolloutCost> RolloutCost::AtPrecision(Precision precision) const {
  return std::unique_ptr<RolloutCost>(new RolloutCost(evaluator_, precision));
}

bool RolloutCost::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const int num_blocks = model().num_blocks(), num_unknowns = model().num_start_unknowns();
  Eigen::VectorXd coordinates(num_blocks + num_unknowns);
  std::vector<int> active;
  for (int i = 0; i < num_blocks; ++i) {
    coordinates[i] = parameters[i][0];
    if (jacobians != nullptr && jacobians[i] != nullptr) active.push_back(i);
  }
  if (num_unknowns > 0)
    coordinates.tail(num_unknowns) = Eigen::Map<const Eigen::VectorXd>(parameters[num_blocks], num_unknowns);
  const bool with_start = num_unknowns > 0 && jacobians != nullptr && jacobians[num_blocks] != nullptr;
  for (int i = 0; with_start && i < num_unknowns; ++i) active.push_back(num_blocks + i);
  const RolloutEvaluation& evaluation =
      evaluator_->At({coordinates, precision_, active.empty() ? Need::kCost : Need::kRows, active});
  if (!evaluation.ok()) return false;

  Eigen::Map<Eigen::VectorXd> out(residuals, num_residuals());
  out.setZero();
  out[num_residuals() - 1] = std::sqrt(2.0 * (evaluation.cost + PriorAt(coordinates)));
  if (active.empty()) return true;
  const Eigen::MatrixXd rows = RowsOf(evaluation);
  for (std::size_t column = 0; column < evaluation.rows.active.size(); ++column) {
    const int block = evaluation.rows.active[column];
    if (block >= num_blocks) break;
    if (jacobians[block] == nullptr) continue;
    Eigen::Map<Eigen::VectorXd>(jacobians[block], num_residuals()) = rows.col(static_cast<Eigen::Index>(column));
  }
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  if (with_start) {
    Eigen::Map<RowMajor>(jacobians[num_blocks], num_residuals(), num_unknowns) = rows.rightCols(num_unknowns);
  }
  return true;
}

Eigen::MatrixXd RolloutCost::RowsOf(const RolloutEvaluation& evaluation) const {
  const int first = num_prior_rows(), num_rows = evaluator_->num_rows();
  Eigen::VectorXd residuals(num_residuals());
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(num_residuals(), evaluation.rows.jacobian.cols());
  if (first > 0) {
    const UnknownStart& start = *model().unknown_start();
    residuals.head(first) = start.PriorResiduals(model().StartUnknowns(evaluation.coordinates));
    if (evaluation.rows.active.back() >= model().num_blocks()) {
      jacobian.topRightCorner(first, start.size()) = start.prior_jacobian();
    }
  }
  residuals.segment(first, num_rows) = evaluation.rows.residuals;
  if (num_residuals() > first + num_rows) residuals[first + num_rows] = evaluation.loss_row;
  jacobian.middleRows(first, num_rows) = evaluation.rows.jacobian;
  return ReflectedJacobian(residuals, std::move(jacobian));
}

bool RolloutCost::EvaluateGradient(const Eigen::VectorXd& coordinates, double* cost, Eigen::VectorXd* gradient) const {
  const Need need = gradient == nullptr ? Need::kCost : Need::kGradient;
  const RolloutEvaluation& evaluation = evaluator_->At({coordinates, precision_, need, evaluator_->free_coordinates()});
  if (!evaluation.ok()) return false;
  *cost = evaluation.cost + PriorAt(coordinates);
  if (gradient == nullptr) return true;
  *gradient = evaluation.gradient;
  if (const UnknownStart* const start = model().unknown_start()) {
    gradient->tail(start->size()) +=
        start->prior_jacobian().transpose() * start->PriorResiduals(model().StartUnknowns(coordinates));
  }
  return true;
}

bool RolloutCost::Linearize(const Eigen::VectorXd& coordinates, Eigen::MatrixXd* jacobian, Eigen::VectorXd* residuals,
                            Eigen::MatrixXd* frame_scores) const {
  const RolloutEvaluation& evaluation =
      evaluator_->At({coordinates, precision_, Need::kExactRows, evaluator_->free_coordinates()});
  if (!evaluation.ok()) return false;
  const ResidualRows& rows = evaluation.exact_rows;
  *jacobian = Eigen::MatrixXd::Zero(rows.jacobian.rows() + num_prior_rows(), coordinates.size());
  jacobian->topRows(rows.jacobian.rows())(Eigen::all, rows.active) = rows.jacobian;
  residuals->resize(jacobian->rows());
  residuals->head(rows.residuals.size()) = rows.residuals;
  if (const UnknownStart* const start = model().unknown_start()) {
    jacobian->bottomRightCorner(num_prior_rows(), start->size()) = start->prior_jacobian();
    residuals->tail(num_prior_rows()) = start->PriorResiduals(model().StartUnknowns(coordinates));
  }
  if (frame_scores != nullptr) {
    *frame_scores = Eigen::MatrixXd::Zero(coordinates.size(), rows.frame_scores.cols());
    (*frame_scores)(rows.active, Eigen::all) = rows.frame_scores;
  }
  return true;
}

bool RolloutCost::LinearizeAlong(const Eigen::VectorXd& coordinates, const Eigen::MatrixXd& follow,
                                 Eigen::MatrixXd* jacobian, Eigen::VectorXd* residuals,
                                 Eigen::MatrixXd* frame_scores) const {
  ResidualRows rows;
  if (!evaluator_->RowsAlong(coordinates, precision_, follow, &rows)) return false;
  const Eigen::Index num_rows = rows.jacobian.rows(), num_blocks = model().num_blocks();
  *jacobian = Eigen::MatrixXd::Zero(num_rows + num_prior_rows(), num_blocks);
  jacobian->topRows(num_rows)(Eigen::all, rows.active) = rows.jacobian;
  residuals->resize(jacobian->rows());
  residuals->head(num_rows) = rows.residuals;
  if (const UnknownStart* const start = model().unknown_start()) {
    jacobian->bottomRows(num_prior_rows())(Eigen::all, rows.active) =
        start->prior_jacobian() * follow(Eigen::all, rows.active);
    residuals->tail(num_prior_rows()) = start->PriorResiduals(model().StartUnknowns(coordinates));
  }
  *frame_scores = Eigen::MatrixXd::Zero(num_blocks, rows.frame_scores.cols());
  (*frame_scores)(rows.active, Eigen::all) = rows.frame_scores;
  return true;
}

bool RolloutCost::Predict(const Eigen::VectorXd& coordinates, Eigen::MatrixXd* predicted, RolloutCounts* counts,
                          Eigen::MatrixXd* forces) const {
  const RolloutEvaluation& evaluation = evaluator_->At({coordinates, precision_, Need::kCost, {}});
  if (!evaluation.ok()) return false;
  *predicted = evaluation.predicted;
  if (counts != nullptr) *counts = evaluation.counts;
  if (forces != nullptr) *forces = evaluation.forces;
  return true;
}

void RolloutCost::Restart() { evaluator_->ForgetJacobian(); }
void RolloutCost::Forget() { evaluator_->Forget(); }

const std::string& RolloutCost::last_failure() const { return evaluator_->last_failure(); }

void RolloutCost::CheckJournal() const {
  if (evaluator_->journal_error()) throw *evaluator_->journal_error();
}

const CostStatistics& RolloutCost::statistics() const { return evaluator_->statistics(); }

const RecordingModel& RolloutCost::model() const { return evaluator_->model(); }

}  // namespace clothid
