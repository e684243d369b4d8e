#include "identify/checks/step_error.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "identify/problem/evaluator.h"
#include "identify/uncertainty/discretization_error.h"
#include "sim/matrix/dense.h"

namespace clothid {
namespace {

class StepErrorFinder {
 public:
  StepErrorFinder(const std::vector<RecordedMotion>& motions, const FitOptions& options, const FitProblem& problem,
                  FitSummary* summary, std::vector<StepPrediction> at_half)
      : motions_(motions), options_(options), problem_(problem), summary_(summary), at_half_(std::move(at_half)) {
    for (int i = 0; i < problem.num_blocks(); ++i) {
      if (!std::isnan(summary->uncertainty->parameters[i].coordinate_std)) told_.push_back(i);
    }
  }

  // Of q [p]; empty: not known, and `failure` says why where something failed.
  std::vector<DiscretizationError> Find(std::string* failure) {
    if (told_.empty() || options_.is_cancelled()) return {};
    if (at_half_.empty()) at_half_ = PredictAllAtStep(0.5, motions_, options_, problem_, summary_->coordinates);
    const Eigen::VectorXd at_half = EstimateFrom(std::move(at_half_), failure);
    if (!failure->empty()) return {};
    std::vector<DiscretizationError> errors = ErrorsFrom(at_half, Nowhere());
    if (!ExceedNoise(errors)) return errors;
    std::string no_order;
    const Eigen::VectorXd at_double =
        EstimateFrom(PredictAllAtStep(2.0, motions_, options_, problem_, summary_->coordinates), &no_order);
    return no_order.empty() ? ErrorsFrom(at_half, at_double) : errors;
  }

 private:
  // Where a fit at the step of `predictions` would end [p]: NaN for parameters that are not told.
  Eigen::VectorXd EstimateFrom(std::vector<StepPrediction> predictions, std::string* failure) {
    FitEvaluator evaluator(&problem_, options_.num_threads, EvaluationPurpose::kInterval);
    Eigen::VectorXd change;
    const bool ok = PullBackStep(summary_->coordinates, std::move(predictions), &evaluator, &summary_->statistics,
                                 &change, failure);
    summary_->statistics += evaluator.statistics();
    return ok ? EstimateAfter(change) : Eigen::VectorXd();
  }

  Eigen::VectorXd Nowhere() const {
    return Eigen::VectorXd::Constant(problem_.num_blocks(), std::numeric_limits<double>::quiet_NaN());
  }

  // Where a change of the gradient [p + n + f] moves the minimum of the marginal model to [p].
  Eigen::VectorXd EstimateAfter(const Eigen::VectorXd& change) const {
    const MarginalModel& model = *summary_->marginal;
    const Eigen::Index p = problem_.num_blocks();
    const Eigen::VectorXd gradient = change.head(p) + model.follow.transpose() * change.tail(problem_.num_unknowns());
    const Eigen::MatrixXd hessian = model.hessian(told_, told_);
    Eigen::VectorXd moved = Nowhere();
    moved(told_) = summary_->coordinates(told_) - SymmetricFactor(hessian).SolveOne(gradient(told_));
    return moved;
  }

  std::vector<DiscretizationError> ErrorsFrom(const Eigen::VectorXd& at_half, const Eigen::VectorXd& at_double) const {
    std::vector<DiscretizationError> errors;
    for (Eigen::Index i = 0; i < at_half.size(); ++i) {
      errors.push_back(ErrorOfStep(summary_->coordinates[i], at_half[i], at_double[i]));
    }
    return errors;
  }

  bool ExceedNoise(const std::vector<DiscretizationError>& errors) const {
    return std::any_of(told_.begin(), told_.end(),
                       [&](int i) { return errors[i].error > summary_->uncertainty->parameters[i].coordinate_std; });
  }

  const std::vector<RecordedMotion>& motions_;
  const FitOptions& options_;
  const FitProblem& problem_;
  FitSummary* summary_;
  std::vector<StepPrediction> at_half_;  // empty: not known yet
  std::vector<int> told_;                // the parameters that have a standard deviation
};

}  // namespace

StepErrorEstimate AddStepError(const std::vector<RecordedMotion>& motions, const FitOptions& options,
                               const FitProblem& problem, FitSummary* summary, std::vector<StepPrediction> at_half) {
  if (!summary->uncertainty || !summary->marginal) return {};
  StepErrorEstimate estimate;
  const std::vector<DiscretizationError> errors =
      StepErrorFinder(motions, options, problem, summary, std::move(at_half)).Find(&estimate.failure);
  if (options.is_cancelled()) return {};
  if (errors.empty()) return estimate;
  AddEstimatedStepErrors(problem.blocks(), summary->coordinates.head(problem.num_blocks()), errors,
                         &*summary->uncertainty);
  for (const ParameterUncertainty& parameter : summary->uncertainty->parameters) {
    estimate.errors.push_back(parameter.step_error);
  }
  return estimate;
}

}  // namespace clothid
