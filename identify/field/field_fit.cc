#include "identify/field/field_fit.h"

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

constexpr int kPosteriorModes = 16;  // a side, of the curvature that gives standard deviations

Precision FirstPrecision(const FieldFitOptions& options) {
  return options.fit.precision == FitPrecision::kAdaptive ? Precision::kLoose : Precision::kFull;
}

}  // namespace

FieldFit FitFields(const std::vector<RecordedMotion>& motions, const std::vector<ParameterBlock>& blocks,
                   const std::vector<FieldRequest>& requests, const FieldFitOptions& options) {
  const double start = SteadySeconds();
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
    result.ok = RunFieldNewton(options, &model, &point, &result);
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
