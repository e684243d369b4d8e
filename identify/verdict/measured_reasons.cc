// Reasons that lie in what cloth can be: estimates far beyond what was measured of any.
#include <algorithm>
#include <string>
#include <vector>

#include "identify/verdict/reason.h"

namespace clothid {
namespace {

// A mistake in what the recording or its scene says.
struct Mistake {
  double factor;      // times the estimate: what it is without the mistake
  const char* words;  // "where .."
};

// Density and stiffness are in proportion to forces.
constexpr Mistake kForceMistakes[] = {{9.80665e-3, "forces are in grams-force, not N"},
                                      {1e-3, "forces are in mN, not N"},
                                      {4.4482216, "forces are in pounds-force, not N"},
                                      {9.80665, "forces are in kilograms-force, not N"},
                                      {1e3, "forces are in kN, not N"}};
// With forces, a stiffness in N/m is in inverse proportion to the width of the cloth.
constexpr Mistake kSizeMistakes[] = {{1e3, "the mesh is in mm, not m"}, {1e2, "the mesh is in cm, not m"}};
// Without, stiffness is in proportion to density.
constexpr Mistake kDensityMistakes[] = {{1e-3, "the density is in g/m^2, not kg/m^2"}};

bool HasForces(const FitSummary& summary) {
  return std::any_of(summary.forces.begin(), summary.forces.end(),
                     [](const Eigen::MatrixXd& forces) { return forces.size() > 0; });
}

std::vector<Mistake> MistakesIn(const FitSummary& summary, const MeasuredConstant& measured) {
  const std::string unit = measured.unit;
  std::vector<Mistake> mistakes;
  if (HasForces(summary)) {
    mistakes.assign(std::begin(kForceMistakes), std::end(kForceMistakes));
    if (unit == "N/m") mistakes.insert(mistakes.end(), std::begin(kSizeMistakes), std::end(kSizeMistakes));
  } else if (unit != "kg/m^2") {
    mistakes.assign(std::begin(kDensityMistakes), std::end(kDensityMistakes));
  }
  return mistakes;
}

// "where forces are in grams-force, not N, it is 395.5": all that bring the estimate to where cloth was measured.
std::string Explanation(const FitSummary& summary, const FittedParameter& parameter) {
  std::vector<std::string> explanations;
  for (const Mistake& mistake : MistakesIn(summary, parameter.measured)) {
    const double value = mistake.factor * parameter.value;
    if (!(value >= parameter.measured.lowest && value <= parameter.measured.highest)) continue;
    explanations.push_back("where " + std::string(mistake.words) + ", it is " + NumberText(value));
  }
  return explanations.empty() ? "check forces, density and size" : JoinWords(explanations);
}

}  // namespace

void AddMeasuredReasons(const FitSummary& summary, std::vector<Reason>* reasons) {
  for (int i = 0; i < static_cast<int>(summary.parameters.size()); ++i) {
    const FittedParameter& parameter = summary.parameters[i];
    const MeasuredConstant& measured = parameter.measured;
    if (parameter.frozen || !measured.IsFarFrom(parameter.value)) continue;
    const double times = std::max(parameter.value / measured.highest, measured.lowest / parameter.value);
    const std::string brief =
        parameter.name + " is " + NumberText(times, 2) + " times beyond what was measured of any cloth";
    const std::string unit = std::string(" ") + measured.unit;
    reasons->push_back(Careful({i}, brief,
                               brief + ": " + NumberText(parameter.value, 5) + unit + " against " +
                                   NumberText(measured.lowest) + " to " + NumberText(measured.highest) + unit + "; " +
                                   Explanation(summary, parameter)));
  }
}

}  // namespace clothid
