// Reasons that lie in repetitions: whether the recordings differ by more than their intervals say, and which of them
// does not fit the others.
#include <algorithm>
#include <cmath>

#include "identify/verdict/reason.h"
#include "identify/verdict/repetition_text.h"

namespace clothid {
namespace {

std::vector<int> IndicesOf(const FitSummary& summary, const std::string& name) {
  for (std::size_t i = 0; i < summary.parameters.size(); ++i) {
    if (summary.parameters[i].name == name) return {static_cast<int>(i)};
  }
  return {};
}

std::string TypicalText(const PooledParameter& parameter) {
  return DifferenceText(parameter.scale, parameter.effects.typical_std);
}

// "recordings differ by 12 % in k_stretch, their intervals explain 3 %: material, set-up or model varies"
std::string DifferBrief(const Repetitions& repetitions) {
  std::vector<std::string> parts;
  std::string explained;
  for (const PooledParameter& parameter : repetitions.parameters) {
    if (!parameter.varies()) continue;
    explained += (explained.empty() ? "" : ", ") + TypicalText(parameter);
    parts.push_back(DifferenceText(parameter.scale, parameter.effects.scatter()) + " in " + parameter.name);
  }
  return "recordings differ by " + JoinWords(parts) + ", their intervals explain " + explained +
         ": material, set-up or model varies";
}

std::string RangeText(double lower, double upper) { return NumberText(lower) + " .. " + NumberText(upper); }

std::string NextText(const PooledParameter& parameter) {
  if (std::isnan(parameter.next_lower95)) return "three recordings would tell of the next specimen";
  return RangeText(parameter.next_lower95, parameter.next_upper95) + " for the next specimen";
}

std::string ScatterText(const PooledParameter& parameter) {
  const RandomEffects& effects = parameter.effects;
  const auto text = [&](double tau) { return DifferenceText(parameter.scale, tau); };
  return "scatter " + text(effects.tau) + ", 95 % interval " + text(effects.tau_lower95) + " .. " +
         text(effects.tau_upper95);
}

std::string ProbabilityText(double probability) {
  constexpr double kLeastShown = 1e-6;
  return probability < kLeastShown ? "below 1e-6" : NumberText(probability, 2);
}

// An error that is larger than what is told of noise, and that explains no difference.
std::string CommonText(const PooledParameter& parameter) {
  const RandomEffects& effects = parameter.effects;
  if (!(effects.common_error > effects.typical_std)) return "";
  return "; the error of time step and mesh, " + DifferenceText(parameter.scale, effects.common_error) +
         ", is common to all";
}

std::string VariesLine(const PooledParameter& parameter) {
  const RandomEffects& effects = parameter.effects;
  return parameter.name + " differs by " + DifferenceText(parameter.scale, effects.scatter()) +
         " between recordings, their intervals explain " + TypicalText(parameter) + " (" + ScatterText(parameter) +
         "; by chance with probability " + ProbabilityText(effects.p_value) + CommonText(parameter) +
         "): take the mean " + NumberText(parameter.mean) + " (" + RangeText(parameter.lower95, parameter.upper95) +
         "), and " + NextText(parameter);
}

std::string AgreesLine(const PooledParameter& parameter) {
  return parameter.name + " differs between recordings by no more than their intervals say (" + ScatterText(parameter) +
         "): mean " + NumberText(parameter.mean) + " (" + RangeText(parameter.lower95, parameter.upper95) + "), " +
         NextText(parameter);
}

constexpr char kNotPooled[] = "told by fewer than two recordings";

std::string NotPooledLine(const PooledParameter& parameter) {
  return parameter.name + " is " + kNotPooled + " alone: nothing is known of how it varies";
}

// A joint fit may tell what no recording does alone.
void AddNotPooled(const PooledParameter& parameter, const std::vector<int>& indices, bool is_of_folders,
                  std::vector<Reason>* reasons) {
  const std::string line = NotPooledLine(parameter);
  reasons->push_back(is_of_folders ? NotTold(indices, kNotPooled, line)
                                   : Careful(indices, parameter.name + " is " + kNotPooled + " alone", line));
}

void AddMisfits(const Repetitions& repetitions, const PooledParameter& parameter, const std::vector<int>& indices,
                std::vector<Reason>* reasons) {
  for (std::size_t k = 0; k < parameter.fits.size(); ++k) {
    const LeftOutEstimate& left_out = parameter.effects.left_out[k];
    if (left_out.fits) continue;
    const std::string brief =
        repetitions.fits[static_cast<std::size_t>(parameter.fits[k])].name + " does not fit the others";
    reasons->push_back(Careful(indices, brief,
                               brief + ": its " + parameter.name + " is " +
                                   NumberText(std::abs(left_out.deviation), 3) +
                                   " joint standard deviations from their mean"));
  }
}

void AddNotUsed(const Repetitions& repetitions, std::vector<Reason>* reasons) {
  for (const SingleFit& fit : repetitions.fits) {
    if (fit.why_not_used.empty()) continue;
    reasons->push_back(Careful({}, fit.name + " was left out of the repetitions",
                               fit.name + " was left out of the repetitions: its fit: " + fit.why_not_used));
  }
}

}  // namespace

std::string RepetitionLine(const PooledParameter& parameter) {
  if (!parameter.is_pooled()) return NotPooledLine(parameter);
  return parameter.varies() ? VariesLine(parameter) : AgreesLine(parameter);
}

void AddRepetitionReasons(const FitSummary& summary, const FitChecks& checks, std::vector<Reason>* reasons) {
  if (!checks.repetitions) return;
  const Repetitions& repetitions = *checks.repetitions;
  for (const PooledParameter& parameter : repetitions.parameters) {
    const std::vector<int> indices = IndicesOf(summary, parameter.name);
    if (indices.empty()) continue;
    if (!parameter.is_pooled()) {
      AddNotPooled(parameter, indices, repetitions.is_of_folders, reasons);
    } else if (parameter.varies()) {
      reasons->push_back(Careful(indices, DifferBrief(repetitions), RepetitionLine(parameter)));
    } else {
      reasons->push_back(Remark(RepetitionLine(parameter), indices));
    }
  }
  for (const PooledParameter& parameter : repetitions.parameters) {
    const std::vector<int> indices = IndicesOf(summary, parameter.name);
    if (parameter.is_pooled() && !indices.empty()) AddMisfits(repetitions, parameter, indices, reasons);
  }
  AddNotUsed(repetitions, reasons);
}

}  // namespace clothid
