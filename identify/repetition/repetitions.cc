#include "identify/repetition/repetitions.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "identify/base/join_words.h"
#include "sim/base/error.h"

namespace clothid {
namespace {

constexpr double kLeastScatter = 1e-3;

double ToCoordinate(ParameterScale scale, double value) {
  return scale == ParameterScale::kLog ? std::log(value) : value;
}

double ToValue(ParameterScale scale, double coordinate) {
  return scale == ParameterScale::kLog ? std::exp(coordinate) : coordinate;
}

// What a small error of the value is in the coordinate.
double ErrorInCoordinate(const SingleEstimate& estimate, double error) {
  return estimate.scale == ParameterScale::kLog ? error / estimate.value : error;
}

// Of time step and mesh together; NaN: neither is known.
double CommonError(const SingleEstimate& estimate) {
  if (std::isnan(estimate.step_error) && std::isnan(estimate.mesh_error)) return estimate.step_error;
  const auto known = [](double error) { return std::isnan(error) ? 0.0 : error; };
  return ErrorInCoordinate(estimate, std::hypot(known(estimate.step_error), known(estimate.mesh_error)));
}

// Where one is not known it is that of the others, for it is common to all.
void FillUnknown(Eigen::VectorXd* errors) {
  double sum = 0.0;
  int num_known = 0;
  for (const double error : *errors) {
    if (std::isnan(error)) continue;
    sum += error;
    ++num_known;
  }
  for (double& error : *errors) {
    if (std::isnan(error)) error = num_known > 0 ? sum / num_known : 0.0;
  }
}

// The widest bounds of the fits; infinite where one has none.
std::pair<double, double> CommonBounds(const std::vector<const SingleEstimate*>& estimates) {
  std::pair<double, double> bounds(estimates.front()->lower_bound, estimates.front()->upper_bound);
  for (const SingleEstimate* estimate : estimates) {
    bounds.first = std::min(bounds.first, estimate->lower_bound);
    bounds.second = std::max(bounds.second, estimate->upper_bound);
  }
  return bounds;
}

void SetOwnUnits(const std::pair<double, double>& bounds, PooledParameter* parameter) {
  const RandomEffects& effects = parameter->effects;
  const auto at = [&](double half_width) {
    const double value = ToValue(parameter->scale, effects.mean + half_width);
    return std::isnan(value) ? value : std::clamp(value, bounds.first, bounds.second);
  };
  parameter->mean = at(0.0);
  parameter->lower95 = at(-effects.mean_half_width);
  parameter->upper95 = at(effects.mean_half_width);
  parameter->next_lower95 = at(-effects.next_half_width);
  parameter->next_upper95 = at(effects.next_half_width);
}

PooledParameter PoolParameter(const std::vector<SingleFit>& fits, const std::string& name) {
  PooledParameter parameter;
  parameter.name = name;
  std::vector<const SingleEstimate*> estimates;
  for (std::size_t r = 0; r < fits.size(); ++r) {
    const SingleEstimate* estimate = fits[r].Find(name);
    if (estimate == nullptr) continue;
    parameter.scale = estimate->scale;
    if (!fits[r].why_not_used.empty() || !estimate->is_told()) continue;
    parameter.fits.push_back(static_cast<int>(r));
    estimates.push_back(estimate);
  }
  if (!parameter.is_pooled()) return parameter;
  const auto num = static_cast<Eigen::Index>(estimates.size());
  Eigen::VectorXd y(num), s(num), errors(num);
  for (Eigen::Index r = 0; r < num; ++r) {
    const SingleEstimate& estimate = *estimates[static_cast<std::size_t>(r)];
    y[r] = ToCoordinate(estimate.scale, estimate.value);
    s[r] = ErrorInCoordinate(estimate, estimate.std);
    errors[r] = CommonError(estimate);
  }
  FillUnknown(&errors);
  parameter.effects = PoolRepetitions(y, s, errors);
  SetOwnUnits(CommonBounds(estimates), &parameter);
  return parameter;
}

}  // namespace

bool SingleEstimate::is_told() const {
  return !is_frozen && std::isfinite(value) && std::isfinite(std) && std > 0.0 &&
         (scale == ParameterScale::kLinear || value > 0.0);
}

const SingleEstimate* SingleFit::Find(const std::string& parameter) const {
  const auto it = std::find_if(estimates.begin(), estimates.end(),
                               [&](const SingleEstimate& estimate) { return estimate.name == parameter; });
  return it == estimates.end() ? nullptr : &*it;
}

bool PooledParameter::varies() const {
  const double size = scale == ParameterScale::kLog ? 1.0 : std::abs(mean);
  return is_pooled() && effects.varies() && effects.scatter() > kLeastScatter * size;
}

bool Repetitions::any_varies() const {
  return std::any_of(parameters.begin(), parameters.end(),
                     [](const PooledParameter& parameter) { return parameter.varies(); });
}

void ExpectDifferentRecordings(const std::vector<SingleFit>& fits) {
  for (std::size_t b = 0; b < fits.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      ExpectUsage(fits[a].sha256.empty() || fits[a].sha256 != fits[b].sha256,
                  "--repeat: " + fits[b].name + " is the recording of " + fits[a].name + "; expected each once");
    }
  }
}

Repetitions Pool(const std::vector<SingleFit>& fits, const std::vector<std::string>& names) {
  Repetitions repetitions;
  repetitions.fits = fits;
  for (const std::string& name : names) repetitions.parameters.push_back(PoolParameter(fits, name));
  return repetitions;
}

std::string DifferenceText(ParameterScale scale, double difference) {
  return scale == ParameterScale::kLog ? PercentText(difference, 2) : NumberText(difference, 2);
}

std::string MeanText(const PooledParameter& parameter) {
  return "mean of " + std::to_string(parameter.fits.size()) + " recordings, 95 % interval " +
         NumberText(parameter.lower95) + " .. " + NumberText(parameter.upper95) + "; they scatter by " +
         DifferenceText(parameter.scale, parameter.effects.tau);
}

}  // namespace clothid
