// The text of a result.json as predictions read it, made by hand.
#ifndef CLOTHID_TESTS_IDENTIFY_PREDICTION_RESULT_TEXT_H_
#define CLOTHID_TESTS_IDENTIFY_PREDICTION_RESULT_TEXT_H_

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

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

// A force that the model lacks.
inline nlohmann::ordered_json AssimilationText(double size, double time, double length) {
  using Json = nlohmann::ordered_json;
  const Json force = {{"deviation_N_m2", size}, {"time_s", time}, {"length_m", length}};
  return {{"recordings", Json::array({Json{{"missing_force", force}}})}};
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_IDENTIFY_PREDICTION_RESULT_TEXT_H_
