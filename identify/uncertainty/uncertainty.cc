#include "identify/uncertainty/uncertainty.h"

#include <ceres/crs_matrix.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <stdexcept>

#include "identify/base/join_words.h"
#include "identify/uncertainty/correlated_scores.h"
#include "identify/uncertainty/scaled_jacobian.h"

namespace clothid {
namespace {

// Changes of the prediction up to this many standard deviations are not seen.
constexpr double kVisible = 2.0;
// Entries of a direction below this share of its largest are left out of its words.
constexpr double kNegligibleShare = 0.01;
// Correlations of successive residuals are taken as at most this: a recording would have to be long to tell more.
constexpr double kHighest = 0.97;
// Steps of some resolutions are what an optimiser leaves.
constexpr double kLeftResolutions = 10.0;
// Nobody knows a stiffness to less than this factor from end to end.
constexpr double kWidestBelief = 1e4;
// Logarithmic entries that differ by less than this share are one common factor.
constexpr double kCommonFactor = 0.02;

std::vector<int> FreeBlocks(const std::vector<ParameterBlock>& blocks) {
  std::vector<int> free;
  for (int i = 0; i < static_cast<int>(blocks.size()); ++i) {
    if (!blocks[i].frozen) free.push_back(i);
  }
  return free;
}

bool IsCommonFactor(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& direction,
                    const std::vector<int>& parts) {
  return parts.size() > 1 && std::all_of(parts.begin(), parts.end(), [&](int i) {
           return blocks[i].scale == ParameterScale::kLog && std::abs(direction[i] - 1.0) < kCommonFactor;
         });
}

std::string DescribeDirection(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& direction) {
  std::vector<int> parts;
  std::vector<std::string> names, moves;
  for (int i = 0; i < direction.size(); ++i) {
    if (std::abs(direction[i]) < kNegligibleShare) continue;
    parts.push_back(i);
    names.push_back(blocks[i].name);
    std::ostringstream move;
    move << std::setprecision(3) << blocks[i].name;
    if (blocks[i].scale == ParameterScale::kLog) {
      move << " times " << std::exp2(direction[i]);
    } else {
      move << (direction[i] < 0.0 ? " minus " : " plus ") << blocks[i].unit * std::abs(direction[i]) * std::log(2.0);
    }
    moves.push_back(move.str());
  }
  if (parts.size() == 1) return names.front();
  if (IsCommonFactor(blocks, direction, parts)) return JoinWords(names) + " multiplied by one factor";
  return JoinWords(moves);
}

void FillIntervals(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                   const Eigen::VectorXd& gradient, const ScaledJacobian& jacobian, double scale,
                   Uncertainty* uncertainty) {
  const auto has_std = [&](Eigen::Index i) { return uncertainty->parameters[jacobian.indices()[i]].visible; };
  for (Eigen::Index i = 0; i < jacobian.size(); ++i) {
    if (!has_std(i)) continue;
    const int index = jacobian.indices()[i];
    const ParameterBlock& block = blocks[index];
    ParameterUncertainty& parameter = uncertainty->parameters[index];
    const double q = coordinates[index];
    const double std = std::hypot(scale * jacobian.CoordinateStd(i), block.Resolution(q));
    parameter.coordinate_std = std;
    parameter.independent_std = std;
    parameter.std = block.ValueDerivative(q) * std;
    SetInterval(block, q, kNormal95 * std, &parameter);
    parameter.distance = std::abs(jacobian.Solve(i, gradient)) / std;
    for (Eigen::Index j = 0; j < jacobian.size(); ++j) {
      if (!has_std(j)) continue;
      uncertainty->correlation(index, jacobian.indices()[j]) =
          i == j ? 1.0 : jacobian.Inverse(i, j) / std::sqrt(jacobian.Inverse(i, i) * jacobian.Inverse(j, j));
    }
  }
  uncertainty->independent_correlation = uncertainty->correlation;
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
                           const Linearization& linearization, const ScaledJacobian& jacobian, double fitted_scale,
                           Uncertainty* uncertainty) {
  if (linearization.frame_scores.empty() || fitted_scale < kRoundingResiduals) return;
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < jacobian.size(); ++i) {
    if (uncertainty->parameters[jacobian.indices()[i]].visible) rows.push_back(i);
  }
  if (rows.empty()) return;
  FrameSeries influences;
  for (const Eigen::MatrixXd& scores : WithoutEmptyFrames(linearization.frame_scores)) {
    Eigen::MatrixXd& influence = influences.emplace_back(static_cast<Eigen::Index>(rows.size()), scores.cols());
    for (std::size_t a = 0; a < rows.size(); ++a) {
      influence.row(static_cast<Eigen::Index>(a)) = jacobian.SolveRow(rows[a], scores);
    }
  }
  Eigen::VectorXd independent(static_cast<Eigen::Index>(rows.size()));
  for (Eigen::Index a = 0; a < independent.size(); ++a) {
    independent[a] = std::pow(fitted_scale * jacobian.CoordinateStd(rows[a]), 2);
  }
  if (!(linearization.autocorrelation > kCorrelatedResiduals) && !IsCorrelatedWithinFrames(influences, independent)) {
    return;
  }
  const double correlation =
      std::isnan(linearization.autocorrelation) ? 0.0 : std::clamp(linearization.autocorrelation, 0.0, kHighest);
  const Eigen::MatrixXd covariance = CovarianceOfSum(influences, correlation);
  if (!((covariance.diagonal().array() > 0.0).all() && covariance.allFinite())) return;
  uncertainty->is_widened = true;
  uncertainty->quantile95 = Student95(ScoreDegreesOfFreedom(influences, correlation));
  WidenIntervals(blocks, coordinates, jacobian, rows, covariance, uncertainty);
}

// What the Gauss-Newton step over the rows of `jacobian` that have a standard deviation promises, and which parameters
// have stalled by it.
void FindStalled(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                 const Eigen::VectorXd& gradient, const ScaledJacobian& jacobian, Uncertainty* uncertainty) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < jacobian.size(); ++i) {
    if (uncertainty->parameters[jacobian.indices()[i]].visible) rows.push_back(i);
  }
  if (rows.empty()) return;
  const auto size = static_cast<Eigen::Index>(rows.size());
  Eigen::VectorXd step(size);
  Eigen::MatrixXd covariance(size, size);
  for (Eigen::Index a = 0; a < size; ++a) {
    const int index = jacobian.indices()[rows[a]];
    step[a] = -jacobian.Solve(rows[a], gradient);
    for (Eigen::Index b = 0; b < size; ++b) {
      covariance(a, b) = std::pow(uncertainty->residual_scale, 2) * jacobian.Covariance(rows[a], rows[b]);
    }
    covariance(a, a) += std::pow(kLeftResolutions * blocks[index].Resolution(coordinates[index]), 2);
  }
  uncertainty->predicted_decrease = 0.5 * step.dot(covariance.ldlt().solve(step));
  if (!(uncertainty->predicted_decrease > kStalledDecrease)) return;
  const Eigen::ArrayXd parts = 0.5 * step.array().square() / covariance.diagonal().array();
  const double least = std::min(kStalledDecrease, parts.maxCoeff());
  for (Eigen::Index a = 0; a < size; ++a) {
    uncertainty->parameters[jacobian.indices()[rows[a]]].stalled = parts[a] >= least;
  }
}

}  // namespace

Linearization Linearize(const std::vector<double*>& coordinates, int num_measurements, bool sigma_is_known,
                        ceres::Problem* problem) {
  ceres::Problem::EvaluateOptions options;
  options.parameter_blocks = coordinates;
  double cost = 0.0;
  std::vector<double> gradient;
  ceres::CRSMatrix sparse;
  if (!problem->Evaluate(options, &cost, nullptr, &gradient, &sparse)) {
    throw std::runtime_error("the problem cannot be evaluated at the solution");
  }
  Linearization linearization;
  linearization.jacobian = Eigen::MatrixXd::Zero(sparse.num_rows, static_cast<Eigen::Index>(coordinates.size()));
  for (int row = 0; row < sparse.num_rows; ++row) {
    for (int k = sparse.rows[row]; k < sparse.rows[row + 1]; ++k) {
      linearization.jacobian(row, sparse.cols[k]) = sparse.values[k];
    }
  }
  linearization.gradient = Eigen::Map<Eigen::VectorXd>(gradient.data(), static_cast<Eigen::Index>(gradient.size()));
  linearization.squared_residual = 2.0 * cost;
  linearization.num_measurements = num_measurements;
  linearization.sigma_is_known = sigma_is_known;
  return linearization;
}

double ParameterUncertainty::total_std() const {
  const auto known = [](double error) { return std::isnan(error) ? 0.0 : error; };
  return std::hypot(std, known(step_error), known(mesh_error));
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
    const bool is_log = blocks[i].scale == ParameterScale::kLog;
    const double widest = is_log ? std::log(kWidestBelief) : std::numeric_limits<double>::infinity();
    const double believed_std = std::min(blocks[i].CoordinateRange(), widest) / std::sqrt(12.0);
    if (is_log) parameter.factor = std::exp(2.0 * parameter.half_width95);
    parameter.share_of_belief = parameter.half_width95 / (kNormal95 * believed_std);
    parameter.reaches_lower = parameter.lower95 <= blocks[i].lower_bound;
    parameter.reaches_upper = parameter.upper95 >= blocks[i].upper_bound;
    parameter.identifiable =
        !parameter.stalled && !parameter.reaches_lower && !parameter.reaches_upper && !parameter.is_hardly_told();
    if (parameter.stalled) parameter.std = parameter.lower95 = parameter.upper95 = std::nan("");
  }
}

bool IsResolution(const ParameterBlock& block, double coordinate, double coordinate_std) {
  return coordinate_std < 2.0 * block.Resolution(coordinate);
}

Uncertainty EstimateUncertainty(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                                const Linearization& linearization) {
  const std::vector<int> free = FreeBlocks(blocks);
  const ScaledJacobian jacobian(blocks, linearization.jacobian, free);
  const double degrees_of_freedom = linearization.num_measurements - static_cast<double>(free.size());
  const double fitted_scale =
      degrees_of_freedom > 0.0 ? std::sqrt(linearization.squared_residual / degrees_of_freedom) : 1.0;
  const double visible = kVisible * std::max(1.0, fitted_scale);

  Uncertainty uncertainty;
  uncertainty.residual_scale = linearization.sigma_is_known ? std::max(1.0, fitted_scale) : fitted_scale;
  uncertainty.parameters.resize(blocks.size());
  uncertainty.correlation =
      Eigen::MatrixXd::Constant(coordinates.size(), coordinates.size(), std::numeric_limits<double>::quiet_NaN());
  uncertainty.singular_values = jacobian.singular_values();
  std::vector<int> off_bounds;
  for (Eigen::Index i = 0; i < jacobian.size(); ++i) {
    ParameterUncertainty& parameter = uncertainty.parameters[free[i]];
    parameter.at_bound = blocks[free[i]].IsAtBound(coordinates[free[i]]);
    parameter.visible_change = jacobian.VisibleChange(i);
    parameter.visible = parameter.visible_change > visible;
    if (!parameter.at_bound) off_bounds.push_back(free[i]);
  }
  for (Eigen::Index k = jacobian.size() - 1; k >= 0 && jacobian.singular_values()[k] <= visible; --k) {
    HiddenDirection direction;
    direction.coordinates = jacobian.Direction(k, coordinates.size());
    direction.visible_change = jacobian.singular_values()[k];
    direction.words = DescribeDirection(blocks, direction.coordinates);
    uncertainty.hidden_directions.push_back(direction);
  }
  const ScaledJacobian inner(blocks, linearization.jacobian, off_bounds);
  FillIntervals(blocks, coordinates, linearization.gradient, inner, uncertainty.residual_scale, &uncertainty);
  AccountForCorrelation(blocks, coordinates, linearization, inner, fitted_scale, &uncertainty);
  FindStalled(blocks, coordinates, linearization.gradient, inner, &uncertainty);
  JudgeIntervals(blocks, &uncertainty);
  return uncertainty;
}

}  // namespace clothid
