#include "identify/result/checks_json.h"

#include <cmath>

#include "identify/prediction/bands.h"
#include "identify/result/named_json.h"
#include "identify/result/transfer_json.h"

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

Json HeldBandsJson(const HeldBands& bands, bool has_only_forces) {
  if (!bands.why_not.empty()) return {{"why_not", bands.why_not}};
  Json json = {{"nominal", kBandQuantiles.back() - kBandQuantiles.front()},
               {"unit", has_only_forces ? "N" : "m"},
               {"draws", bands.num_draws},
               {"failed", bands.num_failed},
               {"with_force", bands.has_force}};
  json.update(HeldBandCellJson(bands.all));
  if (bands.calibration) {
    json["calibration"] = {{"force_factor", bands.calibration->factor}, {"inside", bands.calibration->inside}};
  }
  json["lead_times"] = Json::array();
  for (const HeldBandCell& cell : bands.leads) {
    Json lead = {{"until_s", std::isinf(cell.until) ? Json(nullptr) : Json(cell.until)}};
    lead.update(HeldBandCellJson(cell));
    json["lead_times"].push_back(lead);
  }
  json["recordings"] = HeldRecordingsJson(bands.recordings);
  return json;
}

}  // namespace

Json StepChoiceJson(const StepChoice& choice) {
  Json trials = Json::array();
  double taken = kJsonNull;
  for (const StepTrial& trial : choice.trials) {
    if (choice.found && trial.level == choice.level) taken = trial.time_step;
    trials.push_back(
        {{"time_step", trial.time_step}, {"error_over_noise", trial.error_over_noise}, {"order", trial.order}});
  }
  return {{"chosen", taken}, {"needed", choice.needed}, {"trials", trials}};
}

Json StartsJson(const FitSummary& summary, const FitChecks& checks) {
  if (!checks.starts) return nullptr;
  Json starts = Json::array(), minima = Json::array();
  for (const StartResult& start : checks.starts->starts) {
    const bool has_estimate = start.values.size() > 0;
    starts.push_back({{"start", NamedJson(summary.parameters, start.start)},
                      {"values", NamedJson(summary.parameters, start.values)},
                      {"status", FitStatusName(start.status)},
                      {"cost", has_estimate ? start.cost : kJsonNull},
                      {"rmse_m", has_estimate ? start.rmse : kJsonNull},
                      {"minimum", start.minimum < 0 ? Json(nullptr) : Json(start.minimum)}});
  }
  for (const Minimum& minimum : checks.starts->minima) {
    minima.push_back({{"values", NamedJson(summary.parameters, minimum.values)},
                      {"cost", minimum.cost},
                      {"rmse_m", minimum.rmse},
                      {"num_starts", minimum.num_starts},
                      {"cost_rise", minimum.cost_rise}});
  }
  return {{"starts", starts}, {"minima", minima}};
}

Json ProfilesJson(const FitChecks& checks) {
  if (checks.profiles.empty()) return nullptr;
  Json json = Json::object();
  for (const Profile& profile : checks.profiles) {
    json[profile.parameter] = {{"lower95", profile.lower95},
                               {"upper95", profile.upper95},
                               {"points", profile.points.size()},
                               {"failed", profile.num_failed}};
  }
  return json;
}

Json RepeatedFitJson(const FitSummary& summary, const std::optional<RepeatedFit>& fit) {
  if (!fit) return nullptr;
  return {{"status", FitStatusName(fit->status)},
          {"values", NamedJson(summary.parameters, fit->values)},
          {"changes", NamedJson(summary.parameters, fit->changes)},
          {"rmse_m", fit->has_estimate() ? fit->rmse : kJsonNull}};
}

Json LeadTimesJson(const std::vector<LeadTimeError>& lead_times) {
  Json json = Json::array();
  for (const LeadTimeError& ahead : lead_times) {
    json.push_back({{"lead_s", ahead.lead},
                    {"rmse_m", ahead.rmse},
                    {"still_rmse_m", ahead.still_rmse},
                    {"predictions", ahead.num_predictions}});
  }
  return json;
}

Json HoldoutJson(const FitChecks& checks) {
  const std::optional<Holdout>& holdout = checks.holdout;
  if (!holdout) return nullptr;
  Json json = {{"rmse_m", holdout->rmse}, {"nominal_rmse_m", holdout->nominal_rmse}, {"failed", holdout->has_failed()}};
  if (std::isfinite(holdout->nodes_rmse)) json["nodes_rmse_m"] = holdout->nodes_rmse;
  if (!holdout->lead_times.empty()) json["lead_times"] = LeadTimesJson(holdout->lead_times);
  if (std::isfinite(holdout->nominal_force_rms)) {
    json["force_rms_N"] = holdout->force_rms;
    json["nominal_force_rms_N"] = holdout->nominal_force_rms;
  }
  if (checks.held_bands) json["bands"] = HeldBandsJson(*checks.held_bands, holdout->has_only_forces);
  return json;
}

}  // namespace clothid
