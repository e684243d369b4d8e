#include "identify/experiment/cloth_information.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "identify/checks/step_error.h"
#include "identify/experiment/information_sweep.h"
#include "identify/experiment/recorded_cloth.h"
#include "identify/fit/fit_summary.h"
#include "identify/fit/interval_check.h"
#include "identify/problem/evaluator.h"
#include "identify/problem/model_errors.h"
#include "identify/problem/problem.h"
#include "identify/uncertainty/marginal.h"
#include "identify/uncertainty/priors.h"
#include "sim/base/error.h"
#include "sim/matrix/dense.h"

namespace clothid {
namespace {

// What is measured of another recording, in parts of the sweep, each as if it were measured so many times.
struct WeighedParts {
  std::vector<std::pair<RowPart, double>> parts;
  double handles = 1.0;  // likewise of the places of handles that stand still
};

// Puts the parts together, and eliminates what is no parameter.
class Elimination {
 public:
  Elimination(const InformationSweep& sweep, const FitProblem& problem)
      : sweep_(sweep), num_blocks_(problem.num_blocks()), start_(problem.cost(0).model().unknown_start()) {}

  Marginal Eliminate(const WeighedParts& weighed) const {
    const Eigen::Index num_start = num_starts();
    Linearization all;
    all.jacobian = Eigen::MatrixXd(0, num_blocks_ + num_start);
    for (const auto& [part, weight] : weighed.parts) Append(std::sqrt(weight) * sweep_.part(part), 0, &all.jacobian);
    if (start_ != nullptr) {
      Append(start_->prior_jacobian(), num_blocks_, &all.jacobian);
      const Eigen::MatrixXd& handles = start_->handle_jacobian();
      if (handles.rows() > 0 && weighed.handles > 1.0) {
        Append(std::sqrt(weighed.handles - 1.0) * handles, num_blocks_ + start_->num_position_unknowns(),
               &all.jacobian);
      }
    }
    all.gradient = Eigen::VectorXd::Zero(all.jacobian.cols());
    return Marginalize(std::move(all), num_blocks_);
  }

  // As if the start were known.
  Eigen::MatrixXd WithKnownStart(const WeighedParts& weighed) const {
    Eigen::MatrixXd rows(0, num_blocks_);
    for (const auto& [part, weight] : weighed.parts) {
      Append(std::sqrt(weight) * sweep_.part(part).leftCols(num_blocks_), 0, &rows);
    }
    return rows;
  }

  Eigen::Index num_starts() const { return start_ == nullptr ? 0 : start_->size(); }

 private:
  static void Append(const Eigen::MatrixXd& rows, Eigen::Index first_column, Eigen::MatrixXd* all) {
    const Eigen::Index before = all->rows();
    all->conservativeResize(before + rows.rows(), Eigen::NoChange);
    all->bottomRows(rows.rows()).setZero();
    all->block(before, first_column, rows.rows(), rows.cols()) = rows;
  }

  const InformationSweep& sweep_;
  Eigen::Index num_blocks_;
  const UnknownStart* start_;
};

WeighedParts PlannedParts(const PlanOptions& options) {
  WeighedParts planned{{{RowPart::kPlanned, 1.0}}};
  if (options.has_forces) planned.parts.emplace_back(RowPart::kForces, 1.0);
  return planned;
}

void ImproveCloth(const PlanOptions& options, const RecordedCloth& cloth, const InformationSweep& sweep,
                  const Elimination& elimination, ClothInformation* information) {
  // Handles that stand still are measured by the points, those that move by what moves them.
  const bool stand_still = cloth.planned.scene.handles.path.times().size() <= 1;
  const auto improve = [&](ImprovementKind kind, WeighedParts weighed) {
    if (!stand_still) weighed.handles = 1.0;
    if (options.has_forces) weighed.parts.emplace_back(RowPart::kForces, 1.0);
    information->improved[kind] = elimination.Eliminate(weighed).parameters.jacobian;
  };
  const std::pair<RowPart, double> planned(RowPart::kPlanned, 1.0);
  improve(ImprovementKind::kTwiceFrames, {{planned, {RowPart::kBetween, 1.0}}, 2.0});
  improve(ImprovementKind::kHalfNoise, {{{RowPart::kPlanned, 4.0}}, 4.0});
  if (sweep.has_further) {
    improve(ImprovementKind::kMoreMarkers, {{planned, {RowPart::kFurther, 1.0}}});
  } else {
    improve(ImprovementKind::kMoreMarkers, {{{RowPart::kPlanned, 2.0}}});
  }
  if (!options.has_forces && sweep.has_forces) {
    improve(ImprovementKind::kGauge, {{planned, {RowPart::kForces, 1.0}}});
  }
  if (cloth.is_longer) {
    WeighedParts longer{{planned, {RowPart::kLater, 1.0}}};
    if (options.has_forces) longer.parts.emplace_back(RowPart::kLaterForces, 1.0);
    improve(ImprovementKind::kLonger, longer);
  }
}

// How far the model errs by its step: predictions are about twice as far from the real cloth, which has none, as from
// those at half the step. Found as a fit finds it.
std::vector<ModelError> ErrorsOfStep(const RecordedCloth& cloth, const FitOptions& fit, const FitProblem& problem) {
  const Eigen::VectorXd truth = problem.StartCoordinates();
  Eigen::MatrixXd points, forces;
  const StepPrediction half = PredictAtStep(0.5, cloth.planned, fit, problem, 0, truth);
  if (!half.failure.empty() || !problem.cost(0).Predict(truth, &points, nullptr, &forces)) {
    return NoModelErrors(problem);
  }
  return EstimateModelErrors(fit.loss, problem, {2.0 * half.points - points}, {2.0 * half.forces - forces});
}

// What a fit of a real recording errs by for the step, of q: its estimate is moved, and, as frames count by the error
// that the step makes in them, less sure than `of_noise` says.
class StepEffects {
 public:
  // `of_noise`: what the recording tells where all frames count the same.
  StepEffects(const RecordedCloth& cloth, const FitOptions& fit, const Marginal& of_noise, int num_measurements)
      : cloth_(cloth),
        fit_(fit),
        problem_({cloth.planned}, fit),
        truth_(problem_.StartCoordinates()),
        marginal_(of_noise) {
    problem_.SetModelErrors(ErrorsOfStep(cloth, fit, problem_));
    if (problem_.has_model_error()) Linearize();
    const Eigen::MatrixXd& rows = marginal_.parameters.jacobian;
    weighed_ = JudgeRows(problem_.blocks(), truth_.head(rows.cols()), rows, num_measurements);
  }

  // See `ClothRows`.
  std::vector<int> FindRough() const {
    FitEvaluator evaluator(&problem_, fit_.num_threads, EvaluationPurpose::kInterval);
    std::vector<int> rough;
    for (const DentCheck& check : CheckForDents(problem_.blocks(), truth_, /*cost=*/0.0, weighed_, &evaluator)) {
      if (check.is_dent()) rough.push_back(check.parameter);
    }
    return rough;
  }

  Eigen::VectorXd FindErrors(const Uncertainty& of_noise) const {
    const std::vector<ParameterBlock>& blocks = problem_.blocks();
    const Eigen::MatrixXd& rows = marginal_.parameters.jacobian;
    FitSummary summary;
    summary.coordinates = truth_;
    summary.uncertainty = weighed_;
    summary.marginal = {marginal_.follow, rows.transpose() * rows + PriorHessian(blocks)};
    const StepErrorEstimate moved = AddStepError({cloth_.planned}, fit_, problem_, &summary);
    Eigen::VectorXd errors = Eigen::VectorXd::Constant(rows.cols(), std::numeric_limits<double>::quiet_NaN());
    for (std::size_t i = 0; i < moved.errors.size(); ++i) {
      const auto index = static_cast<Eigen::Index>(i);
      const double std = weighed_.parameters[i].coordinate_std;
      const double more = std::sqrt(std::max(0.0, std * std - std::pow(of_noise.parameters[i].coordinate_std, 2)));
      errors[index] = std::hypot(moved.errors[i] / blocks[i].ValueDerivative(truth_[index]), more);
      // By what the step leaves, nothing tells it any more.
      if (std::isnan(std) && !std::isnan(of_noise.parameters[i].coordinate_std)) errors[index] = StdBefore(blocks[i]);
    }
    return errors;
  }

 private:
  void Linearize() {
    FitEvaluator evaluator(&problem_, fit_.num_threads, EvaluationPurpose::kInterval);
    const int num_start = problem_.num_start_unknowns();
    Linearization weighed;
    if (!evaluator.Linearize(truth_, Eigen::MatrixXd::Identity(num_start, num_start), &weighed)) {
      throw std::runtime_error(evaluator.last_failure());
    }
    marginal_ = Marginalize(std::move(weighed), problem_.num_blocks());
  }

  const RecordedCloth& cloth_;
  const FitOptions& fit_;
  FitProblem problem_;  // with the error of the step for that of the model
  const Eigen::VectorXd truth_;
  Marginal marginal_;
  Uncertainty weighed_;
};

// Column i: parameter i moves by 1, the others so as to undo the most, within what is believed of them.
Eigen::MatrixXd Influence(const std::vector<ParameterBlock>& blocks, const Eigen::MatrixXd& rows) {
  const auto size = static_cast<Eigen::Index>(blocks.size());
  Eigen::MatrixXd hessian = rows.transpose() * rows + PriorHessian(blocks);
  for (Eigen::Index i = 0; i < size; ++i) hessian(i, i) += std::pow(BelievedStd(blocks[i]), -2);
  const Eigen::MatrixXd inverse = SymmetricFactor(hessian).Solve(Eigen::MatrixXd::Identity(size, size));
  return inverse * inverse.diagonal().cwiseInverse().asDiagonal();
}

void Inform(const PlanOptions& options, const Candidate& candidate, RecordedCloth cloth,
            const std::map<std::string, double>& truth, bool is_nominal, ClothInformation* information) {
  FitOptions fit = candidate.fit;
  for (const auto& [name, value] : truth) fit.overrides.start[name] = value;
  const FitProblem problem({cloth.planned}, fit);
  information->blocks = problem.blocks();
  information->coordinates = problem.StartCoordinates().head(problem.num_blocks());
  const InformationSweep sweep = SweepCloth(cloth, problem, fit.cancel);
  const Elimination elimination(sweep, problem);
  const WeighedParts planned = PlannedParts(options);
  const Marginal marginal = elimination.Eliminate(planned);
  information->planned = marginal.parameters.jacobian;
  information->num_measurements = problem.cost(0).model().observation().num_residuals();
  ImproveCloth(options, cloth, sweep, elimination, information);
  if (elimination.num_starts() > 0) {
    information->improved[ImprovementKind::kKnownStart] = elimination.WithKnownStart(planned);
  }
  if (!is_nominal) return;
  const Uncertainty uncertainty =
      JudgeRows(information->blocks, information->coordinates, information->planned, information->num_measurements);
  const StepEffects effects(cloth, fit, marginal, information->num_measurements);
  information->rough = effects.FindRough();
  information->step_errors = effects.FindErrors(uncertainty);
  information->map =
      MapInformation(cloth, problem, marginal.follow, Influence(information->blocks, information->planned), fit.cancel);
  information->recording = std::move(cloth.planned);
  information->nodes = std::move(cloth.nodes);
}

}  // namespace

ClothInformation InformCloth(const PlanOptions& options, const Candidate& candidate, int cloth) {
  ClothInformation information;
  try {
    const std::map<std::string, double> truth = DrawCloth(options, candidate, cloth);
    RecordedCloth recorded = RecordCloth(options, candidate, truth, /*looks_longer=*/cloth == 0);
    information.failure = recorded.failure;
    if (information.failure.empty()) {
      Inform(options, candidate, std::move(recorded), truth, cloth == 0, &information);
    }
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::kUsage && cloth == 0) throw;
    information.failure = error.what();
  } catch (const std::runtime_error& error) {  // a system that is singular there
    information.failure = error.what();
  }
  return information;
}

double StdBefore(const ParameterBlock& block) { return block.prior.is_given() ? block.PriorStd() : BelievedStd(block); }

Uncertainty JudgeRows(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                      const Eigen::MatrixXd& rows, int num_measurements) {
  Linearization linearization;
  linearization.jacobian = rows;
  linearization.gradient = -PriorGradient(blocks, coordinates);  // a fit ends where nothing pulls any more
  linearization.num_measurements = num_measurements;
  return EstimateUncertainty(blocks, coordinates, linearization);
}

}  // namespace clothid
