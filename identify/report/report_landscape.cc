#include "identify/report/report_landscape.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "datasets/observation/observation.h"
#include "identify/base/join_words.h"
#include "identify/landscape/scanned_fit.h"
#include "identify/page/page_template.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kLandscapeDigits = 9;
// Of a cell in the page: a cost with its comma; failed cells take less, but for the reasons.
constexpr std::size_t kBytesPerCell = 16;
// The most windows that a page shows, the whole and the largest zooms.
constexpr int kMaxWindows = 6;
// The most reasons that are told apart; failures often differ in a number alone.
constexpr std::size_t kMaxReasons = 20;
constexpr int kRegionPoints = 72;
// Of a value that is the estimate, but for rounding on another processor.
constexpr double kSameValue = 1e-6;
constexpr double kFullTurn = 2.0 * 3.14159265358979323846;
// The 95 % quantile of chi-square with two degrees of freedom: -2 log 0.05.
constexpr double kChiSquareOfTwo95 = 5.991464547107979;

Json AxisValues(const LandscapeAxis& axis, int every) {
  Json values = Json::array();
  for (int i = 0; i < axis.num_cells; i += every) values.push_back(RoundedJson(axis.Value(i), kLandscapeDigits));
  return values;
}

// The smallest k such that every k-th cell along both axes leaves at most `max_cells` of a window.
int Thinning(const LandscapePlan& plan, std::size_t max_cells) {
  const LandscapeWindow& window = plan.windows.front();
  const auto left = [](int num_cells, int every) { return static_cast<std::size_t>((num_cells + every - 1) / every); };
  int every = 1;
  while (left(window.x.num_cells, every) * left(window.y.num_cells, every) > std::max<std::size_t>(max_cells, 4)) {
    ++every;
  }
  return every;
}

// Failed cells of a window, by their place among those that are shown, with an index into `reasons`.
class Failures {
 public:
  void Add(int place, const std::string& reason) {
    const std::string text = Printable(reason);
    std::size_t index = static_cast<std::size_t>(std::find(reasons_.begin(), reasons_.end(), text) - reasons_.begin());
    if (index == kMaxReasons) {
      reasons_[--index] = "one of many reasons, see landscape.csv";
    } else if (index == reasons_.size()) {
      reasons_.push_back(text);
    }
    failed_.push_back({place, index});
  }
  Json ToJson() const { return {{"cells", failed_}, {"reasons", reasons_}}; }

 private:
  Json failed_ = Json::array();
  std::vector<std::string> reasons_;
};

Json WindowJson(const Landscape& landscape, int index, int every) {
  const LandscapeWindow& window = landscape.plan.windows[index];
  const LandscapeCell* cells = &landscape.cells[landscape.plan.FirstCell(0, index)];
  Json costs = Json::array();
  Failures failures;
  for (int iy = 0; iy < window.y.num_cells; iy += every) {
    for (int ix = 0; ix < window.x.num_cells; ix += every) {
      const LandscapeCell& cell = cells[iy * window.x.num_cells + ix];
      if (!std::isfinite(cell.cost)) failures.Add(static_cast<int>(costs.size()), cell.failure);
      costs.push_back(RoundedJson(cell.cost, kLandscapeDigits));
    }
  }
  return {{"zoom", window.zoom},
          {"every", every},
          {"x", AxisValues(window.x, every)},
          {"y", AxisValues(window.y, every)},
          {"cost", costs},
          {"failures", failures.ToJson()}};
}

bool IsWeighedAsFit(const FitLandscape& landscape, const FitSummary& summary) {
  const std::size_t r = static_cast<std::size_t>(landscape.recording);
  return IsSame(landscape.fit.assimilation, summary.assimilation) &&
         IsSameWeight(landscape.fit.model_error,
                      r < summary.model_errors.size() ? summary.model_errors[r] : ModelError());
}

bool IsEstimate(const std::string& name, double value, const FitSummary& summary) {
  return std::any_of(summary.parameters.begin(), summary.parameters.end(), [&](const FittedParameter& parameter) {
    return parameter.name == name && std::abs(parameter.value - value) <= kSameValue * std::abs(value);
  });
}

// What was fitted as well, but is held elsewhere in all cells.
void AddHeld(const FitLandscape& landscape, const FitSummary& summary, std::vector<std::string>* notes) {
  std::vector<std::string> nominal, moved;
  for (const std::string& name : landscape.others) {
    const auto held = landscape.fit.held.find(BaseName(name));
    if (held == landscape.fit.held.end()) {
      nominal.push_back(name);
    } else if (!IsEstimate(name, held->second, summary)) {
      moved.push_back(name);
    }
  }
  const auto add = [notes](const std::vector<std::string>& names, const char* one, const char* several) {
    if (names.empty()) return;
    notes->push_back("In every cell " + JoinWords(names) + (names.size() == 1 ? one : several) +
                     ", not the estimate: the lowest point of the map need not be that of the fit.");
  };
  add(nominal, " has its nominal value", " have their nominal values");
  add(moved, " has the estimate of another fit", " have the estimates of another fit");
}

// In what the map is of something else than the fit.
std::vector<std::string> Notes(const FitLandscape& landscape, const FitSummary& summary,
                               const std::vector<RecordedMotion>& motions, int every) {
  const RecordedMotion& motion = motions[landscape.recording];
  const std::size_t num_windows = landscape.landscape.plan.windows.size();
  std::vector<std::string> notes;
  if (motions.size() > 1) notes.push_back("It is the cost of " + motion.name + " alone; the fit is of all recordings.");
  AddHeld(landscape, summary, &notes);
  if (!IsWeighedAsFit(landscape, summary)) {
    notes.push_back(
        "The map does not weigh frames as the fit does, by the error of its model: `landscape --result` with the "
        "result.json of this fit does.");
  }
  if (motion.centroid) notes.push_back("Frames that were held out of the fit count in the map.");
  if (motion.start_source == StartSource::kSmoothed) {
    notes.push_back("The map starts at the first frame, the fit at a smoothed one.");
  }
  if (landscape.has_other_sigma) {
    notes.push_back("The costs of the map are of another sigma than those of the fit: `landscape --sigma` sets it.");
  }
  if (landscape.num_other_settings > 0) {
    notes.push_back("Other settings that were scanned, " + std::to_string(landscape.num_other_settings) +
                    ", are left out: `landscape plot` shows them.");
  }
  if (num_windows > kMaxWindows) {
    notes.push_back(std::to_string(kMaxWindows) + " of " + std::to_string(num_windows) + " windows are shown.");
  }
  if (every > 1) {
    notes.push_back("Every " + std::to_string(every) + "th cell along both axes, to keep this file small.");
  }
  return notes;
}

// The rmse of the fit, where a cell with a lower one says something.
double ComparableRmse(const FitLandscape& landscape, const FitSummary& summary,
                      const std::vector<RecordedMotion>& motions) {
  const RecordedMotion& motion = motions[landscape.recording];
  const bool is_same = motions.size() == 1 && !motion.centroid && motion.start_source != StartSource::kSmoothed &&
                       IsWeighedAsFit(landscape, summary);
  return is_same && std::isfinite(landscape.rmse_of_root_cost) ? summary.error.rmse() : std::nan("");
}

// `distance` from the estimate in the internal coordinate, at most up to a bound.
double ValueAt(const LandscapeParameter& parameter, const FitSummary& summary, double distance) {
  const ParameterBlock& block = parameter.block;
  return std::clamp(block.ToValue(summary.coordinates[parameter.index] + distance), block.lower_bound,
                    block.upper_bound);
}

Json RegionJson(const FitLandscape& landscape, const FitSummary& summary, const FitChecks& checks) {
  for (const int index : {landscape.x.index, landscape.y.index}) {
    if (!HasInterval(summary, checks, index)) return nullptr;
  }
  const Eigen::Matrix2Xd region = ConfidenceRegion(landscape, summary);
  if (region.cols() == 0) return nullptr;
  return {{"x", RoundedJson(region.row(0).transpose(), 12)}, {"y", RoundedJson(region.row(1).transpose(), 12)}};
}

}  // namespace

Json LandscapeJson(const FitLandscape& landscape, const FitSummary& summary, const FitChecks& checks,
                   const std::vector<RecordedMotion>& motions, std::size_t max_bytes) {
  const LandscapePlan& plan = landscape.landscape.plan;
  const int num_windows = std::min(static_cast<int>(plan.windows.size()), kMaxWindows);
  const int every = Thinning(plan, max_bytes / (kBytesPerCell * static_cast<std::size_t>(num_windows)));
  const auto axis = [](const LandscapeParameter& parameter, const LandscapeAxis& scanned) {
    return Json{{"parameter", parameter.block.name},
                {"scale", scanned.scale == ParameterScale::kLog ? "log" : "linear"}};
  };
  Json windows = Json::array();
  for (int w = 0; w < num_windows; ++w) windows.push_back(WindowJson(landscape.landscape, w, every));
  return {{"recording", landscape.recording},
          {"x", axis(landscape.x, plan.windows.front().x)},
          {"y", axis(landscape.y, plan.windows.front().y)},
          {"windows", windows},
          {"rmse_of_root_cost", RoundedJson(landscape.rmse_of_root_cost, 12)},
          {"estimate_rmse_m", RoundedJson(ComparableRmse(landscape, summary, motions), kLandscapeDigits)},
          {"region", RegionJson(landscape, summary, checks)},
          {"notes", Notes(landscape, summary, motions, every)}};
}

Eigen::Matrix2Xd ConfidenceRegion(const FitLandscape& landscape, const FitSummary& summary) {
  if (!summary.uncertainty) return {};
  const Uncertainty& uncertainty = *summary.uncertainty;
  const double x_std = uncertainty.parameters[landscape.x.index].coordinate_std;
  const double y_std = uncertainty.parameters[landscape.y.index].coordinate_std;
  const double correlation = uncertainty.correlation(landscape.x.index, landscape.y.index);
  if (!std::isfinite(x_std) || !std::isfinite(y_std) || !std::isfinite(correlation)) return {};
  const double radius = std::sqrt(kChiSquareOfTwo95) * uncertainty.quantile95 / kNormal95;
  const double across = std::sqrt(std::max(0.0, 1.0 - correlation * correlation));
  Eigen::Matrix2Xd region(2, kRegionPoints + 1);
  for (int i = 0; i <= kRegionPoints; ++i) {
    // A Cholesky factor of the correlation: (1, 0; c, sqrt(1 - c^2)).
    const double angle = kFullTurn * (i % kRegionPoints) / kRegionPoints;
    const double u = radius * std::cos(angle), v = radius * (correlation * std::cos(angle) + across * std::sin(angle));
    region(0, i) = ValueAt(landscape.x, summary, x_std * u);
    region(1, i) = ValueAt(landscape.y, summary, y_std * v);
  }
  return region;
}

}  // namespace clothid
