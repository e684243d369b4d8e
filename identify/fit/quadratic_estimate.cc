#include "identify/fit/quadratic_estimate.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "identify/fit/estimate.h"
#include "identify/fit/fit_summary.h"
#include "identify/problem/evaluator.h"
#include "identify/problem/problem.h"
#include "identify/uncertainty/correlated_scores.h"
#include "identify/uncertainty/fitted_quadratic.h"
#include "identify/uncertainty/priors.h"
#include "sim/matrix/dense.h"

namespace clothid {
namespace {

// In resolutions of a parameter: 1, 10 and 30 %.
constexpr double kLeastDistance = 1e4;
constexpr double kManyDistance = 1e5;  // the least of so many parameters that the points cannot go farther out
constexpr double kMostDistance = 3e5;
constexpr double kDistanceStds = 2.0;
constexpr double kDistanceGrowth = 3.2;
constexpr double kLeastExplained = 0.9;
constexpr double kWellWithin = 0.5;  // of the distance
constexpr int kMostMoves = 3;        // at one distance
// A quadratic that is not that of a dent promises at so many distances a rise of which there is at least this share.
constexpr double kFarther = 3.0;
constexpr double kLeastShare = 1.0 / 3.0;
constexpr double kRoughnessAllowed = 3.0;

// Where the cost is evaluated, in distances from the centre, a column each, the most telling first. Not at the centre:
// a fit that has ended there, in a dent, has chosen it for its low cost.
Eigen::MatrixXd UnitPoints(Eigen::Index num) {
  std::vector<Eigen::VectorXd> points;
  for (Eigen::Index i = 0; i < num; ++i) {
    for (const double side : {1.0, -1.0}) points.push_back(side * Eigen::VectorXd::Unit(num, i));
  }
  if (num == 1) {
    for (const double share : {1.0, 2.0, -1.0, -2.0}) points.push_back(share / 3.0 * points[0]);
  }
  const auto add_pairs = [&](double first, double second) {
    for (Eigen::Index i = 0; i < num; ++i) {
      for (Eigen::Index j = i + 1; j < num; ++j) {
        points.push_back(first * Eigen::VectorXd::Unit(num, i) + second * Eigen::VectorXd::Unit(num, j));
      }
    }
  };
  add_pairs(1.0, 1.0);
  add_pairs(-1.0, -1.0);
  if (num == 2) {
    add_pairs(1.0, -1.0);
    add_pairs(-1.0, 1.0);
  }
  const auto count = std::min<Eigen::Index>(static_cast<Eigen::Index>(points.size()), kMostQuadraticEvaluations);
  Eigen::MatrixXd columns(num, count);
  for (Eigen::Index k = 0; k < count; ++k) columns.col(k) = points[static_cast<std::size_t>(k)];
  return columns;
}

// The parameters that a quadratic is fitted over: those with a standard deviation, off their bounds.
std::vector<Eigen::Index> MovedParameters(const FitProblem& problem, const Uncertainty& uncertainty) {
  std::vector<Eigen::Index> moved;
  for (Eigen::Index i = 0; i < problem.num_blocks(); ++i) {
    const ParameterUncertainty& parameter = uncertainty.parameters[i];
    if (!problem.blocks()[i].frozen && !parameter.at_bound && !std::isnan(parameter.coordinate_std)) moved.push_back(i);
  }
  return moved;
}

// Moves points about until a quadratic describes the cost at them and has its minimum well within.
class QuadraticSearch {
 public:
  QuadraticSearch(const FitOptions& options, const FitProblem& problem, const FitSummary& summary,
                  std::vector<Eigen::Index> moved, FitEvaluator* evaluator)
      : options_(options),
        problem_(problem),
        moved_(std::move(moved)),
        follow_(summary.marginal->follow),
        unit_points_(UnitPoints(static_cast<Eigen::Index>(moved_.size()))),
        evaluator_(evaluator),
        center_(summary.coordinates) {
    const bool has_few_sets = 2 * unit_points_.cols() > kMostQuadraticEvaluations;
    first_ = Resolutions(has_few_sets ? kManyDistance : kLeastDistance);
    for (Eigen::Index a = 0; a < first_.size(); ++a) {
      first_[a] = std::max(first_[a], kDistanceStds * summary.uncertainty->parameters[moved_[a]].independent_std);
    }
  }

  // The minimum [p + n + f]; nothing where no quadratic describes the cost.
  std::optional<Eigen::VectorXd> Run() {
    const Eigen::VectorXd farthest = Resolutions(kMostDistance);
    Eigen::VectorXd distance = first_.cwiseMin(farthest);
    while (true) {
      if (std::optional<Eigen::VectorXd> minimum = SearchAt(distance)) return minimum;
      if (is_over_ || (distance.array() >= farthest.array()).all()) return std::nullopt;
      distance = (kDistanceGrowth * distance).cwiseMin(farthest);
    }
  }

  const QuadraticEstimate& estimate() const { return estimate_; }
  // That was found; whether the estimate of before lies between its points.
  const FittedQuadratic& quadratic() const { return *quadratic_; }
  bool covers(const Eigen::VectorXd& coordinates) const {
    return ((coordinates - center_)(moved_).cwiseAbs().array() <= quadratic_->reach.array()).all();
  }
  // Its mean derivative of all residuals between the points [m x p], by least squares.
  Eigen::MatrixXd Slopes() const {
    const Eigen::MatrixXd offsets = points_.colwise() - points_.rowwise().mean();
    Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(residuals_.rows(), problem_.num_blocks());
    slopes(Eigen::all, moved_) =
        residuals_ * (SymmetricFactor(offsets * offsets.transpose()).Solve(offsets)).transpose();
    return slopes;
  }

 private:
  // So many resolutions of the parameters, at the centre.
  Eigen::VectorXd Resolutions(double count) const {
    Eigen::VectorXd lengths(static_cast<Eigen::Index>(moved_.size()));
    for (Eigen::Index a = 0; a < lengths.size(); ++a) {
      lengths[a] = count * problem_.blocks()[moved_[a]].Resolution(center_[moved_[a]]);
    }
    return lengths;
  }

  std::optional<Eigen::VectorXd> SearchAt(const Eigen::VectorXd& distance) {
    for (int move = 0; move <= kMostMoves; ++move) {
      if (!FitAbout(distance) || !quadratic_->is_convex() || quadratic_->explained < kLeastExplained) break;
      const Eigen::VectorXd step = quadratic_->Minimum();
      const double length = step.cwiseQuotient(distance).lpNorm<Eigen::Infinity>();
      if (!(length > kWellWithin)) {
        if (!HoldsFarther(distance)) break;
        estimate_.is_accepted = true;
        return Moved(step);
      }
      if (move == kMostMoves) break;
      center_ = Moved(step / std::max(1.0, length));
      ++estimate_.num_moves;
    }
    return std::nullopt;
  }

  // From the centre, within the bounds, everything else along.
  Eigen::VectorXd Moved(const Eigen::VectorXd& step) const {
    Eigen::VectorXd change = Eigen::VectorXd::Zero(problem_.num_blocks());
    for (std::size_t a = 0; a < moved_.size(); ++a) {
      const ParameterBlock& block = problem_.blocks()[moved_[a]];
      const double q = center_[moved_[a]];
      change[moved_[a]] = std::clamp(q + step[static_cast<Eigen::Index>(a)], block.ToCoordinate(block.lower_bound),
                                     block.ToCoordinate(block.upper_bound)) -
                          q;
    }
    Eigen::VectorXd point = center_;
    point.head(change.size()) += change;
    point.tail(follow_.rows()) += follow_ * change;
    return point;
  }

  // The quadratic about the centre. False where there is none, or the evaluations are used up.
  bool FitAbout(const Eigen::VectorXd& distance) {
    quadratic_.reset();
    is_over_ = estimate_.num_evaluations + unit_points_.cols() > kMostQuadraticEvaluations;
    if (is_over_) return false;
    Eigen::VectorXd costs(unit_points_.cols());
    points_.resize(unit_points_.rows(), unit_points_.cols());
    Eigen::Index count = 0;
    for (Eigen::Index k = 0; k < unit_points_.cols(); ++k) {
      is_over_ = options_.is_cancelled();
      if (is_over_) return false;
      const Eigen::VectorXd point = Moved(unit_points_.col(k).cwiseProduct(distance));
      ++estimate_.num_evaluations;
      evaluator_->SupersedeBest();
      if (!evaluator_->Evaluate(point, FitEvaluator::Derivative::kNone, &costs[count], /*gradient=*/nullptr)) continue;
      const Eigen::VectorXd residuals = AllResiduals(problem_, evaluator_->best().predicted, evaluator_->best().forces);
      residuals_.conservativeResize(residuals.size(), unit_points_.cols());
      residuals_.col(count) = residuals;
      points_.col(count++) = (point - center_)(moved_);
    }
    points_.conservativeResize(Eigen::NoChange, count);
    residuals_.conservativeResize(Eigen::NoChange, count);
    quadratic_ = FitQuadratic(points_, costs.head(count));
    if (quadratic_) Keep(distance, static_cast<int>(count));
    return quadratic_.has_value();
  }

  // Whether the cost goes on to rise along every parameter, as far as points may go and while evaluations last. A few
  // points in a dent of a rough cost may lie on a fine quadratic, too; farther out there is nothing of it.
  bool HoldsFarther(const Eigen::VectorXd& distance) {
    const Eigen::VectorXd farther = (kFarther * distance).cwiseMin(Resolutions(kMostDistance));
    for (Eigen::Index a = 0; a < farther.size(); ++a) {
      if (farther[a] < 2.0 * distance[a]) continue;
      double rise = 0.0, promised = 0.0;
      for (const double side : {1.0, -1.0}) {
        if (estimate_.num_evaluations == kMostQuadraticEvaluations) return true;
        const Eigen::VectorXd point = Moved(side * farther[a] * Eigen::VectorXd::Unit(farther.size(), a));
        double cost = 0.0;
        ++estimate_.num_evaluations;
        if (!evaluator_->Evaluate(point, FitEvaluator::Derivative::kNone, &cost, /*gradient=*/nullptr)) continue;
        rise += cost - quadratic_->constant;
        promised += quadratic_->Value((point - center_)(moved_)) - quadratic_->constant;
      }
      if (rise < kLeastShare * promised) return false;
    }
    return true;
  }

  // What is told of the last quadratic, or of the one that has explained the most.
  void Keep(const Eigen::VectorXd& distance, int num_points) {
    const bool describes = quadratic_->is_convex() && quadratic_->explained >= kLeastExplained;
    if (!describes && quadratic_->explained <= estimate_.explained) return;
    estimate_.distance = Eigen::VectorXd::Zero(problem_.num_blocks());
    estimate_.distance(moved_) = distance;
    estimate_.explained = quadratic_->explained;
    estimate_.roughness = quadratic_->roughness;
    estimate_.num_points = num_points;
  }

  const FitOptions& options_;
  const FitProblem& problem_;
  const std::vector<Eigen::Index> moved_;  // [m] blocks
  const Eigen::MatrixXd follow_;           // [(n + f) x p]
  const Eigen::MatrixXd unit_points_;      // [m x k]
  FitEvaluator* evaluator_;
  Eigen::VectorXd center_;     // [p + n + f]
  Eigen::VectorXd first_;      // [m] distance
  Eigen::MatrixXd points_;     // [m x k] about the centre, of the last quadratic
  Eigen::MatrixXd residuals_;  // [rows x k] of all recordings there
  std::optional<FittedQuadratic> quadratic_;
  bool is_over_ = false;  // evaluations are used up, or the fit is cancelled
  QuadraticEstimate estimate_;
};

// What `linearization` says of the parameters beside `moved`, and of these what the quadratic does: rows whose J^T J is
// its second derivative without what is believed, and a gradient that makes that of the whole cost zero. The others are
// judged by what the moved ones cannot make up for.
void TakeQuadratic(const FitProblem& problem, const Eigen::VectorXd& coordinates,
                   const std::vector<Eigen::Index>& moved, const Eigen::MatrixXd& hessian,
                   Linearization* linearization) {
  const Eigen::MatrixXd before = std::move(linearization->jacobian);
  const auto size = static_cast<Eigen::Index>(moved.size());
  const Eigen::MatrixXd own = before(Eigen::all, moved);
  Eigen::MatrixXd& jacobian = linearization->jacobian;
  jacobian = Eigen::MatrixXd::Zero(size + before.rows(), before.cols());
  for (Eigen::Index i = 0; i < before.cols(); ++i) {
    if (std::find(moved.begin(), moved.end(), i) != moved.end()) continue;
    jacobian.col(i).tail(before.rows()) = LeastSquaresResiduals(own, before.col(i)).value_or(before.col(i));
  }
  jacobian.topRows(size)(Eigen::all, moved) = TransposedRoot(hessian - PriorHessian(problem.blocks())(moved, moved));
  linearization->gradient(moved) = -PriorGradient(problem.blocks(), coordinates)(moved);
}

// As if the point that was evaluated last were the end of the fit.
void MoveEstimate(const FitOptions& options, const FitProblem& problem, const FitEvaluator& evaluator,
                  FitSummary* summary) {
  const std::vector<FittedParameter> parameters = std::exchange(summary->parameters, {});
  const PredictionError start_error = summary->start_error;
  std::vector<Eigen::MatrixXd> start_predicted = std::move(summary->start_predicted);
  const std::optional<FieldResult> fields = std::exchange(summary->fields, std::nullopt);
  FillEstimate(problem, evaluator, summary);
  for (std::size_t i = 0; i < parameters.size(); ++i) summary->parameters[i].start = parameters[i].start;
  summary->start_error = start_error;
  summary->start_predicted = std::move(start_predicted);
  for (std::size_t f = 0; fields && f < fields->fields.size(); ++f) {
    FittedField& field = summary->fields->fields[f];
    const FittedField& before = fields->fields[f];
    field.log_std = before.log_std;
    field.deviation_std = before.deviation_std;
    field.prior_deviation_std = before.prior_deviation_std;
  }
  if (fields) summary->fields->num_determined = fields->num_determined;
  FitIteration row;
  row.iteration = summary->num_iterations() + 1;
  row.seconds = summary->total_seconds;
  row.cost = summary->cost;
  row.values = summary->values();
  row.gradient_norm = std::numeric_limits<double>::quiet_NaN();
  row.rollouts = summary->statistics.rollouts;
  summary->iterations.push_back(row);
  if (options.on_iteration) options.on_iteration(row);
  summary->message = "at the minimum of a quadratic over a rough cost";
}

bool IsRough(const FitSummary& summary) {
  const std::vector<ParameterUncertainty>& parameters = summary.uncertainty->parameters;
  return std::any_of(parameters.begin(), parameters.end(),
                     [](const ParameterUncertainty& parameter) { return parameter.stalled; }) ||
         std::any_of(summary.dents.begin(), summary.dents.end(), [](const DentCheck& dent) { return dent.is_dent(); });
}

// The minimum is no surer than the roughness about the quadratic leaves it, of which few points say how large it is.
void AddRoughness(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                  const std::vector<Eigen::Index>& moved, const FittedQuadratic& quadratic, Uncertainty* uncertainty) {
  const Eigen::MatrixXd covariance = quadratic.MinimumCovariance();
  const double few = Student95(std::max(2, quadratic.num_spare)) / kNormal95;
  for (std::size_t a = 0; a < moved.size(); ++a) {
    ParameterUncertainty& parameter = uncertainty->parameters[moved[a]];
    if (std::isnan(parameter.coordinate_std)) continue;
    const ParameterBlock& block = blocks[moved[a]];
    const double q = coordinates[moved[a]];
    const auto own = static_cast<Eigen::Index>(a);
    parameter.coordinate_std = std::hypot(parameter.coordinate_std, few * std::sqrt(covariance(own, own)));
    parameter.std = block.ValueDerivative(q) * parameter.coordinate_std;
    SetInterval(block, q, uncertainty->quantile95 * parameter.coordinate_std, &parameter);
  }
  JudgeIntervals(blocks, uncertainty);
}

// Makes `minimum` the estimate. False where its cost is too high, or there is no derivative. That of the rollout there
// sees nothing but kinks: where frames are correlated, they are weighed by the mean derivative between the points.
bool TakeMinimum(const FitOptions& options, const FitProblem& problem, const Eigen::VectorXd& minimum,
                 const QuadraticSearch& search, const std::vector<Eigen::Index>& moved, FitEvaluator* evaluator,
                 FitSummary* summary) {
  const FittedQuadratic& quadratic = search.quadratic();
  const double highest = search.covers(summary->coordinates) ? std::numeric_limits<double>::infinity()
                                                             : summary->cost + kRoughnessAllowed * quadratic.roughness;
  double cost = 0.0;
  Linearization linearization;
  evaluator->SupersedeBest();
  if (!evaluator->Evaluate(minimum, FitEvaluator::Derivative::kNone, &cost, /*gradient=*/nullptr) || cost > highest ||
      !LinearizeAlong(problem, minimum, summary->marginal->follow, evaluator, &linearization)) {
    return false;
  }
  MoveEstimate(options, problem, *evaluator, summary);
  linearization.sigma_is_known |= problem.has_model_error();
  linearization.autocorrelation = WeightedAutocorrelation(options.loss, problem, *summary);
  linearization.frame_scores = FrameScores(options.loss, problem, *summary, search.Slopes());
  const Eigen::VectorXd blocks = minimum.head(problem.num_blocks());
  TakeQuadratic(problem, blocks, moved, quadratic.hessian, &linearization);
  summary->uncertainty = EstimateUncertainty(problem.blocks(), blocks, linearization);
  AddRoughness(problem.blocks(), blocks, moved, quadratic, &*summary->uncertainty);
  summary->marginal->hessian =
      linearization.jacobian.transpose() * linearization.jacobian + PriorHessian(problem.blocks());
  summary->interval_check.reset();
  // Those of parameters that are not visible are as true here; the directions are others.
  std::vector<BoundCheck>& bounds = summary->bound_checks;
  bounds.erase(
      std::remove_if(bounds.begin(), bounds.end(), [](const BoundCheck& check) { return check.parameter < 0; }),
      bounds.end());
  for (BoundCheck& check : bounds) check.better.resize(0);
  summary->dents.clear();
  return true;
}

}  // namespace

void EstimateFromQuadratic(const FitOptions& options, const FitProblem& problem, FitSummary* summary) {
  summary->quadratic.reset();
  if (summary->status != FitStatus::kConverged || !summary->uncertainty || !summary->marginal || !IsRough(*summary)) {
    return;
  }
  const std::vector<Eigen::Index> moved = MovedParameters(problem, *summary->uncertainty);
  if (moved.empty() || static_cast<int>(moved.size()) > kMostQuadraticParameters) return;
  FitEvaluator evaluator(&problem, options.num_threads, EvaluationPurpose::kInterval);
  QuadraticSearch search(options, problem, *summary, moved, &evaluator);
  const std::optional<Eigen::VectorXd> minimum = search.Run();
  if (!options.is_cancelled()) {
    summary->quadratic = search.estimate();
    if (minimum) {
      summary->quadratic->is_accepted = TakeMinimum(options, problem, *minimum, search, moved, &evaluator, summary);
    }
  }
  summary->statistics += evaluator.statistics();
  summary->total_seconds += evaluator.seconds();
}

}  // namespace clothid
