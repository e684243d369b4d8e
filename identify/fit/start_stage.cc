#include "identify/fit/start_stage.h"

#include <ceres/cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "identify/uncertainty/priors.h"
#include "sim/matrix/dense.h"

namespace clothid {
namespace {

// The stage ends where what the next step promises, in s^2, is less: by moving the parameters, a step of 0.45 standard
// deviations with loose rollouts, whose errors are of that size, and of 0.1 with full ones; in all, per unknown, a step
// of 0.2 standard deviations: unknowns that are off by so much in no common direction move no parameter further.
constexpr double kLooseDecrease = 0.1;
constexpr double kFullDecrease = 5e-3;
constexpr double kUnnoticedDecrease = 0.02;
// A new H that gained no more than this per unknown, in s^2, will not gain more by another one: the cost has kinks.
constexpr double kStuckGain = 0.01;
// A step that lowers the cost by less than this share of what H says asks for a new one.
constexpr double kPoorStep = 0.2;
constexpr int kMostRounds = 8;
constexpr int kMostIterations = 8;  // with one H
// Ceres shortens a step of bounded unknowns by a line search first.
constexpr int kMostShortenings = 4;
// Trust regions of Levenberg-Marquardt: the first, and how much larger than where the last ended the next H may start.
constexpr double kTrustRegion = 1e4;
constexpr double kRegionGrowth = 30.0;

// s^2 of a cost L = |e|^2/2.
double SquaredScale(const Linearization& linearization, std::size_t num_parameters, double cost) {
  const double degrees = linearization.num_measurements - static_cast<double>(num_parameters);
  const double fitted = degrees > 0.0 ? 2.0 * cost / degrees : 1.0;
  return linearization.sigma_is_known ? std::max(1.0, fitted) : fitted;
}

// By all unknowns together, the mean of one; and by moving the parameters, the starts eliminated.
struct PredictedDecrease {
  double per_unknown = 0.0, of_parameters = 0.0;

  bool is_below(double tolerance, double scale) const {
    return of_parameters <= tolerance * scale && per_unknown <= kUnnoticedDecrease * scale;
  }
};

// Whether a parameter is pushed against one of its bounds.
bool IsHeld(double coordinate, double gradient, const ParameterBlock& block) {
  return (coordinate <= block.ToCoordinate(block.lower_bound) && gradient > 0.0) ||
         (coordinate >= block.ToCoordinate(block.upper_bound) && gradient < 0.0);
}

// Where the unknowns that may move stand among all coordinates. Parameters that are held stay: else the bounds would
// cut every step short for all the others.
std::vector<int> FreeCoordinates(const FitProblem& problem, const Eigen::VectorXd& coordinates,
                                 const Eigen::VectorXd& gradient) {
  std::vector<int> free;
  for (int i = 0; i < problem.num_coordinates(); ++i) {
    if (i < problem.num_blocks()) {
      const ParameterBlock& block = problem.blocks()[i];
      if (block.frozen || IsHeld(coordinates[i], gradient[i], block)) continue;
    }
    free.push_back(i);
  }
  return free;
}

// The rows of the header over the free coordinates, one parameter block of Ceres.
class LaggedRows : public ceres::CostFunction {
 public:
  LaggedRows(const FitProblem& problem, const Linearization& linearization, const Eigen::VectorXd& coordinates,
             Precision precision, FitEvaluator* evaluator)
      : problem_(problem),
        free_(FreeCoordinates(problem, coordinates, linearization.gradient)),
        coordinates_(coordinates),
        precision_(precision),
        evaluator_(evaluator) {
    const Eigen::MatrixXd jacobian = linearization.jacobian(Eigen::all, free_);
    hessian_ = jacobian.transpose() * jacobian;
    std::vector<int> blocks = free_;
    blocks.erase(std::lower_bound(blocks.begin(), blocks.end(), problem.num_blocks()), blocks.end());
    const auto count = static_cast<Eigen::Index>(blocks.size());
    hessian_.topLeftCorner(count, count) += PriorHessian(problem.blocks())(blocks, blocks);
    const Eigen::VectorXd gradient = linearization.gradient(free_);
    const double squared = std::max(linearization.squared_residual, std::numeric_limits<double>::min());
    root_ = TransposedRoot(hessian_ - gradient * (gradient.transpose() / squared));
    set_num_residuals(static_cast<int>(free_.size()) + 1);
    mutable_parameter_block_sizes()->push_back(static_cast<int>(free_.size()));
  }

  const std::vector<int>& free() const { return free_; }

  Eigen::VectorXd Coordinates(const double* unknowns) const {
    Eigen::VectorXd all = coordinates_;
    all(free_) = Eigen::Map<const Eigen::VectorXd>(unknowns, static_cast<Eigen::Index>(free_.size()));
    return all;
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const bool with_jacobian = jacobians != nullptr && jacobians[0] != nullptr;
    const auto derivative = with_jacobian ? FitEvaluator::Derivative::kGradient : FitEvaluator::Derivative::kNone;
    double cost = 0.0;
    Eigen::VectorXd gradient;
    if (!evaluator_->Evaluate(Coordinates(parameters[0]), derivative, &cost, &gradient, precision_)) return false;
    Eigen::Map<Eigen::VectorXd> out(residuals, num_residuals());
    out.setZero();
    out[num_residuals() - 1] = std::sqrt(2.0 * cost);
    if (!with_jacobian) return true;
    gradient_ = gradient;
    cost_ = cost;
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor> rows(jacobians[0], num_residuals(), root_.cols());
    rows.topRows(root_.rows()) = root_;
    rows.bottomRows<1>() =
        gradient(free_).transpose() / std::max(out[num_residuals() - 1], std::numeric_limits<double>::min());
    return true;
  }

  // What a Gauss-Newton step of the free coordinates from there lowers the cost by; parameters that are held by then,
  // and those that do nothing, stay. The gradient is that of all coordinates.
  PredictedDecrease DecreaseAt(const Eigen::VectorXd& coordinates, const Eigen::VectorXd& gradient) const {
    std::vector<int> movable;
    int num_parameters = 0;
    for (int i = 0; i < static_cast<int>(free_.size()); ++i) {
      const bool is_parameter = free_[i] < problem_.num_blocks();
      if (is_parameter &&
          (IsHeld(coordinates[free_[i]], gradient[free_[i]], problem_.blocks()[free_[i]]) || !(hessian_(i, i) > 0.0))) {
        continue;
      }
      movable.push_back(i);
      num_parameters += is_parameter ? 1 : 0;
    }
    const SymmetricFactor factor(hessian_(movable, movable));
    const Eigen::VectorXd part = gradient(free_)(movable), step = factor.SolveOne(part);
    PredictedDecrease decrease;
    decrease.per_unknown = 0.5 * part.dot(step) / static_cast<double>(part.size());
    const Eigen::MatrixXd units = Eigen::MatrixXd::Identity(part.size(), num_parameters);
    const Eigen::MatrixXd covariance = factor.Solve(units).topRows(num_parameters);
    const Eigen::VectorXd own = step.head(num_parameters);
    decrease.of_parameters = 0.5 * own.dot(SymmetricFactor(covariance).SolveOne(own));
    return decrease;
  }

  // Of the last point with a Jacobian; the gradient of all coordinates.
  const Eigen::VectorXd& last_gradient() const { return gradient_; }
  double last_cost() const { return cost_; }

 private:
  const FitProblem& problem_;
  std::vector<int> free_;
  Eigen::VectorXd coordinates_;  // of what does not move
  Precision precision_;
  FitEvaluator* evaluator_;
  Eigen::MatrixXd hessian_;  // H
  Eigen::MatrixXd root_;     // C^T
  mutable Eigen::VectorXd gradient_;
  mutable double cost_ = 0.0;
};

// Numbers iterations on over several runs of Ceres, each of which starts with the point where the one before it ended.
class Renumbered : public ceres::IterationCallback {
 public:
  Renumbered(int num_before, ceres::IterationCallback* callback) : num_before_(num_before), callback_(callback) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (summary.iteration == 0) return ceres::SOLVER_CONTINUE;
    ceres::IterationSummary renumbered = summary;
    renumbered.iteration += num_before_;
    return (*callback_)(renumbered);
  }

 private:
  int num_before_;
  ceres::IterationCallback* callback_;
};

// Ends the run where the next step is negligible, or H no longer fits.
class StopLagging : public ceres::IterationCallback {
 public:
  StopLagging(const LaggedRows& rows, const double* unknowns, double tolerance, double scale)
      : rows_(rows), unknowns_(unknowns), tolerance_(tolerance), scale_(scale) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (summary.iteration == 0) return ceres::SOLVER_CONTINUE;
    if (!summary.step_is_successful) {
      // Where H was made, shorter steps lead down; elsewhere they need not.
      return has_moved_ ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
    }
    has_moved_ = true;
    const bool is_poor = summary.relative_decrease < kPoorStep;
    const PredictedDecrease next = rows_.DecreaseAt(rows_.Coordinates(unknowns_), rows_.last_gradient());
    return is_poor || next.is_below(tolerance_, scale_) ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  const LaggedRows& rows_;
  const double* unknowns_;
  double tolerance_, scale_;
  bool has_moved_ = false;
};

void SetBounds(const FitProblem& problem, const std::vector<int>& free, double* unknowns,
               ceres::Problem* ceres_problem) {
  for (int i = 0; i < static_cast<int>(free.size()) && free[i] < problem.num_blocks(); ++i) {
    const ParameterBlock& block = problem.blocks()[free[i]];
    ceres_problem->SetParameterLowerBound(unknowns, i, block.ToCoordinate(block.lower_bound));
    ceres_problem->SetParameterUpperBound(unknowns, i, block.ToCoordinate(block.upper_bound));
  }
}

// A few iterations with one H. How many there were.
int RunLagged(const FitOptions& options, int num_before, int max_iterations, double tolerance, double scale,
              const FitProblem& problem, ceres::IterationCallback* callback, LaggedRows* rows, double* trust_region,
              Eigen::VectorXd* coordinates) {
  Eigen::VectorXd unknowns = (*coordinates)(rows->free());
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem ceres_problem(ownership);
  ceres_problem.AddResidualBlock(rows, nullptr, unknowns.data());
  SetBounds(problem, rows->free(), unknowns.data(), &ceres_problem);
  StopLagging stop(*rows, unknowns.data(), tolerance, scale);
  ceres::Solver::Options solver;
  solver.minimizer_type = ceres::TRUST_REGION;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.initial_trust_region_radius = *trust_region;
  solver.max_num_iterations = max_iterations;
  solver.max_num_line_search_step_size_iterations = kMostShortenings;
  solver.function_tolerance = 0.0;
  solver.parameter_tolerance = options.parameter_tolerance;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  solver.update_state_every_iteration = true;
  Renumbered renumbered(num_before, callback);
  solver.callbacks = {&renumbered, &stop};
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &ceres_problem, &summary);
  *coordinates = rows->Coordinates(unknowns.data());
  *trust_region = std::min(kTrustRegion, kRegionGrowth * summary.iterations.back().trust_region_radius);
  return static_cast<int>(summary.iterations.size()) - 1;
}

}  // namespace

StartStageResult RunStartStage(const FitOptions& options, Precision precision, int max_iterations,
                               const FitProblem& problem, Linearization known, ceres::IterationCallback* callback,
                               Eigen::VectorXd* coordinates, FitEvaluator* evaluator) {
  const double tolerance = precision == Precision::kFull ? kFullDecrease : kLooseDecrease;
  StartStageResult result;
  result.linearization = std::move(known);
  bool is_new = false;
  int num_iterations = 0;
  double trust_region = kTrustRegion;
  for (int round = 0; round < kMostRounds; ++round) {
    double cost = 0.0;
    Eigen::VectorXd gradient;
    is_new = round > 0 || result.linearization.jacobian.size() == 0;
    // The gradient of the adjoint is as exact as the rollout; that of the sweep is not.
    result.ok = (!is_new || evaluator->Linearize(*coordinates, &result.linearization, precision)) &&
                evaluator->Evaluate(*coordinates, FitEvaluator::Derivative::kGradient, &cost, &gradient, precision);
    if (!result.ok) {
      result.failure = evaluator->last_failure();
      return result;
    }
    result.linearization.gradient = gradient;
    result.linearization.squared_residual = 2.0 * cost;
    LaggedRows rows(problem, result.linearization, *coordinates, precision, evaluator);
    const double scale = SquaredScale(result.linearization, problem.blocks().size(), cost);
    PredictedDecrease next = rows.DecreaseAt(*coordinates, gradient);
    result.predicted_decrease = next.of_parameters / scale;
    if (next.is_below(tolerance, scale) || num_iterations >= max_iterations) return result;
    num_iterations += RunLagged(options, num_iterations, std::min(max_iterations - num_iterations, kMostIterations),
                                tolerance, scale, problem, callback, &rows, &trust_region, coordinates);
    next = rows.DecreaseAt(*coordinates, rows.last_gradient());
    result.predicted_decrease = next.of_parameters / scale;
    const double gained = (cost - rows.last_cost()) / scale;
    result.linearization.gradient = rows.last_gradient();
    result.linearization.squared_residual = 2.0 * rows.last_cost();
    const bool is_stuck = is_new && !(gained > kStuckGain * static_cast<double>(rows.free().size()));
    if (next.is_below(tolerance, scale) || is_stuck) return result;
    if (options.is_cancelled()) return result;
  }
  return result;
}

}  // namespace clothid
