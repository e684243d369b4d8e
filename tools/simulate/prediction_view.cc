#include "tools/simulate/prediction_view.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "identify/base/join_words.h"

namespace clothid {
namespace {

using Line = std::pair<std::string, Eigen::VectorXd>;

std::vector<Line> ShareLines(const Prediction& prediction) {
  const SpreadShares& shares = prediction.shares;
  const std::vector<Line> all = {{"parameters", 100.0 * shares.parameters},
                                 {"step and mesh", 100.0 * shares.finer},
                                 {"start", 100.0 * shares.start},
                                 {"handles", 100.0 * shares.handles},
                                 {prediction.has_force ? "force" : "not linear", 100.0 * shares.rest}};
  std::vector<Line> lines;
  for (const Line& line : all) {
    if ((line.second.array() > 0.0).any()) lines.push_back(line);
  }
  return lines;
}

void AddDerivedCharts(const DerivedBands& bands, const Eigen::VectorXd& times, std::vector<ViewChart>* charts) {
  if (bands.request.kind == DerivedKind::kSlip) return;
  constexpr const char* kAxes[] = {" x", " y", " z"};
  const Eigen::Index num_rows = bands.quantiles[0].rows();
  for (Eigen::Index row = 0; row < num_rows; ++row) {
    std::string name = bands.request.name;
    if (num_rows > 3) name += " " + std::to_string(row / 3 + 1);
    if (num_rows >= 3) name += kAxes[row % 3];
    charts->push_back({name,
                       UnitOf(bands.request.kind),
                       times,
                       {{"5 %", bands.quantiles[0].row(row).transpose()},
                        {"median", bands.quantiles[2].row(row).transpose()},
                        {"95 %", bands.quantiles[4].row(row).transpose()}}});
  }
}

std::string DominatesText(const Prediction& prediction) {
  const std::vector<Line> lines = ShareLines(prediction);
  if (lines.empty()) return "Nothing spreads it.";
  const Eigen::Index last = prediction.times.size() - 1;
  const auto largest = std::max_element(
      lines.begin(), lines.end(), [last](const Line& a, const Line& b) { return a.second[last] < b.second[last]; });
  return "At the end " + largest->first + " makes " + NumberText(largest->second[last], 2) +
         " % of the squared spread, the most of all.";
}

}  // namespace

PredictionView ViewOf(const FitPosterior& posterior, const Prediction& prediction) {
  PredictionView view;
  const double until = prediction.WorthUntil();
  view.status = "worth more than the cloth at rest " +
                (std::isinf(until) ? std::string("to the end") : "until " + NumberText(until, 3) + " s");
  std::vector<std::string> drawn;
  for (const PosteriorParameter& parameter : posterior.parameters) drawn.push_back(parameter.name);
  view.facts = {std::to_string(prediction.num_draws) + " rollouts with parameters of the fit" +
                    (drawn.empty() ? "" : ": " + JoinWords(drawn)) + ".",
                DominatesText(prediction)};
  if (!posterior.warning.empty()) view.facts.push_back("The fit says: " + posterior.warning);
  const auto num_shown = std::min<std::size_t>(kShownCloths, prediction.cloths.size());
  view.cloths.assign(prediction.cloths.begin(), prediction.cloths.begin() + static_cast<std::ptrdiff_t>(num_shown));
  view.charts = {{"deviation",
                  "mm",
                  prediction.times,
                  {{"of draws", 1e3 * prediction.spread}, {"moved since the start", 1e3 * prediction.moved}}},
                 {"share", "%", prediction.times, ShareLines(prediction)}};
  if (view.charts.back().lines.empty()) view.charts.pop_back();
  for (const DerivedBands& bands : prediction.derived) AddDerivedCharts(bands, prediction.times, &view.charts);
  return view;
}

}  // namespace clothid
