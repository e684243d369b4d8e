#include "identify/fit/stage_rows.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "sim/matrix/dense.h"

namespace clothid {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

std::vector<int> FreeInBasis(const FitProblem& problem, const UnknownBasis& basis, const Eigen::VectorXd& unknowns,
                             const Eigen::VectorXd& gradient) {
  std::vector<int> free;
  for (int i = 0; i < static_cast<int>(basis.size()); ++i) {
    if (i < problem.num_blocks()) {
      const ParameterBlock& block = problem.blocks()[i];
      if (block.frozen || IsHeld(block, unknowns[i], gradient[i])) continue;
    }
    free.push_back(i);
  }
  return free;
}

}  // namespace

ceres::Solver::Options StageSolver(double trust_region, int max_iterations, double parameter_tolerance) {
  ceres::Solver::Options solver;
  solver.minimizer_type = ceres::TRUST_REGION;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.initial_trust_region_radius = trust_region;
  solver.max_num_iterations = max_iterations;
  solver.parameter_tolerance = parameter_tolerance;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  return solver;
}

StageRows::StageRows(const FitProblem& problem, const UnknownBasis& basis, std::vector<int> free,
                     const Eigen::VectorXd& unknowns, Precision precision, FitEvaluator* evaluator)
    : problem_(problem), basis_(basis), free_(std::move(free)), precision_(precision), evaluator_(evaluator) {
  Eigen::VectorXd coordinates = Eigen::VectorXd::Zero(basis.size());
  coordinates(free_) = FreeCoordinates(unknowns);
  rest_ = unknowns - basis.Extend(coordinates);
  // What the parameters do not owe to x is theirs to the last digit.
  rest_.head(problem.num_blocks()) = unknowns.head(problem.num_blocks());
  for (const int i : free_) {
    if (i < problem.num_blocks()) rest_[i] = 0.0;
  }
  mutable_parameter_block_sizes()->push_back(static_cast<int>(free_.size()));
}

Eigen::VectorXd StageRows::Unknowns(const double* free) const {
  Eigen::VectorXd coordinates = Eigen::VectorXd::Zero(basis_.size());
  coordinates(free_) = Eigen::Map<const Eigen::VectorXd>(free, static_cast<Eigen::Index>(free_.size()));
  return rest_ + basis_.Extend(coordinates);
}

std::unique_ptr<ceres::Problem> StageRows::MakeCeresProblem(double* free) {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  auto problem = std::make_unique<ceres::Problem>(options);
  problem->AddResidualBlock(this, nullptr, free);
  for (int i = 0; i < static_cast<int>(free_.size()) && free_[i] < problem_.num_blocks(); ++i) {
    const ParameterBlock& block = problem_.blocks()[free_[i]];
    problem->SetParameterLowerBound(free, i, block.ToCoordinate(block.lower_bound));
    problem->SetParameterUpperBound(free, i, block.ToCoordinate(block.upper_bound));
  }
  return problem;
}

FreshRows::FreshRows(const FitProblem& problem, const UnknownBasis& basis, const Eigen::VectorXd& unknowns,
                     Precision precision, bool has_exact_rows, FitEvaluator* evaluator)
    : StageRows(problem, basis, problem.free_blocks(), unknowns, precision, evaluator),
      has_exact_rows_(has_exact_rows) {
  auto num_rows = static_cast<int>(problem.PriorResiduals(unknowns).size());
  for (int r = 0; r < problem.num_recordings(); ++r) num_rows += problem.cost(r).num_residuals();
  set_num_residuals(num_rows);
}

bool FreshRows::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  using Derivative = FitEvaluator::Derivative;
  const bool with_jacobian = jacobians != nullptr && jacobians[0] != nullptr;
  const Derivative derivative = has_exact_rows_ ? Derivative::kExactRows
                                : with_jacobian ? Derivative::kRows
                                                : Derivative::kNone;
  double cost = 0.0;
  if (!evaluator_->Evaluate(Unknowns(parameters[0]), derivative, &cost, nullptr, precision_)) return false;
  Eigen::Map<Eigen::VectorXd> out(residuals, num_residuals());
  if (!with_jacobian) {
    out.setZero();
    out[num_residuals() - 1] = std::sqrt(2.0 * cost);
    return true;
  }
  out = evaluator_->rows().residuals;
  Eigen::Map<RowMajor>(jacobians[0], num_residuals(), static_cast<Eigen::Index>(free_.size())) =
      evaluator_->rows().jacobian(Eigen::all, free_);
  return true;
}

LaggedRows::LaggedRows(const FitProblem& problem, const UnknownBasis& basis, const Eigen::MatrixXd& hessian,
                       const Eigen::VectorXd& gradient, double cost, const Eigen::VectorXd& unknowns,
                       Precision precision, FitEvaluator* evaluator)
    : StageRows(problem, basis, FreeInBasis(problem, basis, unknowns, gradient), unknowns, precision, evaluator),
      hessian_(hessian(free_, free_)),
      gradient_(gradient),
      cost_(cost) {
  const Eigen::VectorXd own = FreeCoordinates(gradient);
  const double squared = std::max(2.0 * cost, std::numeric_limits<double>::min());
  root_ = TransposedRoot(hessian_ - own * (own.transpose() / squared));
  set_num_residuals(static_cast<int>(free_.size()) + 1);
}

bool LaggedRows::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const bool with_jacobian = jacobians != nullptr && jacobians[0] != nullptr;
  const auto derivative = with_jacobian ? FitEvaluator::Derivative::kGradient : FitEvaluator::Derivative::kNone;
  double cost = 0.0;
  Eigen::VectorXd gradient;
  if (!evaluator_->Evaluate(Unknowns(parameters[0]), derivative, &cost, &gradient, precision_)) return false;
  Eigen::Map<Eigen::VectorXd> out(residuals, num_residuals());
  out.setZero();
  out[num_residuals() - 1] = std::sqrt(2.0 * cost);
  if (!with_jacobian) return true;
  gradient_ = gradient;
  cost_ = cost;
  Eigen::Map<RowMajor> rows(jacobians[0], num_residuals(), root_.cols());
  rows.topRows(root_.rows()) = root_;
  rows.bottomRows<1>() =
      FreeCoordinates(gradient).transpose() / std::max(out[num_residuals() - 1], std::numeric_limits<double>::min());
  return true;
}

PredictedDecrease LaggedRows::DecreaseAt(const Eigen::VectorXd& unknowns, const Eigen::VectorXd& gradient) const {
  std::vector<int> movable;
  int num_parameters = 0;
  for (int i = 0; i < static_cast<int>(free_.size()); ++i) {
    const bool is_parameter = free_[i] < problem_.num_blocks();
    if (is_parameter &&
        (IsHeld(problem_.blocks()[free_[i]], unknowns[free_[i]], gradient[free_[i]]) || !(hessian_(i, i) > 0.0))) {
      continue;
    }
    movable.push_back(i);
    num_parameters += is_parameter ? 1 : 0;
  }
  PredictedDecrease decrease;
  decrease.num_free = static_cast<int>(movable.size());
  if (movable.empty()) return decrease;
  const SymmetricFactor factor(hessian_(movable, movable));
  const Eigen::VectorXd part = FreeCoordinates(gradient)(movable), step = factor.SolveOne(part);
  decrease.total = 0.5 * part.dot(step);
  if (num_parameters == 0) return decrease;
  const Eigen::MatrixXd units = Eigen::MatrixXd::Identity(part.size(), num_parameters);
  const Eigen::MatrixXd covariance = factor.Solve(units).topRows(num_parameters);
  const Eigen::VectorXd own = step.head(num_parameters);
  decrease.of_parameters = 0.5 * own.dot(SymmetricFactor(covariance).SolveOne(own));
  return decrease;
}

}  // namespace clothid
