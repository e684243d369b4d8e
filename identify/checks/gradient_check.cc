#include "identify/checks/gradient_check.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "identify/fit/evaluator.h"
#include "identify/fit/problem.h"

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
  Differentiator(const std::vector<RecordedMotion>& motions, FitOptions options, JacobianMethod method)
      : problem_(motions, WithMethod(std::move(options), method)),
        start_(problem_.StartCoordinates()),
        evaluator_(&problem_, options.num_threads) {}

  const FitProblem& problem() const { return problem_; }
  const Eigen::VectorXd& start() const { return start_; }

  double Cost(const Eigen::VectorXd& coordinates) { return Run(coordinates, FitEvaluator::Derivative::kNone, nullptr); }
  Eigen::VectorXd Gradient() {
    Eigen::VectorXd gradient;
    Run(start_, FitEvaluator::Derivative::kGradient, &gradient);
    return gradient;
  }

 private:
  static FitOptions WithMethod(FitOptions options, JacobianMethod method) {
    options.jacobian = method;
    options.journal_folder.clear();  // the journals belong to the fit
    return options;
  }
  double Run(const Eigen::VectorXd& coordinates, FitEvaluator::Derivative derivative, Eigen::VectorXd* gradient) {
    double cost = 0.0;
    if (!evaluator_.Evaluate(coordinates, derivative, &cost, gradient)) {
      throw std::runtime_error("gradient check: " + evaluator_.last_failure());
    }
    return cost;
  }

  FitProblem problem_;
  Eigen::VectorXd start_;
  FitEvaluator evaluator_;
};

double CentralDifference(int block, Differentiator* differentiator) {
  Eigen::VectorXd above = differentiator->start(), below = above;
  above[block] += kDifferenceStep;
  below[block] -= kDifferenceStep;
  // A friction coefficient at zero has no other side.
  const ParameterBlock& parameter = differentiator->problem().blocks()[block];
  const bool has_no_other_side = parameter.scale == ParameterScale::kLinear && !parameter.is_signed;
  if (has_no_other_side && below[block] < 0.0) below[block] = 0.0;
  return (differentiator->Cost(above) - differentiator->Cost(below)) / (above[block] - below[block]);
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
  const double cost = adjoint.Cost(adjoint.start());
  const Eigen::VectorXd by_adjoint = adjoint.Gradient(), by_sensitivity = sensitivity.Gradient();

  GradientCheck check;
  for (int i = 0; i < adjoint.problem().num_blocks(); ++i) {
    if (adjoint.problem().blocks()[i].frozen) continue;
    const double difference = CentralDifference(i, &adjoint);
    const double largest = std::max({std::abs(by_adjoint[i]), std::abs(by_sensitivity[i]), std::abs(difference)});
    if (largest <= kInfluence * cost) continue;
    check.adjoint_vs_sensitivity =
        std::max(check.adjoint_vs_sensitivity, RelativeDifference(by_adjoint[i], by_sensitivity[i]));
    check.adjoint_vs_fd = std::max(check.adjoint_vs_fd, RelativeDifference(by_adjoint[i], difference));
  }
  return check;
}

}  // namespace clothid
