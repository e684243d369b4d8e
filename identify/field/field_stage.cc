#include "identify/field/field_stage.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "identify/field/field_fit.h"
#include "identify/fit/fit.h"
#include "sim/base/error.h"

namespace clothid {
namespace {

// Where a field starts. The last block of its name is the one of the flat fit.
double StartLevel(const FieldRequest& request, const std::vector<ParameterBlock>& blocks, const Scene& scene) {
  double level = GetParameter(scene.nominal_parameters(), {request.kind, kAllObstacles});
  for (const ParameterBlock& block : blocks) {
    if (BaseName(block.name) == request.name) level = block.start;
  }
  if (level > 0.0) return level;
  throw Error(ErrorKind::kUsage, "--field: '" + request.name + "' is 0 in the scene; expected one that gives it");
}

FieldFitOptions FieldOptions(const FitOptions& options, double weight, const FitProblem& problem) {
  FieldFitOptions field;
  field.fit = options;
  field.weight = weight;
  if (!options.on_iteration) return field;
  field.on_iteration = [&options, &problem](const FieldIteration& at) {
    FitIteration iteration;
    iteration.iteration = at.iteration;
    iteration.seconds = at.seconds;
    iteration.cost = at.cost;
    iteration.values = problem.Values(at.coordinates);
    iteration.gradient_norm = std::numeric_limits<double>::quiet_NaN();
    iteration.rollouts = at.num_rollouts;
    options.on_iteration(iteration);
  };
  return field;
}

Eigen::VectorXd WithinBounds(const std::vector<ParameterBlock>& blocks, Eigen::VectorXd coordinates) {
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    double& coordinate = coordinates[static_cast<Eigen::Index>(i)];
    coordinate = std::clamp(coordinate, blocks[i].ToCoordinate(blocks[i].lower_bound),
                            blocks[i].ToCoordinate(blocks[i].upper_bound));
  }
  return coordinates;
}

// The fit with flat fields, whose levels are fitted with the parameters of `problem`: the blocks of these, in their
// order, and then those of levels that are not among them. A field takes over what a wrong level or friction leaves
// unexplained, and may not let go of it again.
struct FlatFit {
  FitSummary summary;
  std::vector<ParameterBlock> blocks;  // `start` at the estimate
};

FlatFit FitFlat(const FitOptions& options, const std::vector<FieldRequest>& requests, const FitProblem& problem,
                const std::vector<RecordedMotion>& motions) {
  FitOptions flat = options;
  flat.estimate_uncertainty = false;
  flat.journal_tag = "flat";
  flat.parameters.clear();
  for (const ParameterBlock& block : problem.blocks()) {
    if (options.each.empty()) flat.parameters.push_back(block.name);
  }
  if (!options.each.empty()) flat.parameters = options.parameters;
  for (const FieldRequest& request : requests) {
    const auto is_it = [&](const std::string& name) { return BaseName(name) == request.name; };
    const bool is_there = std::any_of(flat.parameters.begin(), flat.parameters.end(), is_it) ||
                          std::any_of(flat.each.begin(), flat.each.end(), is_it);
    if (!is_there) flat.parameters.push_back(request.name);
  }
  FitProblem flat_problem(motions, flat);
  FlatFit fit;
  fit.summary = Fit(flat, &flat_problem);
  fit.blocks = flat_problem.blocks();
  const Eigen::VectorXd values = fit.summary.has_estimate() ? fit.summary.values() : Eigen::VectorXd();
  for (Eigen::Index i = 0; i < values.size(); ++i) fit.blocks[static_cast<std::size_t>(i)].start = values[i];
  return fit;
}

// `blocks` with the starts of those of the same names in `others`.
std::vector<ParameterBlock> StartAt(std::vector<ParameterBlock> blocks, const std::vector<ParameterBlock>& others) {
  for (ParameterBlock& block : blocks) {
    for (const ParameterBlock& other : others) {
      if (other.name == block.name) block.start = other.start;
    }
  }
  return blocks;
}

// What the fit of the parameters does not know of those before it.
void AddFieldFit(const FlatFit& flat, const FieldFit& fit, const std::vector<ParameterBlock>& first_blocks,
                 FitSummary* summary) {
  for (std::size_t i = 0; i < summary->parameters.size(); ++i) summary->parameters[i].start = first_blocks[i].start;
  summary->start_error = flat.summary.start_error;
  summary->start_predicted = flat.summary.start_predicted;
  summary->statistics += flat.summary.statistics;
  summary->lead += flat.summary.lead;
  summary->total_seconds += flat.summary.total_seconds;
  summary->statistics.rollouts += fit.result.num_rollouts;
  summary->statistics.sweeps += fit.result.num_sweeps;
  summary->total_seconds += fit.result.seconds;
}

}  // namespace

FitSummary FitWithFields(const FitOptions& options, const std::vector<FieldRequest>& requests, double weight,
                         std::vector<RecordedMotion>* motions, std::unique_ptr<FitProblem>* problem,
                         FieldResult* result) {
  ExpectInCommon((*problem)->blocks(), requests);
  for (const FieldRequest& request : requests) StartLevel(request, (*problem)->blocks(), motions->front().scene);
  const FlatFit flat = FitFlat(options, requests, **problem, *motions);
  for (const FieldRequest& request : requests) {
    const double level = StartLevel(request, flat.blocks, motions->front().scene);
    SetField({request.kind, Eigen::MatrixXd::Constant(request.rows, request.columns, level)}, motions);
  }
  const std::vector<ParameterBlock> first_blocks = (*problem)->blocks();
  const FieldFit fit =
      FitFields(*motions, StartAt(first_blocks, flat.blocks), requests, FieldOptions(options, weight, **problem));
  *result = fit.result;
  FitSummary summary;
  if (!fit.result.ok) {
    summary.status = options.is_cancelled() ? FitStatus::kInterrupted : FitStatus::kFailed;
    summary.message = "fields: " + fit.result.message;
    return summary;
  }
  for (const FittedField& field : fit.result.fields) SetField({field.request.kind, field.values}, motions);
  *problem = std::make_unique<FitProblem>(*motions, options);
  (*problem)->SetStart(WithinBounds((*problem)->blocks(), fit.coordinates));
  FitOptions of_parameters = options;
  of_parameters.estimate_uncertainty = false;
  summary = Fit(of_parameters, problem->get());
  if (summary.has_estimate() && options.estimate_uncertainty && fit.marginal) {
    of_parameters.check_interval = false;  // it would look at the cost with the fields held
    summary.linearization = fit.marginal;
    AddUncertainty(of_parameters, **problem, &summary);
  }
  AddFieldFit(flat, fit, first_blocks, &summary);
  return summary;
}

}  // namespace clothid
