// Reasons that lie in the time step and the mesh.
#include <algorithm>
#include <cmath>

#include "identify/verdict/reason.h"
#include "identify/verdict/told.h"

namespace clothid {
namespace {

// Errors above this many standard deviations of the noise, and above this share of the value, ask for care: it is not
// chance that decides about the estimate.
constexpr double kFarStds = 2.0;
constexpr double kFarShare = 0.01;

double Known(double error) { return std::isnan(error) ? 0.0 : error; }

// Whether a fit was repeated at half the step: then its error is not merely estimated.
bool IsRepeated(const FitChecks& checks) {
  return checks.discretization && checks.discretization->half_step && checks.discretization->half_step->has_estimate();
}

// " (order 1.2; one rollout said +- 0.007)" of the error of the step.
std::string StepText(const FitSummary& summary, const FitChecks& checks, int index) {
  const double order = summary.uncertainty->parameters[index].step_order;
  std::string text = std::isnan(order) ? " (no clear order" : " (order " + NumberText(order, 2);
  if (IsRepeated(checks) && checks.step_error.is_known()) {
    text += "; one rollout said +- " + NumberText(checks.step_error.errors[index], 2);
  }
  return text + ")";
}

// "mu is 0.24 +- 0.004 from noise, +- 0.008 from the time step (order 1.2), +- 0.01 from the mesh", and what to do
// about the largest of them.
std::string PartsText(const FitSummary& summary, const FitChecks& checks, int index) {
  const FittedParameter& parameter = summary.parameters[index];
  const ParameterUncertainty& uncertainty = summary.uncertainty->parameters[index];
  std::string text = parameter.name + " is " + NumberText(parameter.value, 5) + " +- " +
                     NumberText(uncertainty.std, 2) + " from noise";
  const double step = Known(uncertainty.step_error), mesh = Known(uncertainty.mesh_error);
  if (!std::isnan(uncertainty.step_error)) {
    text += ", +- " + NumberText(step, 2) + " from the time step" + StepText(summary, checks, index);
  }
  if (!std::isnan(uncertainty.mesh_error)) text += ", +- " + NumberText(mesh, 2) + " from the mesh";
  if (std::max(step, mesh) > uncertainty.std) {
    text += std::string("; ") + (step >= mesh ? "halve the step" : "refine the mesh") + " before you collect more data";
  }
  return text;
}

// What was asked for is told in any case; what nobody asked for only where it asks for care.
void AddParts(const FitSummary& summary, const FitChecks& checks, int index, std::vector<Reason>* reasons) {
  const FittedParameter& parameter = summary.parameters[index];
  const ParameterUncertainty& uncertainty = summary.uncertainty->parameters[index];
  if (std::isnan(uncertainty.step_error) && std::isnan(uncertainty.mesh_error)) return;
  const double step = Known(uncertainty.step_error), mesh = Known(uncertainty.mesh_error);
  const double largest = std::max(step, mesh);
  const bool is_far = largest > kFarStds * uncertainty.std && largest > kFarShare * std::abs(parameter.value);
  const std::string brief =
      step >= mesh ? "the error of the time step exceeds the noise" : "the error of the mesh exceeds the noise";
  const std::string parts = PartsText(summary, checks, index);
  if (is_far) {
    reasons->push_back(Careful({index}, brief, parts));
  } else if (checks.discretization) {
    reasons->push_back(Remark(parts, {index}));
  }
}

// What the fit `fit` says besides its estimates; `where` as in "at half the time step". `error`: of what, and whether
// there is an estimate of it.
void AddRepeatedEnd(const std::optional<RepeatedFit>& fit, const std::string& where, const std::string& error,
                    bool is_estimated, std::vector<Reason>* reasons) {
  if (!fit || fit->status == FitStatus::kConverged) return;
  const std::string brief = "the fit " + where + " ended as " + FitStatusName(fit->status);
  const std::string meaning = fit->has_estimate() ? "the error of the " + error + " may be another"
                              : is_estimated      ? "intervals count with what one rollout says of the " + error
                                                  : "intervals do not count with the " + error;
  reasons->push_back(Careful({}, brief, brief + ": " + meaning));
}

}  // namespace

void AddDiscretizationReasons(const FitSummary& summary, const FitChecks& checks, std::vector<Reason>* reasons) {
  if (checks.discretization) {
    AddRepeatedEnd(checks.discretization->half_step, "at half the time step", "time step", checks.step_error.is_known(),
                   reasons);
    AddRepeatedEnd(checks.discretization->fine_mesh, "on the finer mesh", "mesh", /*is_estimated=*/false, reasons);
  }
  if (!checks.step_error.failure.empty() && !IsRepeated(checks)) {
    reasons->push_back(
        Remark("intervals do not count with the time step: at another one, " + checks.step_error.failure));
  }
  for (int i = 0; i < static_cast<int>(summary.parameters.size()); ++i) {
    if (HasInterval(summary, checks, i) && !summary.parameters[i].is_knot) AddParts(summary, checks, i, reasons);
  }
}

}  // namespace clothid
