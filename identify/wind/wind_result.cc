#include "identify/wind/wind_result.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <map>
#include <sstream>
#include <tuple>
#include <utility>

#include "costs/prediction/parameter_block.h"

namespace clothid {
namespace {

FittedWind MakeWind(const std::pair<int, int>& recording_and_axis, std::vector<int> parameters,
                    const std::vector<RecordedMotion>& motions, const FitSummary& summary) {
  FittedWind wind;
  std::tie(wind.recording, wind.axis) = recording_and_axis;
  const auto count = static_cast<Eigen::Index>(parameters.size());
  wind.times = motions[wind.recording].scene.wind.profile.times.head(count);
  wind.values.resize(count);
  wind.start.resize(count);
  wind.lower95 = wind.upper95 = Eigen::VectorXd::Constant(count, std::numeric_limits<double>::quiet_NaN());
  for (Eigen::Index k = 0; k < count; ++k) {
    const FittedParameter& parameter = summary.parameters[parameters[k]];
    wind.values[k] = parameter.value;
    wind.start[k] = parameter.start;
    if (!summary.uncertainty) continue;
    const ParameterUncertainty& interval = summary.uncertainty->parameters[parameters[k]];
    wind.num_told += interval.visible ? 1 : 0;
    if (std::isnan(interval.std)) continue;
    wind.lower95[k] = interval.lower95;
    wind.upper95[k] = interval.upper95;
  }
  wind.parameters = std::move(parameters);
  return wind;
}

SmoothnessSource SourceOf(const FitSummary& summary, const FitProblem& problem) {
  for (const SmoothnessPrior& prior : problem.smoothness()) {
    if (prior.name == kWindPrior && !prior.is_chosen) return SmoothnessSource::kGiven;
  }
  const bool is_chosen = std::any_of(summary.plan.begin(), summary.plan.end(), [](const FitStage& stage) {
    return stage.with_weights && stage.state == StageState::kDone;
  });
  return is_chosen ? SmoothnessSource::kChosen : SmoothnessSource::kNotChosen;
}

}  // namespace

const char* SmoothnessWords(SmoothnessSource source) {
  switch (source) {
    case SmoothnessSource::kGiven:
      return "as given";
    case SmoothnessSource::kChosen:
      return "chosen by the marginal likelihood";
    case SmoothnessSource::kNotChosen:
      break;
  }
  return "to start with: the fit ended before a choice";
}

WindResult DescribeWind(const std::vector<RecordedMotion>& motions, const FitSummary& summary,
                        const FitProblem& problem) {
  WindResult result;
  result.smoothness = 1.0 / std::sqrt(problem.WeightOf(kWindPrior));
  result.smoothness_source = SourceOf(summary, problem);
  for (const RecordedMotion& motion : motions) result.profiles.push_back(motion.scene.wind.profile);
  std::map<std::pair<int, int>, std::vector<int>> knots;
  for (int i = 0; i < static_cast<int>(summary.parameters.size()); ++i) {
    const ParameterBlock& block = problem.blocks()[i];
    if (IsWindKnot(block.id)) knots[{std::max(0, block.recording), block.id.axis}].push_back(i);
  }
  for (const auto& [place, parameters] : knots) {
    result.winds.push_back(MakeWind(place, parameters, motions, summary));
    const FittedWind& wind = result.winds.back();
    result.profiles[wind.recording].velocities.row(wind.axis) = wind.values;
  }
  return result;
}

std::string DescribeFittedWind(const FittedWind& wind) {
  std::ostringstream text;
  const auto count = wind.values.size();
  text << std::setprecision(3) << "xyz"[wind.axis] << " over " << count << " knots: " << wind.values.minCoeff()
       << " .. " << wind.values.maxCoeff() << " m/s";
  double narrowest = std::numeric_limits<double>::infinity(), widest = 0.0;
  for (Eigen::Index k = 0; k < count; ++k) {
    const double half = 0.5 * (wind.upper95[k] - wind.lower95[k]);
    if (std::isnan(half)) continue;
    narrowest = std::fmin(narrowest, half);
    widest = std::fmax(widest, half);
  }
  text << std::setprecision(2);
  if (!std::isfinite(narrowest)) return text.str() + ", without intervals";
  text << ", 95 % intervals +- " << narrowest << " .. " << widest << " m/s, told at " << wind.num_told << " of "
       << count << " knots";
  return text.str();
}

}  // namespace clothid
