// Reasons that lie in what was believed of parameters before.
#include "identify/verdict/reason.h"

namespace clothid {
namespace {

// Residuals may be so many times larger or smaller than sigma before the weight of a prior is worth a word.
constexpr double kOtherNoise = 2.0;

void AddDisagreement(const FittedParameter& parameter, const ToldBesidePrior& told, int index,
                     std::vector<Reason>* reasons) {
  if (!told.disagrees()) return;
  const std::string brief = "the recording contradicts the prior of " + parameter.name;
  reasons->push_back(Careful({index}, brief,
                             brief + ": without the prior it would be about " + NumberText(told.other_value, 3) + ", " +
                                 NumberText(told.disagreement, 2) + " joint standard deviations from " +
                                 PriorText(parameter.prior, parameter.scale)));
}

void AddReliance(const FittedParameter& parameter, const ToldBesidePrior& told, int index,
                 std::vector<Reason>* reasons) {
  if (!told.adds_nothing() && told.is_told) return;
  const std::string brief = told.adds_nothing() ? "the recording adds nothing to what was believed of " + parameter.name
                                                : parameter.name + " is not identifiable without its prior";
  reasons->push_back(Careful({index}, brief,
                             brief + ": its standard deviation is " + NumberText(told.share, 2) +
                                 " of that of the prior, " + PriorText(parameter.prior, parameter.scale)));
}

// The estimate weighs priors, whose standard deviations count as true, against residuals over sigma.
void AddWeight(const FitSummary& summary, std::vector<Reason>* reasons) {
  const double scale = summary.uncertainty->residual_scale;
  if (!(scale > kOtherNoise || scale < 1.0 / kOtherNoise)) return;
  const std::string brief =
      scale > 1.0 ? "priors count for less than they are worth" : "priors count for more than they are worth";
  reasons->push_back(Careful({}, brief,
                             brief + ": they are weighed against sigma, and residuals are " + NumberText(scale, 2) +
                                 " times as large; --sigma with what they are weighs them right"));
}

// Knots of the wind that only their neighbours tell.
void AddKnots(const FitSummary& summary, std::vector<Reason>* reasons) {
  std::vector<int> knots, believed;
  for (int i = 0; i < static_cast<int>(summary.parameters.size()); ++i) {
    if (!summary.parameters[i].is_knot) continue;
    knots.push_back(i);
    if (!summary.uncertainty->parameters[i].visible) believed.push_back(i);
  }
  if (believed.empty()) return;
  const std::string count = std::to_string(believed.size()) + " of " + std::to_string(knots.size()) + " knots";
  const std::string brief = "the recordings do not determine the wind at " + count;
  const std::string line = brief + ", " + NamesText(summary, believed) +
                           ": there it is what was believed of it beside its neighbours, that it changes little";
  reasons->push_back((believed.size() == knots.size() ? NotTold : Careful)(believed, brief, line));
}

}  // namespace

void AddPriorReasons(const FitSummary& summary, std::vector<Reason>* reasons) {
  if (!summary.uncertainty) return;
  AddKnots(summary, reasons);
  bool has_prior = false;
  for (int i = 0; i < static_cast<int>(summary.parameters.size()); ++i) {
    const FittedParameter& parameter = summary.parameters[i];
    has_prior = has_prior || parameter.prior.is_given();
    const auto& told = summary.uncertainty->parameters[i].beside_prior;
    if (!told || summary.uncertainty->parameters[i].stalled) continue;
    AddDisagreement(parameter, *told, i, reasons);
    AddReliance(parameter, *told, i, reasons);
  }
  if (has_prior) AddWeight(summary, reasons);
}

}  // namespace clothid
