#include "identify/result/corrections_json.h"

#include "identify/base/model_error_json.h"
#include "identify/result/checks_json.h"
#include "identify/result/named_json.h"

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

Json CorrectionCheckJson(const CorrectionCheck& check) {
  const MissingForce& missing = check.missing_force;
  return {{"innovation_rmse_m", check.innovations.rmse()},
          {"innovation_correlation", check.innovations.autocorrelation()},
          {"missing_force",
           {{"rms_N_m2", missing.size},
            {"deviation_N_m2", missing.lasting.size},
            {"time_s", missing.lasting.time},
            {"length_m", missing.lasting.length},
            {"weight_N_m2", missing.weight},
            {"largest_in_frame_N_m2", missing.largest_in_frame},
            {"frame", missing.frame},
            {"largest_at_node_N_m2", missing.largest_at_node},
            {"node", missing.node}}}};
}

}  // namespace

Json CorrectionsJson(const FitSummary& summary, const FitChecks& checks) {
  Json trials = Json::array(), drift = Json::object();
  for (const MemoryTrial& trial : summary.memory_trials) {
    trials.push_back({{"memory_s", trial.memory},
                      {"values", NamedJson(summary.parameters, trial.values)},
                      {"lower95", NamedJson(summary.parameters, trial.lower95)},
                      {"upper95", NamedJson(summary.parameters, trial.upper95)},
                      {"coordinate_stds", NamedJson(summary.parameters, trial.std)},
                      {"residual_scale", trial.residual_scale}});
  }
  for (std::size_t i = 0; summary.uncertainty && i < summary.parameters.size(); ++i) {
    drift[summary.parameters[i].name] = summary.uncertainty->parameters[i].memory_error;
  }
  Json json = AssimilationJson(summary.assimilation);
  json["lead_times"] = LeadTimesJson(checks.lead_times);
  json["recordings"] = Json::array();
  for (const CorrectionCheck& check : checks.corrections) json["recordings"].push_back(CorrectionCheckJson(check));
  json["uncorrected_rmse_m"] = checks.uncorrected_error ? checks.uncorrected_error->rmse() : kJsonNull;
  json["drift"] = drift;
  json["trials"] = trials;
  return json;
}

Json LastingForcesJson(const std::vector<LastingForce>& forces) {
  Json json = Json::array();
  for (const LastingForce& force : forces) {
    json.push_back({{"deviation_N_m2", force.size}, {"time_s", force.time}, {"length_m", force.length}});
  }
  return json;
}

}  // namespace clothid
