#include "identify/uncertainty/uncertainty.h"

#include <algorithm>
#include <cmath>

#include "identify/uncertainty/correlated_scores.h"
#include "identify/uncertainty/priors.h"
#include "identify/uncertainty/scaled_jacobian.h"
#include "sim/matrix/dense.h"

namespace clothid {
namespace {

// Correlations of successive residuals are taken as at most this: a recording would have to be long to tell more.
constexpr double kHighest = 0.97;
// Steps of some resolutions are what an optimiser leaves.
constexpr double kLeftResolutions = 10.0;
// Nobody knows a stiffness to less than this factor from end to end.
constexpr double kWidestBelief = 1e4;

std::vector<int> FreeBlocks(const std::vector<ParameterBlock>& blocks) {
  std::vector<int> free;
  for (int i = 0; i < static_cast<int>(blocks.size()); ++i) {
    if (!blocks[i].frozen) free.push_back(i);
  }
  return free;
}

// The rows of `jacobian` whose parameters get a standard deviation: those that are seen or believed.
std::vector<Eigen::Index> RowsWithStd(const std::vector<ParameterBlock>& blocks, const ScaledJacobian& jacobian,
                                      const Uncertainty& uncertainty) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < jacobian.size(); ++i) {
    const int index = jacobian.indices()[i];
    const bool is_believed = blocks[index].prior.is_given() || IsKnot(blocks, index);
    if (uncertainty.parameters[index].visible || is_believed) rows.push_back(i);
  }
  return rows;
}

// `gradient`: of the whole cost.
void FillIntervals(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                   const Eigen::VectorXd& gradient, const Posterior& posterior, const std::vector<Eigen::Index>& rows,
                   Uncertainty* uncertainty) {
  const ScaledJacobian& jacobian = posterior.jacobian();
  const double scale = uncertainty->residual_scale;
  const auto variance = [&](Eigen::Index i) { return posterior.Covariance(i, i, scale); };
  for (const Eigen::Index i : rows) {
    const int index = jacobian.indices()[i];
    const ParameterBlock& block = blocks[index];
    ParameterUncertainty& parameter = uncertainty->parameters[index];
    const double q = coordinates[index];
    const double std = std::hypot(std::sqrt(variance(i)), block.Resolution(q));
    parameter.coordinate_std = std;
    parameter.independent_std = std;
    if (HasPriors(blocks)) parameter.cost_scale = std::sqrt(variance(i) / jacobian.Covariance(i, i));
    parameter.std = block.ValueDerivative(q) * std;
    SetInterval(block, q, kNormal95 * std, &parameter);
    parameter.distance = std::abs(jacobian.Solve(i, gradient)) / std;
    for (const Eigen::Index j : rows) {
      const int other = jacobian.indices()[j];
      uncertainty->correlation(index, other) =
          i == j ? 1.0 : posterior.Covariance(i, j, scale) / std::sqrt(variance(i) * variance(j));
      uncertainty->independent_correlation(index, other) =
          i == j ? 1.0 : jacobian.Inverse(i, j) / std::sqrt(jacobian.Inverse(i, i) * jacobian.Inverse(j, j));
    }
  }
}

// The intervals of the rows `rows` of `jacobian` again, with the covariance of q over them where it is larger.
void WidenIntervals(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                    const ScaledJacobian& jacobian, const std::vector<Eigen::Index>& rows,
                    const Eigen::MatrixXd& covariance, Uncertainty* uncertainty) {
  const double quantile = uncertainty->quantile95;
  for (std::size_t a = 0; a < rows.size(); ++a) {
    const int index = jacobian.indices()[rows[a]];
    const ParameterBlock& block = blocks[index];
    ParameterUncertainty& parameter = uncertainty->parameters[index];
    const double q = coordinates[index];
    const auto own = static_cast<Eigen::Index>(a);
    const double std =
        std::max(parameter.independent_std, std::hypot(std::sqrt(covariance(own, own)), block.Resolution(q)));
    parameter.coordinate_std = std;
    parameter.widening = quantile * std / (kNormal95 * parameter.independent_std);
    parameter.std = block.ValueDerivative(q) * std;
    SetInterval(block, q, quantile * std, &parameter);
    for (std::size_t b = 0; b < rows.size(); ++b) {
      const auto other = static_cast<Eigen::Index>(b);
      uncertainty->correlation(index, jacobian.indices()[rows[b]]) =
          a == b ? 1.0 : covariance(own, other) / std::sqrt(covariance(own, own) * covariance(other, other));
    }
  }
}

// Looks whether residuals are correlated, and widens the intervals where they are. `fitted_scale`: the root mean square
// of the residuals.
void AccountForCorrelation(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                           const Linearization& linearization, const Posterior& posterior,
                           const std::vector<Eigen::Index>& rows, double fitted_scale, Uncertainty* uncertainty) {
  if (linearization.frame_scores.empty() || fitted_scale < kRoundingResiduals || rows.empty()) return;
  const ScaledJacobian& jacobian = posterior.jacobian();
  FrameSeries influences;
  for (const Eigen::MatrixXd& scores : WithoutEmptyFrames(linearization.frame_scores)) {
    Eigen::MatrixXd& influence = influences.emplace_back(static_cast<Eigen::Index>(rows.size()), scores.cols());
    for (std::size_t a = 0; a < rows.size(); ++a) {
      influence.row(static_cast<Eigen::Index>(a)) = jacobian.SolveRow(rows[a], scores);
    }
  }
  Eigen::VectorXd independent(static_cast<Eigen::Index>(rows.size()));
  for (Eigen::Index a = 0; a < independent.size(); ++a) {
    const Eigen::Index i = rows[a];
    independent[a] =
        std::pow(fitted_scale, 2) * (jacobian.Covariance(i, i) - posterior.PriorPart(i, i) - posterior.LinkPart(i, i));
  }
  if (!(linearization.autocorrelation > kCorrelatedResiduals) && !IsCorrelatedWithinFrames(influences, independent)) {
    return;
  }
  const double correlation =
      std::isnan(linearization.autocorrelation) ? 0.0 : std::clamp(linearization.autocorrelation, 0.0, kHighest);
  Eigen::MatrixXd covariance = CovarianceOfSum(influences, correlation);
  for (Eigen::Index a = 0; a < covariance.rows(); ++a) {
    for (Eigen::Index b = 0; b < covariance.cols(); ++b) {
      covariance(a, b) += posterior.PriorPart(rows[a], rows[b]) +
                          std::pow(uncertainty->residual_scale, 2) * posterior.LinkPart(rows[a], rows[b]);
    }
  }
  if (!((covariance.diagonal().array() > 0.0).all() && covariance.allFinite())) return;
  uncertainty->is_widened = true;
  uncertainty->quantile95 = Student95(ScoreDegreesOfFreedom(influences, correlation));
  WidenIntervals(blocks, coordinates, jacobian, rows, covariance, uncertainty);
}

// The interval of a parameter that stalled by `step` of q.
void WidenByStall(const ParameterBlock& block, double coordinate, double step, ParameterUncertainty* parameter) {
  parameter->stall_error = block.ValueDerivative(coordinate) * std::abs(step);
  SetInterval(block, coordinate, std::hypot(parameter->half_width95, kNormal95 * step), parameter);
}

// What the Gauss-Newton step over the rows of `jacobian` that have a standard deviation promises, and which parameters
// have stalled by it.
void FindStalled(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                 const Eigen::VectorXd& gradient, const Posterior& posterior, const std::vector<Eigen::Index>& rows,
                 Uncertainty* uncertainty) {
  if (rows.empty()) return;
  const ScaledJacobian& jacobian = posterior.jacobian();
  const auto size = static_cast<Eigen::Index>(rows.size());
  Eigen::VectorXd step(size);
  Eigen::MatrixXd covariance(size, size);
  for (Eigen::Index a = 0; a < size; ++a) {
    const int index = jacobian.indices()[rows[a]];
    step[a] = -jacobian.Solve(rows[a], gradient);
    for (Eigen::Index b = 0; b < size; ++b) {
      covariance(a, b) = posterior.Covariance(rows[a], rows[b], uncertainty->residual_scale);
    }
    covariance(a, a) += std::pow(kLeftResolutions * blocks[index].Resolution(coordinates[index]), 2);
  }
  uncertainty->predicted_decrease = 0.5 * step.dot(SymmetricFactor(covariance).SolveOne(step));
  if (!(uncertainty->predicted_decrease > kStalledDecrease)) return;
  const Eigen::ArrayXd parts = 0.5 * step.array().square() / covariance.diagonal().array();
  const double least = std::min(kStalledDecrease, parts.maxCoeff());
  const bool is_near = uncertainty->predicted_decrease <= kNearDecrease;
  for (Eigen::Index a = 0; a < size; ++a) {
    if (!(parts[a] >= least)) continue;
    const int index = jacobian.indices()[rows[a]];
    ParameterUncertainty& parameter = uncertainty->parameters[index];
    parameter.stalled = !is_near;
    if (is_near) WidenByStall(blocks[index], coordinates[index], step[a], &parameter);
  }
}

// What parameters with a prior would be known without it. `moving`: those off their bounds.
void CompareWithPriors(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                       const Eigen::MatrixXd& jacobian, const std::vector<int>& moving, Uncertainty* uncertainty) {
  for (const int i : moving) {
    const ParameterBlock& block = blocks[i];
    ParameterUncertainty& parameter = uncertainty->parameters[i];
    if (!block.prior.is_given() || std::isnan(parameter.coordinate_std)) continue;
    ToldBesidePrior told = TellBesidePrior(blocks, coordinates, jacobian, moving, i, parameter.coordinate_std,
                                           uncertainty->residual_scale, parameter.widening, parameter.visible);
    const double half_width = kNormal95 * told.other_std;
    told.is_told = parameter.visible && told.other_std <= kHardlyTold * BelievedStd(block) &&
                   coordinates[i] - half_width > block.ToCoordinate(block.lower_bound) &&
                   coordinates[i] + half_width < block.ToCoordinate(block.upper_bound);
    parameter.beside_prior = told;
  }
}

// The change that anything but its own prior sees as a free parameter moves from bound to bound.
void FillVisibility(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                    const Eigen::MatrixXd& jacobian, const std::vector<int>& free, double fitted_scale,
                    Uncertainty* uncertainty) {
  const double noise = std::max(1.0, fitted_scale), visible = kVisibleChange * noise;
  const ScaledJacobian all(blocks, WithPriorRows(blocks, jacobian, noise), free);
  for (Eigen::Index i = 0; i < all.size(); ++i) {
    const int index = free[i];
    ParameterUncertainty& parameter = uncertainty->parameters[index];
    parameter.at_bound = blocks[index].IsAtBound(coordinates[index]);
    parameter.cost_scale = uncertainty->residual_scale;
    parameter.visible_change =
        blocks[index].prior.is_given()
            ? ScaledJacobian(blocks, WithPriorRows(blocks, jacobian, noise, index), free).VisibleChange(i)
        : IsKnot(blocks, index) ? VisibleWithoutLinks(blocks, all, i)
                                : all.VisibleChange(i);
    parameter.visible = parameter.visible_change > visible;
  }
  uncertainty->singular_values = all.singular_values();
  for (Eigen::Index k = all.size() - 1; k >= 0 && all.singular_values()[k] <= visible; --k) {
    HiddenDirection direction;
    direction.coordinates = all.Direction(k, coordinates.size());
    direction.visible_change = all.singular_values()[k];
    direction.words = DescribeDirection(blocks, direction.coordinates);
    uncertainty->hidden_directions.push_back(direction);
  }
}

}  // namespace

double Linearization::SquaredScale(double num_fitted) const {
  const double degrees = num_measurements - num_fitted;
  const double fitted = degrees > 0.0 ? squared_residual / degrees : 1.0;
  return sigma_is_known ? std::max(1.0, fitted) : fitted;
}

double ParameterUncertainty::total_std() const {
  const auto known = [](double error) { return std::isnan(error) ? 0.0 : error; };
  return std::hypot(std::hypot(std, known(memory_error), known(stall_error)), known(step_error), known(mesh_error));
}

bool Uncertainty::all_identifiable(const std::vector<ParameterBlock>& blocks) const {
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!blocks[i].frozen && !parameters[i].identifiable) return false;
  }
  return true;
}

double Uncertainty::largest_widening() const {
  double largest = 1.0;
  for (const ParameterUncertainty& parameter : parameters) largest = std::max(largest, parameter.widening);
  return largest;
}

void SetInterval(const ParameterBlock& block, double coordinate, double half_width, ParameterUncertainty* parameter) {
  parameter->half_width95 = half_width;
  parameter->lower95 = std::max(block.lower_bound, block.ToValue(coordinate - half_width));
  parameter->upper95 = std::min(block.upper_bound, block.ToValue(coordinate + half_width));
}

void JudgeIntervals(const std::vector<ParameterBlock>& blocks, Uncertainty* uncertainty) {
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    ParameterUncertainty& parameter = uncertainty->parameters[i];
    if (std::isnan(parameter.coordinate_std)) continue;
    if (blocks[i].scale == ParameterScale::kLog) parameter.factor = std::exp(2.0 * parameter.half_width95);
    parameter.share_of_belief = parameter.half_width95 / (kNormal95 * BelievedStd(blocks[i]));
    parameter.reaches_lower = parameter.lower95 <= blocks[i].lower_bound;
    parameter.reaches_upper = parameter.upper95 >= blocks[i].upper_bound;
    const bool is_told = parameter.beside_prior ? parameter.beside_prior->is_told : !parameter.is_hardly_told();
    parameter.identifiable =
        parameter.visible && !parameter.stalled && !parameter.reaches_lower && !parameter.reaches_upper && is_told;
    if (parameter.stalled) parameter.std = parameter.lower95 = parameter.upper95 = std::nan("");
  }
}

double BelievedStd(const ParameterBlock& block) {
  return BelievedRangeOf(block.CoordinateRange(), block.scale) / std::sqrt(12.0);
}

double BelievedRangeOf(double range, ParameterScale scale) {
  return scale == ParameterScale::kLog ? std::min(range, std::log(kWidestBelief)) : range;
}

bool IsResolution(const ParameterBlock& block, double coordinate, double coordinate_std) {
  return coordinate_std < 2.0 * block.Resolution(coordinate);
}

Uncertainty EstimateUncertainty(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                                const Linearization& linearization) {
  const std::vector<int> free = FreeBlocks(blocks);
  const double degrees_of_freedom = linearization.num_measurements - static_cast<double>(free.size());
  const double fitted_scale =
      degrees_of_freedom > 0.0 ? std::sqrt(linearization.squared_residual / degrees_of_freedom) : 1.0;

  Uncertainty uncertainty;
  uncertainty.residual_scale = linearization.sigma_is_known ? std::max(1.0, fitted_scale) : fitted_scale;
  uncertainty.parameters.resize(blocks.size());
  uncertainty.correlation =
      Eigen::MatrixXd::Constant(coordinates.size(), coordinates.size(), std::numeric_limits<double>::quiet_NaN());
  uncertainty.independent_correlation = uncertainty.correlation;
  FillVisibility(blocks, coordinates, linearization.jacobian, free, fitted_scale, &uncertainty);
  std::vector<int> off_bounds;
  for (const int i : free) {
    if (!uncertainty.parameters[i].at_bound) off_bounds.push_back(i);
  }
  const Posterior posterior(blocks, linearization.jacobian, off_bounds);
  const std::vector<Eigen::Index> rows = RowsWithStd(blocks, posterior.jacobian(), uncertainty);
  const Eigen::VectorXd gradient = linearization.gradient + PriorGradient(blocks, coordinates);
  FillIntervals(blocks, coordinates, gradient, posterior, rows, &uncertainty);
  AccountForCorrelation(blocks, coordinates, linearization, posterior, rows, fitted_scale, &uncertainty);
  FindStalled(blocks, coordinates, gradient, posterior, rows, &uncertainty);
  CompareWithPriors(blocks, coordinates, linearization.jacobian, off_bounds, &uncertainty);
  JudgeIntervals(blocks, &uncertainty);
  return uncertainty;
}

}  // namespace clothid
