#include "identify/report/report_page.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "datasets/observation/observation.h"
#include "identify/page/page_template.h"
#include "identify/report/cloud_points.h"
#include "identify/report/fit_quality.h"
#include "identify/report/repetition_report.h"
#include "identify/report/report_fields.h"
#include "identify/report/report_landscape.h"
#include "identify/report/report_replay.h"
#include "identify/result/result_json.h"
#include "identify/verdict/model_error_text.h"

namespace clothid {

// Files embedded by CMake.
std::string_view ReportPage();               // report_page.html
std::string_view ReplayScript();             // the scripts that draw and play a replay
std::string_view ReportScript();             // those of all else
std::string_view ReportLandscapeScript();    // report_landscape.js
std::string_view ReportFieldScript();        // report_field.js
std::string_view ReportWindScript();         // report_wind.js
std::string_view ReportRepetitionsScript();  // report_repetitions.js
std::string_view ReportTransferScript();     // report_transfer.js

namespace {

using Json = nlohmann::ordered_json;

// Of all that is not library or replay; curves are thinned to fit.
constexpr std::size_t kMaxCurveBytes = 400000;
// Of all landscapes together.
constexpr std::size_t kMaxLandscapeBytes = 400000;
// Of the forces of one recording.
constexpr std::size_t kMaxForceBytes = 200000;
constexpr int kPageDigits = 6;
constexpr int kNumBins = 61;
// The width of a histogram to both sides of zero, in root mean squares of a coordinate.
constexpr double kHistogramRange = 4.0;

Json ConvergenceJson(const FitSummary& summary) {
  Json iterations = Json::array(), seconds = Json::array(), cost = Json::array(), loose = Json::array();
  Json values = Json::object();
  for (const FittedParameter& parameter : summary.parameters) values[parameter.name] = Json::array();
  for (const FitIteration& row : summary.iterations) {
    iterations.push_back(row.iteration);
    seconds.push_back(RoundedJson(row.seconds, kPageDigits));
    cost.push_back(RoundedJson(row.cost, kPageDigits));
    loose.push_back(row.precision == Precision::kLoose);
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[summary.parameters[i].name].push_back(RoundedJson(row.values[static_cast<Eigen::Index>(i)], 10));
    }
  }
  return {{"iteration", iterations}, {"seconds", seconds}, {"cost", cost}, {"loose", loose}, {"values", values}};
}

Json PageProfilesJson(const FitChecks& checks) {
  Json profiles = Json::array();
  for (const Profile& profile : checks.profiles) {
    Json values = Json::array(), rises = Json::array();
    for (const ProfilePoint& point : profile.points) {
      values.push_back(RoundedJson(point.value, 10));
      rises.push_back(RoundedJson(point.cost_rise, kPageDigits));
    }
    profiles.push_back({{"parameter", profile.parameter},
                        {"value", values},
                        {"rise", rises},
                        {"lower95", RoundedJson(profile.lower95, 10)},
                        {"upper95", RoundedJson(profile.upper95, 10)},
                        {"limit", kChiSquare95}});
  }
  return profiles;
}

// Root mean squares of `every` frames at a time.
Eigen::VectorXd Thinned(const Eigen::VectorXd& errors, int every) {
  Eigen::VectorXd thinned((errors.size() + every - 1) / every);
  for (Eigen::Index i = 0; i < thinned.size(); ++i) {
    thinned[i] = RootMeanSquare(errors.segment(i * every, std::min<Eigen::Index>(every, errors.size() - i * every)));
  }
  return thinned;
}

// The errors of every frame, at the estimate and at the start.
Json ErrorsOverTime(const RecordedMotion& motion, const Eigen::VectorXd& errors, const Eigen::VectorXd& start_errors,
                    std::size_t max_bytes) {
  constexpr std::size_t kBytesPerFrame = 3 * 13;
  const std::size_t num_frames = static_cast<std::size_t>(motion.num_frames());
  const int every = static_cast<int>(std::max<std::size_t>(1, num_frames * kBytesPerFrame / max_bytes + 1));
  return {{"every", every},
          {"times", RoundedJson(motion.times(Eigen::seq(0, motion.num_frames() - 1, every)), kPageDigits)},
          {"rmse", RoundedJson(Thinned(errors, every), kPageDigits)},
          {"start_rmse", RoundedJson(Thinned(start_errors, every), kPageDigits)}};
}

// What the model misses, as a distance, at the times of the errors.
void AddModelError(const ModelError& error, const RecordedMotion& motion, Json* per_frame) {
  const PredictedKind kind =
      error.CurveOf(PredictedKind::kPoints).is_zero() ? PredictedKind::kClouds : PredictedKind::kPoints;
  const ErrorCurve& curve = error.CurveOf(kind);
  if (curve.is_zero()) return;
  const int every = (*per_frame)["every"];
  Eigen::VectorXd distances((motion.num_frames() + every - 1) / every);
  for (Eigen::Index i = 0; i < distances.size(); ++i) {
    distances[i] = DistanceOf(curve.DeviationAt(motion.times[i * every]), kind);
  }
  (*per_frame)["model_error"] = RoundedJson(distances, kPageDigits);
}

Json HistogramJson(const Observation& observation, const RecordedMotion& motion, const Eigen::MatrixXd& predicted,
                   double rmse) {
  const double range = kHistogramRange * rmse / std::sqrt(3.0);
  if (!(range > 0.0)) return nullptr;
  Json axes = Json::array();
  int num_beyond = 0;
  bool is_empty = true;
  for (const ResidualHistogram& axis : ResidualHistograms(observation, motion, predicted, range, kNumBins)) {
    axes.push_back({{"counts", axis.counts},
                    {"mean", RoundedJson(axis.mean, kPageDigits)},
                    {"deviation", RoundedJson(axis.deviation, kPageDigits)}});
    num_beyond += axis.num_beyond;
    is_empty = is_empty && std::isnan(axis.mean);
  }
  if (is_empty) return nullptr;
  return {{"range", range}, {"axes", axes}, {"beyond", num_beyond}, {"leaves_out_start", StartsAtFirstFrame(motion)}};
}

// What the page may spend on each recording.
struct Room {
  std::size_t replay_bytes = 0, curve_bytes = 0;
};

// A recording as it is drawn: of points alone.
struct Shown {
  RecordedMotion motion;
  Eigen::MatrixXd predicted, start_predicted;  // [3P x T] m; the second may be empty
  Eigen::MatrixXd nodes;                       // [3N x T] m, or empty
};

Shown Show(const RecordedMotion& motion, const Observation& observation, const FitSummary& summary,
           const FitChecks& checks, std::size_t index) {
  Shown shown = {motion, summary.predicted[index], {}, {}};
  if (index < summary.start_predicted.size()) shown.start_predicted = summary.start_predicted[index];
  if (index < checks.predicted_nodes.size()) shown.nodes = checks.predicted_nodes[index];
  if (!observation.has_clouds()) return shown;
  shown.nodes = shown.predicted.bottomRows(3 * observation.num_nodes());
  shown.motion = CloudsAsPoints(motion);
  shown.predicted = ClosestPoints(observation, shown.predicted);
  if (shown.start_predicted.size() > 0) shown.start_predicted = ClosestPoints(observation, shown.start_predicted);
  return shown;
}

// How large the force [N x T] N/m^2 is that the model lacks: of the mean over five frames, as noise changes its sign
// from one to the next. Empty where nobody knows.
Eigen::MatrixXd MissingForceOf(const FitChecks& checks, std::size_t index) {
  constexpr Eigen::Index kReach = 2;
  if (index >= checks.corrections.size()) return {};
  const Eigen::MatrixXd& forces = checks.corrections[index].missing_force.forces;
  Eigen::MatrixXd sizes(forces.rows() / 3, forces.cols());
  for (Eigen::Index frame = 0; frame < forces.cols(); ++frame) {
    const Eigen::Index first = std::max<Eigen::Index>(0, frame - kReach);
    const Eigen::Index count = std::min<Eigen::Index>(forces.cols(), frame + kReach + 1) - first;
    const Eigen::VectorXd mean = forces.middleCols(first, count).rowwise().mean();
    sizes.col(frame) = mean.reshaped(3, sizes.rows()).colwise().norm().transpose();
  }
  return sizes;
}

Json RecordingJson(const RecordedMotion& motion, const Observation& observation, const FitSummary& summary,
                   const FitChecks& checks, std::size_t index, const Room& room) {
  const Shown shown = Show(motion, observation, summary, checks, index);
  const Observation points(shown.motion);
  const Eigen::MatrixXd errors = PointErrors(points, shown.motion, shown.predicted);
  Eigen::VectorXd start_errors = Eigen::VectorXd::Constant(motion.num_frames(), std::nan(""));
  double start_rmse = std::nan("");
  if (shown.start_predicted.size() > 0) {
    start_errors = FrameErrors(PointErrors(points, shown.motion, shown.start_predicted));
    start_rmse = observation.Compare(summary.start_predicted[index]).rmse();
  }
  const PredictionError error = observation.Compare(summary.predicted[index]);
  ReplaySource replay = {&shown.motion, &shown.predicted, shown.nodes.size() > 0 ? &shown.nodes : nullptr, &errors};
  const Eigen::MatrixXd missing_force = MissingForceOf(checks, index);
  if (missing_force.size() > 0) replay.missing_force = &missing_force;
  Json json = {{"name", motion.name},
               {"sha256", motion.sha256},
               {"frames", motion.num_frames()},
               {"points", shown.motion.num_points()},
               {"nodes", motion.scene.mesh.num_nodes()},
               {"sigma_is_known", observation.sigma_is_known()},
               {"rmse_m", RoundedJson(error.rmse(), kPageDigits)},
               {"start_rmse_m", RoundedJson(start_rmse, kPageDigits)},
               {"fit_percent", RoundedJson(error.fit_percent(), kPageDigits)},
               {"per_frame", ErrorsOverTime(motion, FrameErrors(errors), start_errors, room.curve_bytes)},
               {"histogram", HistogramJson(points, shown.motion, shown.predicted, error.rmse())},
               {"replay", ReplayJson(replay, room.replay_bytes)}};
  if (index < summary.model_errors.size()) AddModelError(summary.model_errors[index], shown.motion, &json["per_frame"]);
  if (index < summary.forces.size() && summary.forces[index].cols() > 0) {
    json["forces"] = ForcesJson(motion.forces, &summary.forces[index], kMaxForceBytes);
  }
  return json;
}

// What stands beside each parameter.
Json RemarksJson(const FitSummary& summary, const FitChecks& checks) {
  Json remarks = Json::object();
  for (std::size_t i = 0; i < summary.parameters.size(); ++i) {
    const std::string remark = ParameterRemark(summary, checks, static_cast<int>(i));
    const std::string prior = PriorRemark(summary, static_cast<int>(i));
    remarks[summary.parameters[i].name] =
        prior.empty() ? remark : remark + (remark.empty() ? "prior " : "; prior ") + prior;
  }
  return remarks;
}

Json DataJson(const FitSummary& summary, const FitChecks& checks, const std::vector<RecordedMotion>& motions,
              std::size_t library_bytes) {
  std::vector<Observation> observations;
  for (const RecordedMotion& motion : motions) observations.emplace_back(motion);
  Json json = {{"result", Json::parse(ResultJson(summary, checks, motions))},
               {"start_rmse_m", summary.start_error.rmse()},
               {"start_fit_percent", RoundedJson(summary.start_error.fit_percent(), 10)},
               {"remarks", RemarksJson(summary, checks)},
               {"limits", FitLimits(summary, motions, observations)},
               {"convergence", ConvergenceJson(summary)},
               {"profiles", PageProfilesJson(checks)},
               {"recordings", Json::array()}};
  for (const FitLandscape& landscape : checks.landscapes) {
    json["landscapes"].push_back(
        LandscapeJson(landscape, summary, checks, motions, kMaxLandscapeBytes / checks.landscapes.size()));
  }
  if (checks.repetitions) json["repetition_lines"] = RepetitionLinesJson(*checks.repetitions);
  if (summary.fields) json["fields"] = FieldMapsJson(*summary.fields, motions.front().scene.mesh);
  std::size_t used = library_bytes + ScriptText(json).size() + kMaxCurveBytes;
  for (const RecordedMotion& motion : motions) used += motion.forces.is_empty() ? 0 : kMaxForceBytes;
  const std::size_t left = used < kMaxReportBytes ? kMaxReportBytes - used : 0;
  const Room room = {left / motions.size(), kMaxCurveBytes / motions.size()};
  for (std::size_t r = 0; r < motions.size(); ++r) {
    json["recordings"].push_back(RecordingJson(motions[r], observations[r], summary, checks, r, room));
  }
  return json;
}

}  // namespace

std::string ReportHtml(const FitSummary& summary, const FitChecks& checks, const std::vector<RecordedMotion>& motions) {
  PageParts page = {"Fit report", ReportPage(), {}, /*has_charts=*/true, {ReplayScript(), ReportScript()}};
  // A page without repetitions, predictions of each other, a landscape, field or profile of the wind has nothing of
  // them.
  if (checks.repetitions) page.scripts.push_back(ReportRepetitionsScript());
  if (checks.transfer) page.scripts.push_back(ReportTransferScript());
  if (summary.fields) page.scripts.push_back(ReportFieldScript());
  if (checks.wind) page.scripts.push_back(ReportWindScript());
  if (!checks.landscapes.empty()) page.scripts.push_back(ReportLandscapeScript());
  return MakePage(page, ScriptText(DataJson(summary, checks, motions, MakePage(page, "").size())));
}

}  // namespace clothid
