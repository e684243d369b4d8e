#include "costs/rollout_cost.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "costs/rows/evaluated_residuals.h"
#include "costs/rows/reflected_rows.h"
#include "costs/rows/rollout_evaluator.h"

namespace clothid {

namespace {

using Need = EvaluationNeed;

// Of the parameter blocks behind those of size 1.
std::vector<int> UnknownSizes(const RecordingModel& model) {
  std::vector<int> sizes;
  for (const int size : {model.num_start_unknowns(), model.num_field_unknowns()}) {
    if (size > 0) sizes.push_back(size);
  }
  return sizes;
}

}  // namespace

RolloutCost::RolloutCost(const RecordedMotion& motion, std::vector<ParameterBlock> blocks,
                         const RolloutCostOptions& options)
    : RolloutCost(std::make_shared<RolloutEvaluator>(motion, std::move(blocks), options), Precision::kFull) {}

RolloutCost::RolloutCost(std::shared_ptr<RolloutEvaluator> evaluator, Precision precision)
    : evaluator_(std::move(evaluator)), precision_(precision) {
  for (int i = 0; i < model().num_blocks(); ++i) mutable_parameter_block_sizes()->push_back(1);
  for (const int size : UnknownSizes(model())) mutable_parameter_block_sizes()->push_back(size);
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
  Eigen::VectorXd coordinates(model().num_coordinates());
  std::vector<int> active;
  int first = 0;
  for (std::size_t i = 0; i < parameter_block_sizes().size(); ++i) {
    const int size = parameter_block_sizes()[i];
    coordinates.segment(first, size) = Eigen::Map<const Eigen::VectorXd>(parameters[i], size);
    const bool is_asked = jacobians != nullptr && jacobians[i] != nullptr;
    for (int k = 0; is_asked && k < size; ++k) active.push_back(first + k);
    first += size;
  }
  const RolloutEvaluation& evaluation =
      evaluator_->At({coordinates, precision_, active.empty() ? Need::kCost : Need::kRows, active});
  if (!evaluation.ok()) return false;

  Eigen::Map<Eigen::VectorXd> out(residuals, num_residuals());
  out.setZero();
  out[num_residuals() - 1] = std::sqrt(2.0 * (evaluation.cost + PriorAt(coordinates)));
  if (active.empty()) return true;
  const Eigen::MatrixXd rows = RowsOf(evaluation);
  const std::vector<int>& known = evaluation.rows.active;
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  first = 0;
  for (std::size_t i = 0; i < parameter_block_sizes().size(); ++i) {
    const int size = parameter_block_sizes()[i];
    if (jacobians[i] != nullptr) {
      const auto column = std::lower_bound(known.begin(), known.end(), first) - known.begin();
      if (size == 1) {
        Eigen::Map<Eigen::VectorXd>(jacobians[i], num_residuals()) = rows.col(column);
      } else {
        Eigen::Map<RowMajor>(jacobians[i], num_residuals(), size) = rows.middleCols(column, size);
      }
    }
    first += size;
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
    const std::vector<int>& active = evaluation.rows.active;
    const auto column = std::lower_bound(active.begin(), active.end(), model().num_blocks());
    if (column != active.end() && *column < model().num_blocks() + start.size()) {
      jacobian.block(0, column - active.begin(), first, start.size()) = start.prior_jacobian();
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
    gradient->segment(model().num_blocks(), start->size()) +=
        start->prior_jacobian().transpose() * start->PriorResiduals(model().StartUnknowns(coordinates));
  }
  return true;
}

bool RolloutCost::EvaluateCost(const Eigen::VectorXd& coordinates, double* cost) const {
  const RolloutEvaluation& evaluation = evaluator_->At({coordinates, precision_, Need::kCostAlone, {}});
  if (evaluation.ok()) *cost = evaluation.cost + PriorAt(coordinates);
  return evaluation.ok();
}

bool RolloutCost::Linearize(const Eigen::VectorXd& coordinates, const Eigen::MatrixXd& combinations,
                            Eigen::MatrixXd* jacobian, Eigen::VectorXd* residuals,
                            Eigen::MatrixXd* frame_scores) const {
  const RolloutEvaluation& evaluation =
      evaluator_->At({coordinates, precision_, Need::kExactRows, evaluator_->free_blocks(), combinations});
  if (!evaluation.ok()) return false;
  const ResidualRows& rows = evaluation.exact_rows;
  const Eigen::Index num_rows = rows.jacobian.rows(), num_combined = combinations.cols();
  *jacobian = Eigen::MatrixXd::Zero(num_rows + num_prior_rows(), model().num_blocks() + num_combined);
  jacobian->topRows(num_rows)(Eigen::all, rows.active) = rows.jacobian.leftCols(rows.jacobian.cols() - num_combined);
  jacobian->topRightCorner(num_rows, num_combined) = rows.jacobian.rightCols(num_combined);
  residuals->resize(jacobian->rows());
  residuals->head(num_rows) = rows.residuals;
  if (const UnknownStart* const start = model().unknown_start()) {
    if (num_combined > 0) {
      jacobian->bottomRightCorner(num_prior_rows(), num_combined) =
          start->prior_jacobian() * combinations.topRows(start->size());
    }
    residuals->tail(num_prior_rows()) = start->PriorResiduals(model().StartUnknowns(coordinates));
  }
  if (frame_scores != nullptr) {
    *frame_scores = Eigen::MatrixXd::Zero(jacobian->cols(), rows.frame_scores.cols());
    (*frame_scores)(rows.active, Eigen::all) = rows.frame_scores.topRows(rows.frame_scores.rows() - num_combined);
    frame_scores->bottomRows(num_combined) = rows.frame_scores.bottomRows(num_combined);
  }
  return true;
}

bool RolloutCost::TimesCurvature(const Eigen::VectorXd& coordinates, const Eigen::VectorXd& direction,
                                 Eigen::VectorXd* product) const {
  if (!evaluator_->At({coordinates, precision_, Need::kCost, {}}).ok()) return false;
  const RolloutEvaluation& evaluation =
      evaluator_->At({coordinates, precision_, Need::kProduct, evaluator_->free_coordinates(), direction});
  if (evaluation.ok()) *product = evaluation.product;
  return evaluation.ok();
}

bool RolloutCost::PullBackChange(const Eigen::VectorXd& coordinates, const Eigen::MatrixXd& predicted,
                                 const Eigen::MatrixXd& forces, Eigen::VectorXd* product) const {
  const RolloutEvaluation& here = evaluator_->At({coordinates, precision_, Need::kCost, {}});
  if (!here.ok()) return false;
  const Eigen::VectorXd change = ResidualChange(model().observation(), here, predicted, forces);
  const RolloutEvaluation& evaluation =
      evaluator_->At({coordinates, precision_, Need::kPullBack, evaluator_->free_coordinates(), change});
  if (evaluation.ok()) *product = evaluation.product;
  return evaluation.ok();
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

void RolloutCost::SetModelError(const ModelError& error) { evaluator_->SetModelError(error); }

void RolloutCost::Assimilate(const Assimilation& assimilation) { evaluator_->Assimilate(assimilation); }

void RolloutCost::Restart() { evaluator_->ForgetJacobian(); }
void RolloutCost::Forget() { evaluator_->Forget(); }
void RolloutCost::KeepOnly(const Eigen::VectorXd& coordinates) const { evaluator_->KeepOnly(coordinates); }

const std::string& RolloutCost::last_failure() const { return evaluator_->last_failure(); }

void RolloutCost::CheckJournal() const {
  if (evaluator_->journal_error()) throw *evaluator_->journal_error();
}

const CostStatistics& RolloutCost::statistics() const { return evaluator_->statistics(); }

const RecordingModel& RolloutCost::model() const { return evaluator_->model(); }

}  // namespace clothid
