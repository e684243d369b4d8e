#include "identify/report/wind_json.h"

#include <cmath>
#include <string>

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

Json ListJson(const Eigen::VectorXd& values) {
  Json list = Json::array();
  for (const double value : values) list.push_back(std::isfinite(value) ? Json(value) : Json(nullptr));
  return list;
}

Json ProfileJson(const WindProfile& profile) {
  Json velocities = Json::array();
  for (const auto& velocity : profile.velocities.colwise()) velocities.push_back(ListJson(velocity));
  return {{"times", ListJson(profile.times)}, {"velocities", velocities}};
}

}  // namespace

Json WindJson(const WindResult& result) {
  Json recordings = Json::array();
  for (const WindProfile& profile : result.profiles) {
    recordings.push_back({{"profile", ProfileJson(profile)}, {"fitted", Json::array()}});
  }
  for (const FittedWind& wind : result.winds) {
    recordings[wind.recording]["fitted"].push_back({{"component", std::string(1, "xyz"[wind.axis])},
                                                    {"values", ListJson(wind.values)},
                                                    {"lower95", ListJson(wind.lower95)},
                                                    {"upper95", ListJson(wind.upper95)},
                                                    {"start", ListJson(wind.start)},
                                                    {"knots_told", wind.num_told}});
  }
  return {{"smoothness", result.smoothness > 0.0 ? Json(result.smoothness) : Json(nullptr)},
          {"smoothness_source", SmoothnessWords(result.smoothness_source)},
          {"recordings", recordings}};
}

}  // namespace clothid
