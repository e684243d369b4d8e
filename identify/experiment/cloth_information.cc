#include "identify/experiment/cloth_information.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "identify/checks/step_error.h"
#include "identify/estimate/fit_summary.h"
#include "identify/estimate/interval_check.h"
#include "identify/experiment/information_sweep.h"
#include "identify/experiment/informed_start.h"
#include "identify/experiment/recorded_cloth.h"
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
  // `directions`: those of the sweep.
  Elimination(const InformationSweep& sweep, const FitProblem& problem, const Eigen::MatrixXd& directions)
      : sweep_(sweep), num_blocks_(problem.num_blocks()) {
    const UnknownStart* const start = problem.cost(0).model().unknown_start();
    if (start == nullptr) return;
    believed_ = start->prior_jacobian() * directions;
    if (start->handle_jacobian().rows() == 0) return;
    handles_ =
        start->handle_jacobian() * directions.middleRows(start->num_position_unknowns(), start->num_handle_unknowns());
  }

  Marginal Eliminate(const WeighedParts& weighed) const {
    Linearization all;
    all.jacobian = Eigen::MatrixXd(0, num_blocks_ + believed_.cols());
    for (const auto& [part, weight] : weighed.parts) Append(std::sqrt(weight) * sweep_.part(part), 0, &all.jacobian);
    Append(believed_, num_blocks_, &all.jacobian);
    if (weighed.handles > 1.0) Append(std::sqrt(weighed.handles - 1.0) * handles_, num_blocks_, &all.jacobian);
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

 private:
  static void Append(const Eigen::MatrixXd& rows, Eigen::Index first_column, Eigen::MatrixXd* all) {
    const Eigen::Index before = all->rows();
    all->conservativeResize(before + rows.rows(), Eigen::NoChange);
    all->bottomRows(rows.rows()).setZero();
    all->block(before, first_column, rows.rows(), rows.cols()) = rows;
  }

  const InformationSweep& sweep_;
  Eigen::Index num_blocks_;
  // Along the directions: what is believed of the start [u x c], and what of it was measured of the handles.
  Eigen::MatrixXd believed_, handles_;
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
std::vector<ModelError> ErrorsOfStep(const FitOptions& fit, const FitProblem& problem, const StepPrediction& half) {
  Eigen::MatrixXd points, forces;
  if (!half.failure.empty() ||
      !problem.cost(0).Predict(problem.StartCoordinates(), &points, /*velocities=*/nullptr, &forces)) {
    return NoModelErrors(problem);
  }
  return EstimateModelErrors(fit.loss, problem, {2.0 * half.points - points}, {2.0 * half.forces - forces});
}

// What a fit of a real recording errs by for the step, of q: its estimate is moved, and, as frames count by the error
// that the step makes in them, less sure than all frames alike would make it.
class StepEffects {
 public:
  // `problem`: counts by the errors of the step, as `weighed` does. `half`: what is predicted at half the step.
  StepEffects(const RecordedCloth& cloth, const FitOptions& fit, const FitProblem& problem, Marginal weighed,
              const StepPrediction& half)
      : cloth_(cloth),
        fit_(fit),
        problem_(problem),
        half_(half),
        truth_(problem.StartCoordinates()),
        marginal_(std::move(weighed)) {
    const Eigen::MatrixXd& rows = marginal_.parameters.jacobian;
    const int num_measurements = problem.cost(0).model().observation().num_residuals();
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
    const StepErrorEstimate moved = AddStepError({cloth_.planned}, fit_, problem_, &summary, {half_});
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
  const RecordedCloth& cloth_;
  const FitOptions& fit_;
  const FitProblem& problem_;
  const StepPrediction& half_;
  const Eigen::VectorXd truth_;
  const Marginal marginal_;
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

// One cloth, from its sweep to what it tells.
class ClothInformer {
 public:
  ClothInformer(const PlanOptions& options, const FitOptions& fit, RecordedCloth cloth)
      : options_(options), fit_(fit), cloth_(std::move(cloth)), problem_({cloth_.planned}, fit_) {
    information_.blocks = problem_.blocks();
    information_.coordinates = problem_.StartCoordinates().head(problem_.num_blocks());
    information_.num_measurements = problem_.cost(0).model().observation().num_residuals();
    const UnknownStart* const start = problem_.cost(0).model().unknown_start();
    if (start == nullptr) return;
    // Handles whose places are unknown move along offsets, which are zero at the truth.
    const auto offsets = start->HandleOffsetsAt(Eigen::VectorXd::Zero(start->size()));
    if (offsets) cloth_.rollout.handle_offsets = *offsets;
  }

  ClothInformation InformNominal() {
    const StepPrediction half =
        PredictAtStep(0.5, cloth_.planned, fit_, problem_, /*recording=*/0, problem_.StartCoordinates());
    problem_.SetModelErrors(ErrorsOfStep(fit_, problem_, half));
    const Eigen::MatrixXd all_directions = AllDirections();
    const InformationSweep sweep = SweepCloth(cloth_, problem_, all_directions, fit_.cancel);
    const Elimination elimination(sweep, problem_, all_directions);
    const Marginal marginal = Eliminate(sweep, elimination);
    if (const UnknownStart* start = problem_.cost(0).model().unknown_start()) {
      information_.start_directions =
          InformedDirections(sweep.part(RowPart::kPlanned).rightCols(all_directions.cols()), start->prior_jacobian());
    }
    const bool is_weighed = problem_.has_model_error();
    const StepEffects effects(cloth_, fit_, problem_,
                              is_weighed ? elimination.Eliminate({{{RowPart::kWeighed, 1.0}}}) : marginal, half);
    information_.rough = effects.FindRough();
    information_.step_errors = effects.FindErrors(
        JudgeRows(information_.blocks, information_.coordinates, information_.planned, information_.num_measurements));
    information_.map = MapInformation(cloth_, problem_, marginal.follow,
                                      Influence(information_.blocks, information_.planned), fit_.cancel);
    information_.recording = std::move(cloth_.planned);
    information_.nodes = std::move(cloth_.nodes);
    return std::move(information_);
  }

  // `nominal_directions`: of the start of the nominal cloth, which may have others, as it may move at first.
  ClothInformation InformOther(const Eigen::MatrixXd& nominal_directions) {
    const bool is_alike = nominal_directions.rows() == problem_.num_start_unknowns();
    const Eigen::MatrixXd directions = is_alike ? nominal_directions : AllDirections();
    const InformationSweep sweep = SweepCloth(cloth_, problem_, directions, fit_.cancel);
    Eliminate(sweep, Elimination(sweep, problem_, directions));
    return std::move(information_);
  }

 private:
  Eigen::MatrixXd AllDirections() const {
    return Eigen::MatrixXd::Identity(problem_.num_start_unknowns(), problem_.num_start_unknowns());
  }

  Marginal Eliminate(const InformationSweep& sweep, const Elimination& elimination) {
    const WeighedParts planned = PlannedParts(options_);
    Marginal marginal = elimination.Eliminate(planned);
    information_.planned = marginal.parameters.jacobian;
    ImproveCloth(options_, cloth_, sweep, elimination, &information_);
    if (problem_.num_start_unknowns() > 0) {
      information_.improved[ImprovementKind::kKnownStart] = elimination.WithKnownStart(planned);
    }
    return marginal;
  }

  const PlanOptions& options_;
  const FitOptions fit_;
  RecordedCloth cloth_;
  FitProblem problem_;
  ClothInformation information_;
};

}  // namespace

ClothInformation InformCloth(const PlanOptions& options, const Candidate& candidate, int cloth,
                             const ClothInformation& nominal) {
  ClothInformation information;
  try {
    const std::map<std::string, double> truth = DrawCloth(options, candidate, cloth);
    RecordedCloth recorded = RecordCloth(options, candidate, truth, /*looks_longer=*/cloth == 0);
    information.failure = recorded.failure;
    if (!information.failure.empty()) return information;
    FitOptions fit = candidate.fit;
    for (const auto& [name, value] : truth) fit.overrides.start[name] = value;
    ClothInformer informer(options, fit, std::move(recorded));
    return cloth == 0 ? informer.InformNominal() : informer.InformOther(nominal.start_directions);
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
