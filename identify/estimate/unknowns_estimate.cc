#include "identify/estimate/unknowns_estimate.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "costs/field/field_prior.h"
#include "costs/start/unknown_start.h"
#include "sim/matrix/dense.h"

namespace clothid {
namespace {

// Of the rows of a quantity  D s:  the root mean square of D s and of its standard deviations.
struct Spread {
  double size = 0.0, std = 0.0;
};

Spread SpreadOf(const Eigen::MatrixXd& directions, const Eigen::VectorXd& unknowns, const Eigen::MatrixXd& covariance) {
  const Eigen::Index num_rows = (directions.rowwise().squaredNorm().array() > 0.0).count();
  if (num_rows == 0) return {};
  const double variance = directions.cwiseProduct(directions * covariance).sum();
  return {std::sqrt((directions * unknowns).squaredNorm() / static_cast<double>(num_rows)),
          std::sqrt(std::max(variance, 0.0) / static_cast<double>(num_rows))};
}

StartEstimate EstimateOf(const UnknownStart& start, const Eigen::VectorXd& unknowns,
                         const Eigen::MatrixXd& covariance) {
  const SensitivityDirections& directions = start.directions();
  StartEstimate estimate;
  estimate.handle_error = start.HandleError(unknowns);
  const Spread positions = SpreadOf(directions.initial_positions, unknowns, covariance);
  estimate.moved = positions.size;
  estimate.position_std = positions.std;
  if (directions.handle_offsets.cols() > 0) {
    const Spread handles = SpreadOf(directions.handle_offsets, unknowns, covariance);
    estimate.handles_moved = handles.size;
    estimate.handle_std = handles.std;
    const Eigen::VectorXd& knots = start.handle_knots();
    if (knots.size() > 1) estimate.handle_interval = knots[1] - knots[0];
  }
  if (directions.initial_velocities.cols() > 0) {
    const Spread velocities = SpreadOf(directions.initial_velocities, unknowns, covariance);
    estimate.speed_change = velocities.size;
    estimate.velocity_std = velocities.std;
  }
  return estimate;
}

// The index of the block that is the level of a field.
int LevelOf(const FieldRequest& request, const FitProblem& problem) {
  for (int i = 0; i < problem.num_blocks(); ++i) {
    if (problem.blocks()[i].name == request.name) return i;
  }
  throw std::logic_error("a field without its level");
}

// (J^T J)^-1 with everything that is believed, over the parameters that are free and the columns of the basis.
struct UnknownsPosterior {
  std::vector<int> free;
  Eigen::MatrixXd covariance;  // s^2 times it
  double squared_scale = 1.0;
};

UnknownsPosterior PosteriorOf(const FitProblem& problem, const BasisLinearization& known) {
  UnknownsPosterior posterior;
  const Linearization& measured = known.linearization;
  posterior.free = problem.free_blocks();
  posterior.squared_scale = measured.SquaredScale(static_cast<double>(posterior.free.size()));
  const Eigen::MatrixXd believed = problem.PriorRows(known.basis.combinations);
  Eigen::MatrixXd all(measured.jacobian.rows() + believed.rows(), measured.jacobian.cols());
  all << measured.jacobian, believed;
  std::vector<int> columns = posterior.free;
  for (int i = problem.num_blocks(); i < static_cast<int>(all.cols()); ++i) columns.push_back(i);
  posterior.covariance = posterior.squared_scale * GramPseudoInverse(all(Eigen::all, columns));
  return posterior;
}

// What the squares of the residuals of the first frame have beyond those of noise, and beyond what chance adds to their
// sum, three of its standard deviations.
double FirstFrameError(const Observation& observation, const Eigen::MatrixXd& predicted,
                       const Eigen::MatrixXd& forces) {
  const Eigen::Index count = observation.first_row(1) - observation.first_row(0);
  if (!observation.sigma_is_known() || count == 0) return 0.0;
  const Eigen::VectorXd residuals = observation.Residuals(predicted, forces).segment(observation.first_row(0), count);
  double squares = 0.0, variance = 0.0;
  for (Eigen::Index i = 0; i < count; ++i) {
    const double squared_sigma = std::pow(observation.SigmaOf(static_cast<int>(i)), 2);
    squares += (std::pow(residuals[i], 2) - 1.0) * squared_sigma;
    variance += 2.0 * std::pow(squared_sigma, 2);
  }
  return std::sqrt(std::max(squares - 3.0 * std::sqrt(variance), 0.0) / static_cast<double>(count));
}

void FillStarts(const FitProblem& problem, const UnknownsPosterior& posterior, FitSummary* summary) {
  summary->starts.clear();
  Eigen::Index first = 0;
  const auto num_free = static_cast<Eigen::Index>(posterior.free.size());
  for (int r = 0; r < problem.num_recordings(); ++r) {
    const UnknownStart* const start = problem.cost(r).model().unknown_start();
    if (start == nullptr) continue;
    const Eigen::VectorXd unknowns = summary->coordinates.segment(problem.num_blocks() + first, start->size());
    const Eigen::Index place = num_free + first, size = start->size();
    summary->starts.push_back(EstimateOf(*start, unknowns, posterior.covariance.block(place, place, size, size)));
    summary->starts.back().recording = r;
    summary->starts.back().first_frame_error =
        FirstFrameError(problem.cost(r).model().observation(), summary->predicted[r], summary->forces[r]);
    first += size;
  }
}

// The roots of the variances of `weights` x, x with `covariance`, and of what is `beyond`, row by row of a control
// grid.
Eigen::MatrixXd DeviationsOf(const FieldRequest& request, const Eigen::MatrixXd& weights,
                             const Eigen::MatrixXd& covariance, const Eigen::VectorXd& beyond) {
  const Eigen::VectorXd variances = (weights * covariance).cwiseProduct(weights).rowwise().sum() + beyond;
  const Eigen::VectorXd roots = variances.cwiseMax(0.0).cwiseSqrt();
  return roots.reshaped(request.columns, request.rows).transpose();
}

void FillDeviations(const FitProblem& problem, const UnknownBasis& basis, const UnknownsPosterior& posterior,
                    FieldResult* result) {
  const Eigen::Index n = problem.num_start_unknowns(), f = problem.num_field_unknowns();
  const auto num_free = static_cast<Eigen::Index>(posterior.free.size());
  const Eigen::MatrixXd modes =
      problem.cost(0).model().field_unknowns()->WithoutMeans(basis.combinations.bottomRows(f));
  const double believed = posterior.squared_scale / result->weight;
  Eigen::Index row = 0;
  for (FittedField& field : result->fields) {
    const FieldRequest& request = field.request;
    Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(request.size(), posterior.covariance.cols());
    weights.rightCols(modes.cols()) = modes.middleRows(row, request.size());
    const Eigen::VectorXd rough = believed * RoughVariances(request.rows, request.columns, basis.field_modes);
    field.deviation_std = DeviationsOf(request, weights, posterior.covariance, rough);
    const auto place = std::find(posterior.free.begin(), posterior.free.end(), LevelOf(request, problem));
    if (place != posterior.free.end()) weights.col(place - posterior.free.begin()).setOnes();
    field.log_std = DeviationsOf(request, weights, posterior.covariance, rough);
    const Eigen::VectorXd before = believed * RoughVariances(request.rows, request.columns, 1);
    field.prior_deviation_std =
        DeviationsOf(request, Eigen::MatrixXd::Zero(request.size(), 0), Eigen::MatrixXd::Zero(0, 0), before);
    row += request.size();
  }
  const Eigen::MatrixXd rows = problem.FieldRows(basis.combinations);
  const Eigen::Index c = rows.cols() - (basis.with_starts ? n : 0);
  const Eigen::MatrixXd own = rows.rightCols(c);
  const double undetermined =
      own.cwiseProduct(own * posterior.covariance.bottomRightCorner(c, c)).sum() / posterior.squared_scale;
  result->num_determined = static_cast<double>(num_free) + static_cast<double>(c) - undetermined;
}

}  // namespace

void FillFields(const FitProblem& problem, FitSummary* summary) {
  if (problem.num_field_unknowns() == 0) return;
  FieldResult& result = summary->fields.emplace();
  result.weight = problem.WeightOf(kFieldPrior);
  result.weight_is_chosen = problem.smoothness().back().is_chosen;
  const Eigen::VectorXd theta =
      problem.cost(0).model().field_unknowns()->WithoutMeans(summary->coordinates.tail(problem.num_field_unknowns()));
  Eigen::Index first = 0;
  for (const FieldRequest& request : problem.fields()) {
    FittedField& field = result.fields.emplace_back();
    field.request = request;
    const int level = LevelOf(request, problem);
    const ParameterBlock& block = problem.blocks()[level];
    const double value = block.frozen ? block.start : block.ToValue(summary->coordinates[level]);
    const Eigen::VectorXd logs = theta.segment(first, request.size());
    field.values = value * logs.reshaped(request.columns, request.rows).transpose().array().exp();
    field.start = block.start;
    first += request.size();
  }
}

void DescribeUnknowns(const FitProblem& problem, const BasisLinearization& known, FitSummary* summary) {
  const UnknownsPosterior posterior = PosteriorOf(problem, known);
  if (known.basis.with_starts) FillStarts(problem, posterior, summary);
  if (summary->fields) FillDeviations(problem, known.basis, posterior, &*summary->fields);
}

Linearization KnownStart(const BasisLinearization& known, const FitProblem& problem) {
  Linearization without = known.linearization;
  const Eigen::Index p = problem.num_blocks(), c = known.basis.combinations.cols() - problem.num_start_unknowns();
  without.jacobian.resize(known.linearization.jacobian.rows(), p + c);
  without.jacobian << known.linearization.jacobian.leftCols(p), known.linearization.jacobian.rightCols(c);
  without.gradient = Eigen::VectorXd::Zero(p + c);
  without.frame_scores.clear();
  return without;
}

}  // namespace clothid
