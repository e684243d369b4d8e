#include "identify/estimate/interval_check.h"

#include <algorithm>
#include <cmath>

#include "identify/problem/evaluator.h"
#include "identify/problem/gauss_newton.h"
#include "identify/problem/problem.h"
#include "identify/uncertainty/priors.h"
#include "sim/matrix/dense.h"

namespace clothid {
namespace {

// Costs that differ by less than this, in s^2 and relative to themselves, differ by the rounding of rollouts.
constexpr double kRiseRounding = 1e-3;
constexpr double kCostRounding = 1e-7;
// Beyond the ends only what is lower by more than a rough cost varies is worth another fit.
constexpr double kClearlyLower = 0.2;

// Whether q lies within the bounds.
bool IsInside(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates) {
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const double q = coordinates[static_cast<Eigen::Index>(i)];
    if (!blocks[i].frozen &&
        (q < blocks[i].ToCoordinate(blocks[i].lower_bound) || q > blocks[i].ToCoordinate(blocks[i].upper_bound))) {
      return false;
    }
  }
  return true;
}

// The parameter of the widest interval, -1 where there is none.
int WidestInterval(const std::vector<ParameterBlock>& blocks, const Uncertainty& uncertainty) {
  int widest = -1;
  double width = 0.0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const double relative = uncertainty.parameters[i].coordinate_std / blocks[i].CoordinateRange();
    if (!(relative > width)) continue;
    width = relative;
    widest = static_cast<int>(i);
  }
  return widest;
}

// The least costly way to move a parameter by its interval [p]. What it costs is what the covariance of independent
// residuals says, also where the interval is wider than theirs.
Eigen::VectorXd LeastCostlyStep(const std::vector<ParameterBlock>& blocks, const Uncertainty& uncertainty,
                                int parameter) {
  Eigen::VectorXd step = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(uncertainty.parameters.size()));
  const ParameterUncertainty& moved = uncertainty.parameters[parameter];
  for (Eigen::Index i = 0; i < step.size(); ++i) {
    const ParameterUncertainty& other = uncertainty.parameters[i];
    if (std::isnan(uncertainty.correlation(i, parameter))) continue;
    if (uncertainty.is_widened || HasPriors(blocks)) {
      const double share = uncertainty.independent_correlation(i, parameter) * other.independent_std *
                           (moved.cost_scale / other.cost_scale);
      step[i] = uncertainty.quantile95 * moved.coordinate_std * share / moved.independent_std;
    } else {
      step[i] = kNormal95 * uncertainty.correlation(i, parameter) * other.coordinate_std;
    }
  }
  return step;
}

// By one forward sweep, along with its rollout.
bool ModelAt(const FitProblem& problem, const Eigen::VectorXd& coordinates, FitEvaluator* evaluator,
             QuadraticModel* model) {
  Linearization linearization;
  if (!evaluator->Linearize(coordinates, {}, &linearization)) return false;
  const std::vector<ParameterBlock>& blocks = problem.blocks();
  model->coordinates = coordinates;
  model->cost = 0.5 * linearization.squared_residual + PriorCost(blocks, coordinates);
  model->gradient = linearization.gradient + PriorGradient(blocks, coordinates);
  model->hessian = linearization.jacobian.transpose() * linearization.jacobian + PriorHessian(blocks);
  return true;
}

// Of costs at the ends of an interval: s w.
double RiseScale(const Uncertainty& uncertainty, int parameter) {
  const ParameterUncertainty& moved = uncertainty.parameters[parameter];
  return moved.cost_scale * moved.widening;
}

constexpr double kStepResolutions = 1e4;  // 1 % of what is logarithmic
constexpr double kNarrow = 1.0 / 3.0;
constexpr double kDentRise = 0.1;

// (C^-1)_ii of all parameters that have a standard deviation [p]; 0 of the others.
Eigen::VectorXd Precisions(const Uncertainty& uncertainty) {
  const Eigen::MatrixXd& correlation = uncertainty.independent_correlation;
  const Eigen::Index num = correlation.rows();
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(num, num);
  const auto std_of = [&](Eigen::Index i) { return uncertainty.parameters[i].independent_std; };
  for (Eigen::Index i = 0; i < num; ++i) {
    for (Eigen::Index k = 0; k < num; ++k) {
      if (std::isnan(std_of(i)) || std::isnan(std_of(k)) || std::isnan(correlation(i, k))) continue;
      covariance(i, k) = correlation(i, k) * std_of(i) * std_of(k);
    }
  }
  Eigen::VectorXd precisions = SymmetricFactor(covariance).Inverse().diagonal();
  for (Eigen::Index i = 0; i < num; ++i) {
    if (std::isnan(std_of(i))) precisions[i] = 0.0;
  }
  return precisions;
}

}  // namespace

bool IntervalCheck::is_quadratic() const {
  const auto is_near = [](double rise) { return rise > 0.5 * kChiSquare95 && rise < 2.0 * kChiSquare95; };
  return is_near(rise_below) && is_near(rise_above);
}

double IntervalCheck::lowest_rise() const { return std::fmin(std::fmin(rise_below, rise_above), rise_beyond); }

std::optional<IntervalCheck> CheckInterval(const std::vector<ParameterBlock>& blocks,
                                           const Eigen::VectorXd& coordinates, double cost,
                                           const Uncertainty& uncertainty, const Eigen::MatrixXd& follow,
                                           FitEvaluator* evaluator) {
  IntervalCheck check;
  check.parameter = WidestInterval(blocks, uncertainty);
  if (check.parameter < 0) return std::nullopt;
  const double std = uncertainty.parameters[check.parameter].coordinate_std;
  if (IsResolution(blocks[check.parameter], coordinates[check.parameter], std)) return std::nullopt;
  const Eigen::VectorXd own_step = LeastCostlyStep(blocks, uncertainty, check.parameter);
  Eigen::VectorXd step(coordinates.size());
  step << own_step, follow * own_step;
  const double scale = RiseScale(uncertainty, check.parameter);
  double lowest = (1.0 - kCostRounding) * cost;
  const auto rise_at = [&](const Eigen::VectorXd& end) {
    double end_cost = 0.0;
    if (!IsInside(blocks, end) ||
        !evaluator->Evaluate(end, FitEvaluator::Derivative::kNone, &end_cost, /*gradient=*/nullptr)) {
      return std::numeric_limits<double>::quiet_NaN();
    }
    const double rise = 2.0 * (end_cost - cost) / (scale * scale);
    if (end_cost < lowest && rise < -kRiseRounding) {
      lowest = end_cost;
      check.better = end;
    }
    return rise;
  };
  check.rise_below = rise_at(coordinates - step);
  check.rise_above = rise_at(coordinates + step);
  check.step = step;
  return check;
}

void LookBeyond(const FitProblem& problem, const Eigen::VectorXd& coordinates, double cost,
                const Uncertainty& uncertainty, FitEvaluator* evaluator, IntervalCheck* check) {
  if (check->better.size() > 0 || problem.num_unknowns() > 0) return;
  const double scale = RiseScale(uncertainty, check->parameter);
  double lowest = -kClearlyLower;
  for (const double side : {-1.0, 1.0}) {
    const Eigen::VectorXd end = coordinates + side * check->step;
    QuadraticModel model;
    if (!IsInside(problem.blocks(), end) || !ModelAt(problem, end, evaluator, &model)) continue;
    const Eigen::VectorXd next = NextPoint(problem, model, /*length=*/std::numeric_limits<double>::infinity());
    const Eigen::VectorXd moved = next - end;
    const double promised = model.cost + model.gradient.dot(moved) + 0.5 * moved.dot(model.hessian * moved);
    double next_cost = 0.0;
    if (!(2.0 * (promised - cost) / (scale * scale) < lowest) ||
        !evaluator->Evaluate(next, FitEvaluator::Derivative::kNone, &next_cost, /*gradient=*/nullptr)) {
      continue;
    }
    const double rise = 2.0 * (next_cost - cost) / (scale * scale);
    check->rise_beyond = std::fmin(check->rise_beyond, rise);
    if (!(rise < lowest)) continue;
    lowest = rise;
    check->better = next;
  }
}

double BoundCheck::change() const { return std::sqrt(std::fmax(0.0, std::fmax(rise_below, rise_above))); }

namespace {

// Entries of a direction below this share of its largest do not end it at their bounds.
constexpr double kNegligibleShare = 0.01;

bool IsBelieved(const std::vector<ParameterBlock>& blocks, int index) {
  return blocks[index].prior.is_given() || IsKnot(blocks, index);
}

// How far `direction` [p] leads from `coordinates` until the first parameter meets a bound.
double DistanceToBound(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                       const Eigen::VectorXd& direction) {
  double distance = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < direction.size(); ++i) {
    if (!(std::abs(direction[i]) > kNegligibleShare)) continue;
    const double bound = blocks[i].ToCoordinate(direction[i] < 0.0 ? blocks[i].lower_bound : blocks[i].upper_bound);
    distance = std::min(distance, std::max(0.0, (bound - coordinates[i]) / direction[i]));
  }
  return distance;
}

// `step` [p] from `coordinates`, within the bounds, everything else along.
Eigen::VectorXd MovedWithin(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                            const Eigen::VectorXd& step, const Eigen::MatrixXd& follow) {
  Eigen::VectorXd moved = coordinates;
  for (Eigen::Index i = 0; i < step.size(); ++i) {
    const ParameterBlock& block = blocks[i];
    if (step[i] == 0.0) continue;
    moved[i] =
        std::clamp(moved[i] + step[i], block.ToCoordinate(block.lower_bound), block.ToCoordinate(block.upper_bound));
  }
  moved.tail(follow.rows()) += follow * (moved - coordinates).head(step.size());
  return moved;
}

// Fills the rises and the better end of `check`, whose parameters move along `direction` [p].
void TryEnds(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates, double cost, double scale,
             const Eigen::VectorXd& direction, const Eigen::MatrixXd& follow, FitEvaluator* evaluator,
             BoundCheck* check) {
  double lowest = -kClearlyLower;
  for (const double side : {-1.0, 1.0}) {
    const double distance = DistanceToBound(blocks, coordinates, side * direction);
    if (distance == 0.0 || !std::isfinite(distance)) continue;
    const Eigen::VectorXd end = MovedWithin(blocks, coordinates, side * distance * direction, follow);
    double& rise = side < 0.0 ? check->rise_below : check->rise_above;
    double end_cost = std::numeric_limits<double>::quiet_NaN();
    evaluator->Evaluate(end, FitEvaluator::Derivative::kNone, &end_cost, /*gradient=*/nullptr);
    rise = 2.0 * (end_cost - cost) / (scale * scale);
    if (!(rise < lowest)) continue;
    lowest = rise;
    check->better = end;
  }
}

}  // namespace

std::vector<BoundCheck> CheckBounds(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                                    double cost, const Uncertainty& uncertainty, const Eigen::MatrixXd& jacobian,
                                    const Eigen::MatrixXd& follow, FitEvaluator* evaluator) {
  std::vector<BoundCheck> checks;
  const double scale = std::max(1.0, uncertainty.residual_scale);
  const auto num = static_cast<Eigen::Index>(blocks.size());
  std::vector<bool> is_tried(blocks.size(), false);
  for (Eigen::Index i = 0; i < num; ++i) {
    is_tried[i] = !blocks[i].frozen && !uncertainty.parameters[i].visible && !IsBelieved(blocks, static_cast<int>(i)) &&
                  jacobian.col(i).norm() * blocks[i].CoordinateRange() <= kVisibleChange * scale;
    if (!is_tried[i]) continue;
    BoundCheck& check = checks.emplace_back();
    check.parameter = static_cast<int>(i);
    TryEnds(blocks, coordinates, cost, scale, Eigen::VectorXd::Unit(num, i), follow, evaluator, &check);
  }
  for (std::size_t k = 0; k < uncertainty.hidden_directions.size(); ++k) {
    const Eigen::VectorXd& direction = uncertainty.hidden_directions[k].coordinates;
    bool has_others = false, is_believed = false;
    for (Eigen::Index i = 0; i < num; ++i) {
      if (!(std::abs(direction[i]) > kNegligibleShare)) continue;
      has_others = has_others || !is_tried[i];
      is_believed = is_believed || IsBelieved(blocks, static_cast<int>(i));
    }
    if (!has_others || is_believed) continue;
    BoundCheck& check = checks.emplace_back();
    check.direction = static_cast<int>(k);
    TryEnds(blocks, coordinates, cost, scale, direction, follow, evaluator, &check);
  }
  return checks;
}

// Derivatives through a rollout that forgets where it comes from grow without bound, until not even the sign of what
// they promise is left.
bool DentCheck::is_dent() const {
  return !(expected_rise > 0.0) || std::fmin(rise_below, rise_above) < kDentRise * expected_rise;
}

std::vector<DentCheck> CheckForDents(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                                     double cost, const Uncertainty& uncertainty, FitEvaluator* evaluator) {
  std::vector<DentCheck> checks;
  const Eigen::VectorXd precisions = Precisions(uncertainty);
  const double scale = uncertainty.residual_scale;
  for (Eigen::Index i = 0; i < precisions.size(); ++i) {
    const double step = kStepResolutions * blocks[i].Resolution(coordinates[i]);
    if (blocks[i].frozen || !(uncertainty.parameters[i].half_width95 < kNarrow * step)) continue;
    const auto rise_at = [&](double moved) {
      Eigen::VectorXd end = coordinates;
      end[i] += moved;
      double end_cost = 0.0;
      if (!IsInside(blocks, end) ||
          !evaluator->Evaluate(end, FitEvaluator::Derivative::kNone, &end_cost, /*gradient=*/nullptr)) {
        return std::numeric_limits<double>::quiet_NaN();
      }
      return 2.0 * (end_cost - cost) / (scale * scale);
    };
    DentCheck check;
    check.parameter = static_cast<int>(i);
    check.step = step;
    check.expected_rise = step * step * precisions[i];
    check.rise_below = rise_at(-step);
    check.rise_above = rise_at(step);
    checks.push_back(check);
  }
  return checks;
}

}  // namespace clothid
