#include "identify/checks/gradient_check.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "identify/problem/evaluator.h"
#include "identify/problem/problem.h"

namespace clothid {
namespace {

constexpr double kCheckTolerance = 1e-10;
// Step of the central differences in an internal coordinate of order one: costs known to about kCheckTolerance,
// truncation error of order step^2.
constexpr double kDifferenceStep = 1e-4;
// A component below this share of the cost is lost in the rounding of the differences.
constexpr double kInfluence = 1e-8;

// One way of computing the cost and its gradient at the start.
class Differentiator {
 public:
  Differentiator(const std::vector<RecordedMotion>& motions, const FitOptions& options, JacobianMethod method)
      : method_(method),
        problem_(motions, WithMethod(options, method)),
        start_(problem_.StartCoordinates()),
        evaluator_(&problem_, options.num_threads) {}

  const FitProblem& problem() const { return problem_; }
  const Eigen::VectorXd& start() const { return start_; }

  // Nothing where a rollout or derivative failed: see last_failure().
  std::optional<double> Cost(const Eigen::VectorXd& coordinates) {
    double cost = 0.0;
    if (!evaluator_.Evaluate(coordinates, FitEvaluator::Derivative::kNone, &cost, nullptr)) return std::nullopt;
    return cost;
  }
  std::optional<Eigen::VectorXd> Gradient() {
    double cost = 0.0;
    Eigen::VectorXd gradient;
    // With an unknown start every method has the gradient of the adjoint; the rows are the method's own.
    const bool by_rows = problem_.num_start_unknowns() > 0 && method_ != JacobianMethod::kAdjoint;
    const auto derivative = by_rows ? FitEvaluator::Derivative::kRows : FitEvaluator::Derivative::kGradient;
    if (!evaluator_.Evaluate(start_, derivative, &cost, &gradient)) return std::nullopt;
    return gradient;
  }
  const std::string& last_failure() const { return evaluator_.last_failure(); }

 private:
  static FitOptions WithMethod(FitOptions options, JacobianMethod method) {
    options.jacobian = method;
    options.journal_folder.clear();  // the journals belong to the fit
    return options;
  }

  JacobianMethod method_;
  FitProblem problem_;
  Eigen::VectorXd start_;
  FitEvaluator evaluator_;
};

std::optional<double> CentralDifference(int block, Differentiator* differentiator) {
  Eigen::VectorXd above = differentiator->start(), below = above;
  above[block] += kDifferenceStep;
  below[block] -= kDifferenceStep;
  // A friction coefficient at zero has no other side.
  const ParameterBlock& parameter = differentiator->problem().blocks()[block];
  const bool has_no_other_side = parameter.scale == ParameterScale::kLinear && !parameter.is_signed;
  if (has_no_other_side && below[block] < 0.0) below[block] = 0.0;
  const std::optional<double> cost_above = differentiator->Cost(above);
  const std::optional<double> cost_below = cost_above ? differentiator->Cost(below) : std::nullopt;
  if (!cost_below) return std::nullopt;
  return (*cost_above - *cost_below) / (above[block] - below[block]);
}

GradientCheck Failed(const Differentiator& differentiator) {
  GradientCheck check;
  check.failure = "gradient check: " + differentiator.last_failure();
  return check;
}

double RelativeDifference(double a, double b) {
  const double scale = std::max(std::abs(a), std::abs(b));
  return scale > 0.0 ? std::abs(a - b) / scale : 0.0;
}

}  // namespace

GradientCheck CheckGradients(const std::vector<RecordedMotion>& motions, const FitOptions& options) {
  std::vector<RecordedMotion> tight = motions;
  for (RecordedMotion& motion : tight) {
    motion.scene.solver.step_tolerance = std::min(motion.scene.solver.step_tolerance, kCheckTolerance);
  }
  Differentiator adjoint(tight, options, JacobianMethod::kAdjoint);
  Differentiator sensitivity(tight, options, JacobianMethod::kSensitivity);
  const std::optional<double> cost = adjoint.Cost(adjoint.start());
  if (!cost) return Failed(adjoint);
  const std::optional<Eigen::VectorXd> by_adjoint = adjoint.Gradient();
  if (!by_adjoint) return Failed(adjoint);
  const std::optional<Eigen::VectorXd> by_sensitivity = sensitivity.Gradient();
  if (!by_sensitivity) return Failed(sensitivity);

  GradientCheck check;
  for (int i = 0; i < adjoint.problem().num_blocks(); ++i) {
    if (adjoint.problem().blocks()[i].frozen) continue;
    const std::optional<double> difference = CentralDifference(i, &adjoint);
    if (!difference) return Failed(adjoint);
    const double a = (*by_adjoint)[i], s = (*by_sensitivity)[i];
    if (std::max({std::abs(a), std::abs(s), std::abs(*difference)}) <= kInfluence * *cost) continue;
    check.adjoint_vs_sensitivity = std::max(check.adjoint_vs_sensitivity, RelativeDifference(a, s));
    check.adjoint_vs_fd = std::max(check.adjoint_vs_fd, RelativeDifference(a, *difference));
  }
  return check;
}

}  // namespace clothid
