#include "identify/result/uncertainty_json.h"

#include "identify/result/named_json.h"

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

Json IntervalCheckJson(const FitSummary& summary) {
  if (!summary.interval_check) return nullptr;
  const IntervalCheck& check = *summary.interval_check;
  return {{"parameter", summary.parameters[check.parameter].name},
          {"rise_below", check.rise_below},
          {"rise_above", check.rise_above}};
}

// Of parameters, and of directions in their words.
Json BoundChecksJson(const FitSummary& summary) {
  Json json = Json::array();
  for (const BoundCheck& check : summary.bound_checks) {
    json.push_back({{"of", check.parameter >= 0 ? summary.parameters[check.parameter].name
                                                : summary.uncertainty->hidden_directions[check.direction].words},
                    {"rise_below", check.rise_below},
                    {"rise_above", check.rise_above}});
  }
  return json;
}

Json DentsJson(const FitSummary& summary) {
  Json json = Json::object();
  for (const DentCheck& check : summary.dents) {
    json[summary.parameters[check.parameter].name] = {{"step", check.step},
                                                      {"expected_rise", check.expected_rise},
                                                      {"rise_below", check.rise_below},
                                                      {"rise_above", check.rise_above},
                                                      {"is_dent", check.is_dent()}};
  }
  return json;
}

}  // namespace

Json UncertaintyJson(const FitSummary& summary) {
  if (!summary.uncertainty) return nullptr;
  const Uncertainty& uncertainty = *summary.uncertainty;
  Json correlation = Json::object(), directions = Json::array(), visible = Json::object(), distance = Json::object();
  Json widening = Json::object();
  for (std::size_t i = 0; i < summary.parameters.size(); ++i) {
    const Eigen::Index row = static_cast<Eigen::Index>(i);
    correlation[summary.parameters[i].name] = NamedJson(summary.parameters, uncertainty.correlation.row(row));
    visible[summary.parameters[i].name] = uncertainty.parameters[i].visible_change;
    widening[summary.parameters[i].name] = uncertainty.parameters[i].widening;
    distance[summary.parameters[i].name] = uncertainty.parameters[i].distance;
  }
  for (const HiddenDirection& direction : uncertainty.hidden_directions) {
    directions.push_back({{"words", direction.words},
                          {"visible_change", direction.visible_change},
                          {"coordinates", NamedJson(summary.parameters, direction.coordinates)}});
  }
  Json json = {{"residual_scale", uncertainty.residual_scale},
               {"residual_autocorrelation", summary.error.autocorrelation()},
               {"visible_change", visible},
               {"distance_to_minimum", distance},
               {"predicted_decrease", uncertainty.predicted_decrease},
               {"singular_values", uncertainty.singular_values},
               {"correlation", correlation},
               {"hidden_directions", directions},
               {"interval_check", IntervalCheckJson(summary)}};
  if (!summary.bound_checks.empty()) json["bound_checks"] = BoundChecksJson(summary);
  if (!summary.dents.empty()) json["dents"] = DentsJson(summary);
  if (uncertainty.is_widened) json["widening"] = {{"quantile95", uncertainty.quantile95}, {"parameters", widening}};
  return json;
}

}  // namespace clothid
