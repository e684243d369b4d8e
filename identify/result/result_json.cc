#include "identify/result/result_json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "identify/base/cloth_laws.h"
#include "identify/base/model_error_json.h"
#include "identify/base/source_names.h"
#include "identify/base/version.h"
#include "identify/result/checks_json.h"
#include "identify/result/corrections_json.h"
#include "identify/result/named_json.h"
#include "identify/result/repetition_json.h"
#include "identify/result/transfer_json.h"
#include "identify/result/uncertainty_json.h"
#include "identify/result/varying_json.h"

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

// What was believed, and what was told beside it; null where the estimate stands at its bound.
Json PriorJson(const FitSummary& summary, std::size_t index) {
  const FittedParameter& parameter = summary.parameters[index];
  const bool is_log = parameter.scale == ParameterScale::kLog;
  Json json = {{is_log ? "median" : "mean", parameter.prior.center},
               {is_log ? "factor" : "std", parameter.prior.spread}};
  for (const char* key : {"share", "adds_nothing", "value_without", "disagreement"}) json[key] = nullptr;
  if (!summary.uncertainty || !summary.uncertainty->parameters[index].beside_prior) return json;
  const ToldBesidePrior& told = *summary.uncertainty->parameters[index].beside_prior;
  json["share"] = told.share;
  json["adds_nothing"] = told.adds_nothing();
  json["value_without"] = told.other_value;
  json["disagreement"] = told.disagreement;
  return json;
}

Json ParametersJson(const FitSummary& summary, const FitChecks& checks, const Verdict& verdict) {
  Json json = Json::object();
  for (std::size_t i = 0; i < summary.parameters.size(); ++i) {
    const FittedParameter& parameter = summary.parameters[i];
    const ParameterUncertainty uncertainty =
        summary.uncertainty ? summary.uncertainty->parameters[i] : ParameterUncertainty();
    const std::optional<bool> identifiable = IsIdentifiable(summary, checks, static_cast<int>(i));
    const bool has_interval = HasInterval(summary, checks, static_cast<int>(i));
    const bool has_end = has_interval || HasExcludedSide(summary, checks, static_cast<int>(i));
    const auto shown = [&](double value) { return has_interval ? value : kJsonNull; };
    json[parameter.name] = {{"value", parameter.value},
                            {"std", shown(uncertainty.std)},
                            {"lower95", has_end ? uncertainty.lower95 : kJsonNull},
                            {"upper95", has_end ? uncertainty.upper95 : kJsonNull},
                            {"start", parameter.start},
                            {"lower_bound", parameter.lower_bound},
                            {"upper_bound", parameter.upper_bound},
                            {"scale", parameter.scale == ParameterScale::kLog ? "log" : "linear"},
                            {"frozen", parameter.frozen},
                            {"at_bound", parameter.at_bound},
                            {"identifiable", identifiable ? Json(*identifiable) : Json(nullptr)},
                            {"usable", UsabilityName(verdict.parameters[i])}};
    if (parameter.prior.is_given()) json[parameter.name]["prior"] = PriorJson(summary, i);
    if (checks.discretization || checks.step_error.is_known()) {
      json[parameter.name]["step_error"] = shown(uncertainty.step_error);
      json[parameter.name]["step_order"] = shown(uncertainty.step_order);
    }
    if (checks.discretization) json[parameter.name]["mesh_error"] = shown(uncertainty.mesh_error);
    if (!std::isnan(uncertainty.stall_error)) json[parameter.name]["stall_error"] = uncertainty.stall_error;
    if (!summary.starts.empty()) json[parameter.name]["known_start_std"] = uncertainty.known_start_std;
  }
  return json;
}

// Of point clouds: distances from points to the predicted surface.
Json CloudJson(const CloudError& error) {
  Json json = {{"rmse_m", error.rmse()},
               {"num_points", static_cast<long long>(error.num_points)},
               {"far_share", error.num_far / error.num_points},
               {"far_sigmas", kFarFromSurface}};
  if (error.num_tracked > 0.0) json["nodes_rmse_m"] = error.node_rmse();
  if (error.num_border > 0.0) json["border_rmse_m"] = error.border_rmse();
  return json;
}

// Of forces at handles, whose error is no part of `rmse_m`.
Json ForceJson(const ForceError& error, const ForceError& start) {
  return {{"rms_N", error.rms()},
          {"start_rms_N", start.rms()},
          {"num_components", static_cast<long long>(error.num_components)}};
}

void AddErrors(const FitSummary& summary, Json* json) {
  (*json)["rmse_m"] = summary.error.rmse();
  (*json)["fit_percent"] = summary.error.fit_percent();
  if (summary.error.cloud.num_points > 0.0) (*json)["cloud"] = CloudJson(summary.error.cloud);
  if (summary.error.force.num_components > 0.0) {
    (*json)["force"] = ForceJson(summary.error.force, summary.start_error.force);
  }
}

// Per recording, of what the fit's loss discounts; null where that makes no difference.
Json DiscountedJson(const FitChecks& checks) {
  Json json = Json::array();
  for (const RecordingFit& recording : checks.recordings) {
    json.push_back(nullptr);
    if (!recording.discounted) continue;
    json.back() = {{"share", recording.discounted->share},
                   {"rmse_m", recording.discounted->error.rmse()},
                   {"fit_percent", recording.discounted->error.fit_percent()}};
  }
  return json;
}

Json GradientCheckJson(const std::optional<GradientCheck>& check) {
  if (!check) return nullptr;
  return {{"adjoint_vs_sensitivity", check->adjoint_vs_sensitivity}, {"adjoint_vs_fd", check->adjoint_vs_fd}};
}

Json ContactEventsJson(const RolloutCounts& counts) {
  Json json = {{"contacts", counts.contacts},
               {"nodes_joined", counts.nodes_joined},
               {"nodes_left", counts.nodes_left},
               {"branch_switches", counts.branch_switches},
               {"obstacle_switches", counts.obstacle_switches}};
  if (counts.self_contacts == 0 && counts.pair_changes == 0) return json;
  json["self_contacts"] = counts.self_contacts;
  json["pair_changes"] = counts.pair_changes;
  return json;
}

// Whether the user had a say in what is assumed about a recording.
bool IsToldMore(const std::vector<RecordedMotion>& motions) {
  return std::any_of(motions.begin(), motions.end(), [](const RecordedMotion& motion) {
    return motion.sigma_source == SigmaSource::kGiven || motion.sigma_source == SigmaSource::kEstimated ||
           (motion.start_source != StartSource::kScene && motion.start_source != StartSource::kFirstFrame);
  });
}

// What was assumed about every recording: the mean over its points of the sigma of residuals, and the start.
Json RecordingsJson(const FitSummary& summary, const std::vector<RecordedMotion>& motions) {
  Json json = Json::array();
  for (const RecordedMotion& motion : motions) {
    const double sigma = motion.sigma.size() > 0 ? motion.sigma.mean() : kJsonNull;
    json.push_back({{"sigma_source", SigmaSourceName(motion.sigma_source)},
                    {"sigma_m", sigma},
                    {"initial", StartSourceName(motion.start_source)}});
  }
  for (const StartEstimate& start : summary.starts) {
    json[start.recording]["start"] = {{"moved_m", start.moved},
                                      {"std_m", start.position_std},
                                      {"first_frame_error_m", start.first_frame_error},
                                      {"handles_moved_m", start.handles_moved},
                                      {"handle_std_m", start.handle_std},
                                      {"handle_interval_s", start.handle_interval},
                                      {"handle_error_stds", start.handle_error},
                                      {"speed_change_m_s", start.speed_change},
                                      {"velocity_std_m_s", start.velocity_std}};
  }
  return json;
}

Json ModelErrorsJson(const std::vector<ModelError>& errors) {
  Json json = Json::array();
  for (const ModelError& error : errors) json.push_back(ModelErrorJson(error));
  return json;
}

// Of every recording what is graver than ok; null where nothing is, or nothing was checked.
Json FindingsOfRecordings(const FitChecks& checks) {
  Json json = Json::array();
  bool is_ok = true;
  for (const std::vector<Finding>& findings : checks.findings) {
    Json of_recording = Json::array();
    for (const Finding& finding : findings) {
      if (finding.severity == Severity::kOk) continue;
      of_recording.push_back({{"what", finding.what},
                              {"verdict", SeverityName(finding.severity)},
                              {"value", finding.value},
                              {"hint", finding.hint}});
    }
    is_ok = is_ok && of_recording.empty();
    json.push_back(of_recording);
  }
  return is_ok ? Json(nullptr) : json;
}

// What its constants are of.
Json ClothJson(const Scene& scene) {
  const char* const bending = BendingWord(scene);
  return {{"membrane", MembraneWord(scene)}, {"bending", bending == nullptr ? Json(nullptr) : Json(bending)}};
}

Json PlanJson(const FitPlan& plan) {
  Json stages = Json::array();
  for (const FitStage& stage : plan) {
    stages.push_back({{"stage", stage.Words()},
                      {"frames", stage.share},
                      {"memory_s", stage.memory > 0.0 ? stage.memory : kJsonNull},
                      {"precision", stage.precision == Precision::kLoose ? "loose" : "full"},
                      {"state", StageStateName(stage.state)},
                      {"note", stage.note},
                      {"rollouts", stage.rollouts},
                      {"cost", stage.cost}});
  }
  return stages;
}

Json ProvenanceJson(const FitChecks& checks, const std::vector<RecordedMotion>& motions) {
  std::string sha256;
  for (const RecordedMotion& motion : motions) sha256 += (sha256.empty() ? "" : ",") + motion.sha256;
  return {{"version", Version()},  {"git", GitHash()},    {"input_sha256", sha256},
          {"flags", checks.flags}, {"seed", checks.seed}, {"threads", checks.num_threads}};
}

}  // namespace

std::string ResultJson(const FitSummary& summary, const FitChecks& checks, const std::vector<RecordedMotion>& motions) {
  Json json;
  json["schema"] = "clothid.result/1";
  json["status"] = FitStatusName(summary.status);
  const Verdict verdict = Judge(summary, checks);
  json["exit_code"] = static_cast<int>(verdict.exit_code);
  json["usable"] = UsabilityName(verdict.overall);
  json["verdict"] = verdict.Lines();
  json["parameters"] = ParametersJson(summary, checks, verdict);
  if (!motions.empty()) json["cloth"] = ClothJson(motions.front().scene);
  AddErrors(summary, &json);
  const bool has_discounted =
      std::any_of(checks.recordings.begin(), checks.recordings.end(),
                  [](const RecordingFit& recording) { return recording.discounted.has_value(); });
  if (has_discounted) json["discounted"] = DiscountedJson(checks);
  if (summary.fields) json["fields"] = FieldsJson(*summary.fields);
  if (checks.wind) json["wind"] = WindJson(*checks.wind);
  const bool errs = std::any_of(summary.model_errors.begin(), summary.model_errors.end(),
                                [](const ModelError& error) { return !error.is_zero(); });
  if (errs) json["model_error"] = ModelErrorsJson(summary.model_errors);
  if (checks.transfer) json["transfer"] = TransferJson(*checks.transfer);
  if (checks.repetitions) json["repetitions"] = RepetitionsJson(*checks.repetitions);
  json["holdout"] = HoldoutJson(checks);
  json["missing_force"] = LastingForcesJson(checks.missing_forces);
  json["uncertainty"] = UncertaintyJson(summary);
  json["starts"] = StartsJson(summary, checks);
  json["profiles"] = ProfilesJson(checks);
  if (checks.step_choice) json["time_step"] = StepChoiceJson(*checks.step_choice);
  const DiscretizationCheck discretization = checks.discretization.value_or(DiscretizationCheck());
  json["step_check"] = RepeatedFitJson(summary, discretization.half_step);
  if (discretization.double_step) json["double_step"] = RepeatedFitJson(summary, discretization.double_step);
  if (discretization.fine_mesh) json["fine_mesh"] = RepeatedFitJson(summary, discretization.fine_mesh);
  if (summary.assimilation.is_on() || !summary.memory_trials.empty()) {
    json["assimilation"] = CorrectionsJson(summary, checks);
  }
  json["cost"] = summary.cost;
  json["jacobian"] = JacobianMethodName(checks.jacobian);
  json["plan"] = PlanJson(summary.plan);
  json["iterations"] = summary.num_iterations();
  if (summary.num_continuations > 0) json["continuations"] = summary.num_continuations;
  json["rollouts"] = summary.statistics.rollouts;
  json["rollouts_of_first_frames"] = summary.lead.rollouts;
  json["sweeps"] = summary.statistics.sweeps;
  json["failed_steps"] = summary.statistics.counts.failed_steps;
  json["contact_events"] = ContactEventsJson(summary.counts);
  json["gradient_check"] = GradientCheckJson(checks.gradient_check);
  json["seconds"] = {{"total", summary.total_seconds},
                     {"rollout", summary.statistics.rollout_seconds},
                     {"derivative", summary.statistics.derivative_seconds},
                     {"solver", summary.solver_seconds}};
  if (IsToldMore(motions)) json["recordings"] = RecordingsJson(summary, motions);
  if (const Json findings = FindingsOfRecordings(checks); !findings.is_null()) json["findings"] = findings;
  json["provenance"] = ProvenanceJson(checks, motions);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace clothid
