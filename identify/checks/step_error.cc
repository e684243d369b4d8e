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
    const std::vector<Eigen::VectorXd> at_half =
        at_half_.empty() ? EstimatesAt(0.5, failure) : EstimatesFrom(std::move(at_half_), failure);
    if (!failure->empty()) return {};
    const std::vector<DiscretizationError> errors = ErrorsFrom(at_half, {Nowhere(), Nowhere()});
    if (!ExceedNoise(errors)) return errors;
    std::string no_order;
    const std::vector<Eigen::VectorXd> at_double = EstimatesAt(2.0, &no_order);
    return no_order.empty() ? ErrorsFrom(at_half, at_double) : errors;
  }

 private:
  // Where a fit at `factor` times the step would end [p], as far as its cost is quadratic: by the derivatives here and,
  // of parameters alone, by those there.
  std::vector<Eigen::VectorXd> EstimatesAt(double factor, std::string* failure) {
    if (problem_.num_unknowns() > 0 || !problem_.has_few_blocks()) {
      return EstimatesFrom(PredictAllAtStep(factor, motions_, options_, problem_, summary_->coordinates), failure);
    }
    QuadraticModel model;
    std::vector<StepPrediction> predictions;
    if (!ModelAtStep(factor, motions_, options_, problem_, summary_->coordinates, &summary_->statistics, &model,
                     &predictions, failure)) {
      return {};
    }
    std::vector<Eigen::VectorXd> estimates = EstimatesFrom(std::move(predictions), failure);
    if (failure->empty()) estimates.push_back(EstimateAfter(model.hessian, model.gradient));
    return estimates;
  }

  // By the derivatives here alone: NaN for parameters that are not told.
  std::vector<Eigen::VectorXd> EstimatesFrom(std::vector<StepPrediction> predictions, std::string* failure) {
    FitEvaluator evaluator(&problem_, options_.num_threads, EvaluationPurpose::kInterval);
    Eigen::VectorXd change;
    const bool ok = PullBackStep(summary_->coordinates, std::move(predictions), &evaluator, &summary_->statistics,
                                 &change, failure);
    summary_->statistics += evaluator.statistics();
    if (!ok) return {};
    const MarginalModel& marginal = *summary_->marginal;
    return {EstimateAfter(marginal.hessian, change.head(problem_.num_blocks()) +
                                                marginal.follow.transpose() * change.tail(problem_.num_unknowns()))};
  }

  Eigen::VectorXd Nowhere() const {
    return Eigen::VectorXd::Constant(problem_.num_blocks(), std::numeric_limits<double>::quiet_NaN());
  }

  // The minimum [p] of a quadratic cost that has these derivatives at the estimate.
  Eigen::VectorXd EstimateAfter(const Eigen::MatrixXd& hessian, const Eigen::VectorXd& gradient) const {
    Eigen::VectorXd moved = Nowhere();
    const Eigen::MatrixXd own = hessian(told_, told_);
    moved(told_) = summary_->coordinates(told_) - SymmetricFactor(own).SolveOne(gradient(told_));
    return moved;
  }

  // The larger of those that the derivatives here and there tell.
  std::vector<DiscretizationError> ErrorsFrom(const std::vector<Eigen::VectorXd>& at_half,
                                              const std::vector<Eigen::VectorXd>& at_double) const {
    std::vector<DiscretizationError> errors(static_cast<std::size_t>(problem_.num_blocks()));
    for (std::size_t way = 0; way < std::min(at_half.size(), at_double.size()); ++way) {
      for (Eigen::Index i = 0; i < problem_.num_blocks(); ++i) {
        const DiscretizationError error = ErrorOfStep(summary_->coordinates[i], at_half[way][i], at_double[way][i]);
        DiscretizationError* const largest = &errors[static_cast<std::size_t>(i)];
        if (!(error.error <= largest->error)) *largest = error;
      }
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
