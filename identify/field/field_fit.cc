#include "identify/field/field_fit.h"

#include <ceres/first_order_function.h>
#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "identify/field/field_model.h"
#include "identify/field/field_newton.h"
#include "identify/field/field_posterior.h"
#include "sim/base/error.h"
#include "sim/base/phase_seconds.h"

namespace clothid {
namespace {

constexpr int kPosteriorModes = 16;       // a side, of the curvature that gives standard deviations
constexpr double kLargestLbfgsLog = 9.2;  // a factor of 1e4 from the start
constexpr double kSmallChange = 1e-4;     // of the cost, relative

// Cost and gradient for L-BFGS, which must not step over bounds: a point beyond them fails.
class FieldFunction : public ceres::FirstOrderFunction {
 public:
  FieldFunction(double weight, FieldModel* model, FieldPoint* point) : weight_(weight), model_(model), point_(point) {}

  bool Evaluate(const double* u, double* cost, double* gradient) const override {
    const Eigen::VectorXd unknowns = Eigen::Map<const Eigen::VectorXd>(u, model_->size());
    for (int i = 0; i < model_->num_scalars(); ++i) {
      const ParameterBlock& block = model_->blocks()[model_->scalars()[i]];
      if (unknowns[i] < block.ToCoordinate(block.lower_bound) || unknowns[i] > block.ToCoordinate(block.upper_bound))
        return false;
    }
    const Eigen::VectorXd theta = unknowns.tail(model_->num_field_unknowns());
    if (!(theta.cwiseAbs().maxCoeff() <= kLargestLbfgsLog)) return false;
    const bool is_there = point_->unknowns.size() > 0 && point_->unknowns == unknowns;
    if (!is_there && !model_->MoveTo(unknowns, Precision::kFull, point_)) return false;
    *cost = point_->data_cost + 0.5 * weight_ * (model_->prior_root() * theta).squaredNorm();
    if (gradient == nullptr) return true;
    Eigen::Map<Eigen::VectorXd> out(gradient, model_->size());
    out = model_->DataGradient(*point_);
    out.tail(theta.size()) += weight_ * (model_->prior_matrix() * theta);
    return true;
  }
  int NumParameters() const override { return model_->size(); }

 private:
  double weight_;
  FieldModel* model_;
  FieldPoint* point_;
};

class LbfgsTeller : public ceres::IterationCallback {
 public:
  LbfgsTeller(const FieldFitOptions& options, const FieldModel* model, const FieldPoint* point)
      : options_(options), model_(model), point_(point) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (options_.on_iteration) {
      options_.on_iteration({summary.iteration, summary.cumulative_time_in_seconds, summary.cost, point_->data_cost,
                             options_.weight, model_->BlockCoordinates(point_->unknowns), model_->counts().rollouts,
                             0});
    }
    return options_.fit.is_cancelled() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }

 private:
  const FieldFitOptions& options_;
  const FieldModel* model_;
  const FieldPoint* point_;
};

Precision FirstPrecision(const FieldFitOptions& options) {
  const bool is_loose =
      options.fit.precision == FitPrecision::kAdaptive && options.fit.method == FitMethod::kLevenbergMarquardt;
  return is_loose ? Precision::kLoose : Precision::kFull;
}

// From the point that the model is at.
bool RunLbfgs(const FieldFitOptions& options, FieldModel* model, FieldPoint* point, FieldResult* result) {
  Eigen::VectorXd unknowns = model->Start();
  const ceres::GradientProblem problem(new FieldFunction(options.weight, model, point));
  ceres::GradientProblemSolver::Options solver;
  solver.line_search_direction_type = ceres::LBFGS;
  solver.use_approximate_eigenvalue_bfgs_scaling = true;
  solver.max_num_iterations = options.fit.max_iterations;
  solver.function_tolerance = kSmallChange;
  solver.logging_type = ceres::SILENT;
  LbfgsTeller teller(options, model, point);
  solver.callbacks = {&teller};
  ceres::GradientProblemSolver::Summary summary;
  ceres::Solve(solver, problem, unknowns.data(), &summary);
  result->num_iterations = static_cast<int>(summary.iterations.size()) - 1;
  result->has_converged = summary.termination_type == ceres::CONVERGENCE;
  result->message = summary.termination_type == ceres::NO_CONVERGENCE ? "stopped at max_iterations" : summary.message;
  result->weight = options.weight;
  if (summary.termination_type == ceres::USER_FAILURE || summary.termination_type == ceres::FAILURE) return false;
  return point->unknowns == unknowns || model->MoveTo(unknowns, Precision::kFull, point);
}

}  // namespace

FieldFit FitFields(const std::vector<RecordedMotion>& motions, const std::vector<ParameterBlock>& blocks,
                   const std::vector<FieldRequest>& requests, const FieldFitOptions& options) {
  const double start = SteadySeconds();
  const bool is_lbfgs = options.fit.method == FitMethod::kLbfgs;
  if (is_lbfgs && !(options.weight > 0.0)) {
    throw Error(ErrorKind::kUsage, "--field_weight: expected with --method lbfgs, which does not choose it");
  }
  FieldModel model(motions, blocks, requests, options.fit);
  FieldFit fit;
  FieldResult& result = fit.result;
  FieldPoint point;
  try {
    if (!model.MoveTo(model.Start(), FirstPrecision(options), &point)) throw std::runtime_error(model.failure());
    result.start_cost = point.data_cost;
    for (int r = 0; r < model.num_recordings(); ++r) {
      fit.start_predicted.push_back(point.recordings[r].predicted);
      fit.start_error += model.observation(r).Compare(fit.start_predicted.back(), point.recordings[r].forces.predicted);
    }
    result.ok =
        is_lbfgs ? RunLbfgs(options, &model, &point, &result) : RunFieldNewton(options, &model, &point, &result);
    result.weight_is_chosen = !(options.weight > 0.0);
    result.cost = point.data_cost;
    if (result.ok) {
      for (std::size_t k = 0; k < requests.size(); ++k) {
        FittedField& field = result.fields.emplace_back();
        field.request = requests[k];
        field.values = model.ValuesOf(static_cast<int>(k), point.unknowns);
        field.start = model.ValuesOf(static_cast<int>(k), model.Start())(0, 0);
      }
      if (options.estimate_deviations && !options.fit.is_cancelled()) {
        const FieldCurvature curvature(kPosteriorModes, &model, &point);
        curvature.AddDeviations(point.data_cost, result.weight, &result.fields);
        result.num_determined = curvature.NumDetermined(result.weight);
        if (!blocks.empty()) fit.marginal = curvature.Marginal(result.weight, &point);
      }
      fit.coordinates = model.BlockCoordinates(point.unknowns);
    }
  } catch (const std::runtime_error& error) {
    result.ok = false;
    result.message = error.what();
  }
  result.num_measurements = model.num_measurements();
  result.num_rollouts = model.counts().rollouts;
  result.num_sweeps = model.counts().sweeps;
  result.seconds = SteadySeconds() - start;
  return fit;
}

}  // namespace clothid
