// A plan as plan.html.
#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "identify/experiment/experiment_plan.h"
#include "identify/page/page_template.h"
#include "identify/report/packed_array.h"
#include "identify/report/report_page.h"
#include "identify/report/report_replay.h"

namespace clothid {

// Files embedded by CMake.
std::string_view PlanPage();           // plan_page.html
std::string_view PlanStyle();          // plan_style.css
std::string_view ManyReplaysScript();  // the scripts that draw replays
std::string_view PlanScript();         // those of all else

namespace {

using Json = nlohmann::ordered_json;

constexpr Eigen::Index kMostCurvePoints = 400;
constexpr std::size_t kMostImprovements = 8;  // of each candidate; plan.json has all
constexpr int kCurveDigits = 4;

// The means of every `every` successive values, of fewer at the end.
Eigen::VectorXd Means(const Eigen::VectorXd& values, Eigen::Index every) {
  Eigen::VectorXd means((values.size() + every - 1) / every);
  for (Eigen::Index i = 0; i < means.size(); ++i) {
    means[i] = values.segment(i * every, std::min(every, values.size() - i * every)).mean();
  }
  return means;
}

// Of one column of the map: "nodes" [N] as `PackMagnitudes` has them beside "largest", 255 where a node is not seen;
// "frames", means of those that follow each other; "forces", and "total" over frames and forces.
Json PackedColumnJson(const CandidatePlan& candidate, Eigen::Index column, Eigen::Index every) {
  const InformationMap& map = candidate.map;
  Eigen::VectorXd nodes = Eigen::VectorXd::Constant(map.per_node.rows(), std::numeric_limits<double>::quiet_NaN());
  nodes(candidate.motion.seen) = map.per_node(candidate.motion.seen, column);
  const double largest = map.per_node.col(column).maxCoeff();
  return {{"largest", largest},
          {"nodes", PackMagnitudes(nodes, largest)},
          {"frames", RoundedJson(Means(map.per_frame.col(column), every), kCurveDigits)},
          {"forces", map.of_forces[column]},
          {"total", map.per_frame.col(column).sum() + map.of_forces[column]}};
}

Json InformationJson(const Plan& plan, const CandidatePlan& candidate) {
  const InformationMap& map = candidate.map;
  const Eigen::Index every = (map.times.size() + kMostCurvePoints - 1) / kMostCurvePoints;
  Json parameters = Json::object();
  for (std::size_t k = 0; k < map.columns.size(); ++k) {
    parameters[plan.parameters[static_cast<std::size_t>(map.columns[k])]] =
        PackedColumnJson(candidate, static_cast<Eigen::Index>(k), every);
  }
  constexpr int kTimeDigits = 7;
  return {{"times", RoundedJson(Means(map.times, every), kTimeDigits)}, {"parameters", parameters}};
}

// The data of plan.html: plan.json, but "information" as above, no more than kMostImprovements "improvements", and of
// "pairs" those that are the best for a parameter, or for the prediction. "best" of each parameter {"candidate",
// "pair"}, indices or -1, the latter of the pairs that are left, and likewise of "prediction"; "num_pairs" there were.
// "replay" of each candidate as `ReplayJson` has it.
Json PlanData(const PlanOptions& options, const Plan& plan) {
  Json json = Json::parse(PlanJson(options, plan));
  for (std::size_t c = 0; c < plan.candidates.size(); ++c) {
    const CandidatePlan& candidate = plan.candidates[c];
    if (!candidate.failure.empty()) continue;
    Json& shown = json["candidates"][c];
    shown["information"] = InformationJson(plan, candidate);
    Json& improvements = shown["improvements"];
    while (improvements.size() > kMostImprovements) improvements.erase(improvements.size() - 1);
  }
  Json pairs = Json::array();
  std::vector<int> kept;
  const auto best_of = [&](int candidate, int pair) -> Json {
    auto place = std::find(kept.begin(), kept.end(), pair);
    if (pair >= 0 && place == kept.end()) {
      place = kept.insert(place, pair);
      pairs.push_back(json["pairs"][static_cast<std::size_t>(pair)]);
    }
    return {{"candidate", candidate}, {"pair", pair < 0 ? -1 : static_cast<int>(place - kept.begin())}};
  };
  for (std::size_t i = 0; i < plan.parameters.size(); ++i) {
    json["best"][plan.parameters[i]] = best_of(BestCandidate(plan, i), BestPair(plan, i));
  }
  if (!plan.predicted.empty()) {
    json["prediction"].update(best_of(BestCandidateToPredict(plan), BestPairToPredict(plan)));
  }
  json["num_pairs"] = plan.pairs.size();
  json["pairs"] = pairs;
  return json;
}

// The nominal cloth as if every node were a point that is seen.
Json MotionReplay(const NominalMotion& nominal, std::size_t max_bytes) {
  RecordedMotion motion;
  motion.scene = nominal.scene;
  motion.times = nominal.times;
  motion.positions = nominal.positions.cast<double>();
  motion.points.resize(static_cast<std::size_t>(motion.scene.mesh.num_nodes()));
  for (int p = 0; p < motion.num_points(); ++p) motion.points[static_cast<std::size_t>(p)].nodes[0] = p;
  const std::vector<int>& held = motion.scene.handles.nodes;
  Eigen::MatrixXd handles(3 * static_cast<Eigen::Index>(held.size()), motion.num_frames());
  for (std::size_t h = 0; h < held.size(); ++h) {
    handles.middleRows<3>(3 * static_cast<Eigen::Index>(h)) = motion.positions.middleRows<3>(3 * held[h]);
  }
  ReplaySource source;
  source.motion = &motion;
  if (handles.size() > 0) source.handles = &handles;
  for (Eigen::Index i = 0; i + 3 <= motion.positions.size(); i += 3) {
    source.middle.extend(Eigen::Vector3d(Eigen::Map<const Eigen::Vector3d>(motion.positions.data() + i)));
  }
  return ReplayJson(source, max_bytes);
}

// Replays of all candidates in `max_bytes`, all with the same room.
void AddReplays(const Plan& plan, std::size_t max_bytes, Json* json) {
  constexpr std::size_t kKeyBytes = 100;  // around each
  for (std::size_t c = 0; c < plan.candidates.size(); ++c) {
    if (!plan.candidates[c].failure.empty()) continue;
    const std::size_t room = max_bytes / plan.candidates.size();
    (*json)["candidates"][c]["replay"] = MotionReplay(plan.candidates[c].motion, room - std::min(room, kKeyBytes));
  }
}

}  // namespace

std::string PlanHtml(const PlanOptions& options, const Plan& plan) {
  const PageParts page = {"Plan", PlanPage(), PlanStyle(), /*has_charts=*/false, {ManyReplaysScript(), PlanScript()}};
  Json json = PlanData(options, plan);
  const std::size_t used = MakePage(page, ScriptText(json)).size();
  AddReplays(plan, kMaxReportBytes - std::min(used, kMaxReportBytes), &json);
  return MakePage(page, ScriptText(json));
}

}  // namespace clothid
