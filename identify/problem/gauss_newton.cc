#include "identify/problem/gauss_newton.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "sim/matrix/dense.h"

namespace clothid {
namespace {

std::vector<int> MovableBlocks(const FitProblem& problem, const QuadraticModel& model) {
  std::vector<int> movable;
  for (int i = 0; i < problem.num_blocks(); ++i) {
    const ParameterBlock& block = problem.blocks()[i];
    const bool is_held = IsHeld(block, model.coordinates[i], model.gradient[i]);
    if (!block.frozen && model.hessian(i, i) > 0.0 && !is_held) movable.push_back(i);
  }
  return movable;
}

}  // namespace

std::optional<Eigen::VectorXd> GaussNewtonStep(const FitProblem& problem, const QuadraticModel& model) {
  Eigen::VectorXd step = Eigen::VectorXd::Zero(problem.num_blocks());
  const std::vector<int> movable = MovableBlocks(problem, model);
  if (movable.empty()) return step;
  const Eigen::VectorXd gradient = model.gradient(movable);
  const Eigen::MatrixXd hessian = model.hessian(movable, movable);
  const Eigen::VectorXd solution = SymmetricFactor(hessian).SolveOne(-gradient);
  if (!solution.allFinite() || (hessian * solution + gradient).norm() > 1e-6 * gradient.norm()) return std::nullopt;
  step(movable) = solution;
  return step;
}

bool IsShort(const FitProblem& problem, const Eigen::VectorXd& coordinates, const Eigen::VectorXd& step,
             double length) {
  for (Eigen::Index i = 0; i < step.size(); ++i) {
    if (std::abs(step[i]) > length * problem.blocks()[i].Resolution(coordinates[i])) return false;
  }
  return true;
}

bool NextStepIsNegligible(const FitProblem& problem, const QuadraticModel& model, double length,
                          double function_tolerance) {
  const std::optional<Eigen::VectorXd> step = GaussNewtonStep(problem, model);
  if (!step) return false;
  return -0.5 * model.gradient.dot(*step) <= function_tolerance * model.cost ||
         IsShort(problem, model.coordinates, *step, length);
}

Eigen::VectorXd NextPoint(const FitProblem& problem, const QuadraticModel& model, double length) {
  Eigen::VectorXd next = model.coordinates;
  const std::optional<Eigen::VectorXd> step = GaussNewtonStep(problem, model);
  if (!step || !IsShort(problem, model.coordinates, *step, length)) return next;
  next.head(problem.num_blocks()) += *step;
  for (int i = 0; i < problem.num_blocks(); ++i) {
    const ParameterBlock& block = problem.blocks()[i];
    next[i] = std::clamp(next[i], block.ToCoordinate(block.lower_bound), block.ToCoordinate(block.upper_bound));
  }
  return next;
}

}  // namespace clothid
