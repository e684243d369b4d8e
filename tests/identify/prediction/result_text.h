// The text of a result.json as predictions read it, made by hand.
#ifndef CLOTHID_TESTS_IDENTIFY_PREDICTION_RESULT_TEXT_H_
#define CLOTHID_TESTS_IDENTIFY_PREDICTION_RESULT_TEXT_H_

#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace clothid {

struct ToldParameter {
  double value = 0.0, std = 0.0;
  double widening = 1.0;  // of the interval beyond that of the noise
  bool is_log = true;
};

// Parameters that are uncorrelated, with intervals.
inline nlohmann::ordered_json ResultText(const std::map<std::string, ToldParameter>& parameters) {
  using Json = nlohmann::ordered_json;
  Json json = {{"schema", "clothid.result/1"}, {"status", "converged"}, {"parameters", Json::object()}};
  for (const auto& [name, told] : parameters) {
    const double half = 1.959963984540054 * told.widening * (told.is_log ? told.std / told.value : told.std);
    json["parameters"][name] = {{"value", told.value},
                                {"std", told.std},
                                {"lower95", told.is_log ? told.value * std::exp(-half) : told.value - half},
                                {"upper95", told.is_log ? told.value * std::exp(half) : told.value + half},
                                {"lower_bound", told.is_log ? 1e-6 * told.value : 0.0},
                                {"upper_bound", told.is_log ? 1e6 * told.value : 2.0},
                                {"scale", told.is_log ? "log" : "linear"}};
    for (const auto& [other, ignored] : parameters) {
      json["uncertainty"]["correlation"][name][other] = name == other ? 1.0 : 0.0;
    }
  }
  json["cloth"] = {{"membrane", "arap"}, {"bending", "patches"}};
  return json;
}

// Forces that the model lacks: their sizes, times and lengths.
inline nlohmann::ordered_json ForcesText(const std::vector<std::array<double, 3>>& forces) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const auto& [size, time, length] : forces) {
    json.push_back({{"deviation_N_m2", size}, {"time_s", time}, {"length_m", length}});
  }
  return json;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_IDENTIFY_PREDICTION_RESULT_TEXT_H_
