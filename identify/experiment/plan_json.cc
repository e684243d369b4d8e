// A plan as plan.json: see the header for the keys.
#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/base/source_names.h"
#include "identify/base/version.h"
#include "identify/experiment/experiment_plan.h"

namespace clothid {
namespace {

// JSON text has null for NaN.
using Json = nlohmann::ordered_json;

Json ParameterJson(const ExpectedParameter& parameter) {
  return {{"in_scene", parameter.is_in_scene},
          {"scale", parameter.scale == ParameterScale::kLog ? "log" : "linear"},
          {"value", parameter.value},
          {"told", parameter.is_told},
          {"told_share", parameter.told_share},
          {"std", parameter.std},
          {"known_start_std", parameter.known_start_std},
          {"step_error", parameter.step_error},
          {"lower95", parameter.lower95},
          {"upper95", parameter.upper95},
          {"share_of_belief", parameter.share_of_belief},
          {"not_told", parameter.not_told},
          {"made_up_by", parameter.made_up_by}};
}

Json ParametersJson(const std::vector<ExpectedParameter>& parameters) {
  Json json = Json::object();
  for (const ExpectedParameter& parameter : parameters) json[parameter.name] = ParameterJson(parameter);
  return json;
}

Json ImprovementsJson(const Plan& plan, const CandidatePlan& candidate) {
  Json json = Json::array();
  for (const Improvement& improvement : candidate.improvements) {
    Json factors = Json::object();
    for (std::size_t i = 0; i < plan.parameters.size(); ++i) {
      factors[plan.parameters[i]] = improvement.factors[static_cast<Eigen::Index>(i)];
    }
    Json entry = {{"what", ImprovementName(improvement.kind)}};
    if (improvement.partner >= 0) entry["with"] = plan.candidates[static_cast<std::size_t>(improvement.partner)].name;
    entry["of"] = improvement.kind == ImprovementKind::kHalfStep ? "interval" : "noise";
    entry["worst"] = improvement.worst;
    entry["factors"] = factors;
    entry["tells"] = improvement.tells;
    json.push_back(entry);
  }
  return json;
}

Json ColumnJson(const Eigen::MatrixXd& matrix, Eigen::Index column) {
  return Json(std::vector<double>(matrix.col(column).begin(), matrix.col(column).end()));
}

Json MapJson(const Plan& plan, const InformationMap& map) {
  Json parameters = Json::object();
  for (std::size_t k = 0; k < map.columns.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    parameters[plan.parameters[static_cast<std::size_t>(map.columns[k])]] = {
        {"nodes", ColumnJson(map.per_node, column)},
        {"frames", ColumnJson(map.per_frame, column)},
        {"forces", map.of_forces[column]}};
  }
  return {{"times_s", std::vector<double>(map.times.begin(), map.times.end())}, {"parameters", parameters}};
}

Json CandidateJson(const Plan& plan, const CandidatePlan& candidate, const std::string& path) {
  Json json = {{"name", candidate.name}, {"scene", path}};
  json["failure"] = candidate.failure.empty() ? Json(nullptr) : Json(candidate.failure);
  if (!candidate.failure.empty()) return json;
  json["start"] = StartSourceName(candidate.start);
  json["duration_s"] = candidate.duration;
  json["time_step_s"] = candidate.time_step;
  json["frames"] = candidate.num_frames;
  json["points"] = candidate.num_points;
  json["nodes"] = candidate.num_nodes;
  json["cloths"] = candidate.num_cloths;
  json["failed_cloths"] = candidate.failed_cloths;
  json["worst_told"] = plan.parameters[static_cast<std::size_t>(candidate.worst_told)];
  json["parameters"] = ParametersJson(candidate.parameters);
  if (!plan.predicted.empty()) json["prediction_width_m"] = candidate.prediction_width;
  json["improvements"] = ImprovementsJson(plan, candidate);
  json["information"] = MapJson(plan, candidate.map);
  return json;
}

Json RecordedJson(const PlanOptions& options) {
  return {{"sigma_m", options.sigma},
          {"frame_rate_hz", options.frame_rate},
          {"markers", options.num_markers},
          {"forces", options.has_forces},
          {"force_sigma_n", options.force_sigma},
          {"handle_sigma_m", options.handle_sigma},
          {"initial", StartSourceName(options.start)},
          {"draws", options.num_draws},
          {"seed", options.seed}};
}

}  // namespace

std::string PlanJson(const PlanOptions& options, const Plan& plan) {
  Json json;
  json["schema"] = "clothid.plan/1";
  json["recorded"] = RecordedJson(options);
  json["parameters"] = plan.parameters;
  json["candidates"] = Json::array();
  for (std::size_t c = 0; c < plan.candidates.size(); ++c) {
    json["candidates"].push_back(CandidateJson(plan, plan.candidates[c], options.scene_paths[c]));
  }
  json["pairs"] = Json::array();
  for (const PairPlan& pair : plan.pairs) {
    json["pairs"].push_back({{"candidates",
                              {plan.candidates[static_cast<std::size_t>(pair.first)].name,
                               plan.candidates[static_cast<std::size_t>(pair.second)].name}},
                             {"cloths", pair.num_cloths},
                             {"parameters", ParametersJson(pair.parameters)}});
    if (!plan.predicted.empty()) json["pairs"].back()["prediction_width_m"] = pair.prediction_width;
  }
  if (!plan.predicted.empty()) {
    json["prediction"] = {
        {"name", plan.predicted}, {"scene", options.predicted_path}, {"believed_width_m", plan.believed_width}};
  }
  json["provenance"] = {{"version", Version()}, {"git", GitHash()}, {"flags", options.command_line}};
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace clothid
