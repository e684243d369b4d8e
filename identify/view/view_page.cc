#include "identify/view/view_page.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "datasets/checking/motion_check.h"
#include "datasets/files/atomic_file.h"
#include "identify/page/page_template.h"
#include "identify/report/cloud_points.h"
#include "identify/report/report_page.h"
#include "identify/report/report_replay.h"
#include "sim/air/wind.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/scene/parameters.h"

namespace clothid {

// Files embedded by CMake.
std::string_view ViewPage();      // view_page.html
std::string_view ReplayScript();  // the scripts that draw and play a replay
std::string_view ViewScript();    // those of all else

namespace {

using Json = nlohmann::ordered_json;

// Of the clouds of all frames: about what the page has room for, as nothing is saved from one frame to the next.
constexpr double kMaxCloudPoints = 4e5;
constexpr int kFewestCloudPoints = 1000;  // per frame
// Points that are farther off than nearly all others do not say what the picture is about.
constexpr double kUsualShare = 0.99;
constexpr double kUsualMargin = 0.25;             // of the diagonal of those
constexpr Eigen::Index kMaxUsualPoints = 200000;  // that are looked at for it
constexpr std::size_t kMaxRuns = 500;             // of frames, per finding
constexpr std::size_t kMaxViewForceBytes = 400000;
constexpr int kViewDigits = 6;

// Stretches of successive frames.
Json RunsJson(const std::vector<int>& frames) {
  Json runs = Json::array();
  for (const int frame : frames) {
    if (!runs.empty() && runs.back()[1] == frame - 1) {
      runs.back()[1] = frame;
    } else if (runs.size() < kMaxRuns) {
      runs.push_back({frame, frame});
    } else {
      break;
    }
  }
  return runs;
}

void AddFindings(const RecordedMotion& motion, Json* json) {
  const std::vector<Finding> findings = CheckMotion(motion);
  (*json)["verdict"] = SeverityName(Worst(findings));
  (*json)["findings"] = Json::array();
  for (const Finding& finding : findings) {
    (*json)["findings"].push_back({{"what", finding.what},
                                   {"verdict", SeverityName(finding.severity)},
                                   {"value", finding.value},
                                   {"hint", finding.hint},
                                   {"num_frames", finding.frames.size()},
                                   {"runs", RunsJson(finding.frames)}});
  }
}

// The nominal scene in numbers.
Json SceneJson(const Scene& scene) {
  Json constants = Json::object(), obstacles = Json::array();
  const Parameters nominal = scene.nominal_parameters();
  for (const ParameterKind kind : MaterialKinds()) {
    if (!scene.has(kind)) continue;
    const ParameterId id = {kind};
    constants[ParameterName(id, scene.obstacle_names())] = RoundedJson(GetParameter(nominal, id), kViewDigits);
  }
  for (const ParameterId id : scene.piece_parameters()) {
    constants[ParameterName(id, {}, scene.mesh.piece_names)] = RoundedJson(GetParameter(nominal, id), kViewDigits);
  }
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    obstacles.push_back({{"name", scene.obstacles[i].name}, {"mu", nominal.friction_coefficients[i]}});
  }
  return {{"nodes", scene.mesh.num_nodes()},
          {"fabric", scene.fabric},
          {"constants", constants},
          {"obstacles", obstacles},
          {"handles", scene.handles.nodes.size()},
          {"handles_move", scene.handles.path.num_handles() > 0}};
}

// So many points of each cloud that all of them have room, evenly over each; which of them stay.
Eigen::Index ThinClouds(RecordedMotion* motion) {
  Eigen::Index largest = 0;
  for (const Eigen::Matrix3Xd& cloud : motion->clouds) largest = std::max(largest, cloud.cols());
  const double most = std::max<double>(kFewestCloudPoints, kMaxCloudPoints / motion->num_frames());
  const auto stride = static_cast<Eigen::Index>(std::ceil(static_cast<double>(largest) / most));
  if (stride <= 1) return 1;
  for (Eigen::Matrix3Xd& cloud : motion->clouds) {
    if (cloud.cols() > 0) cloud = Eigen::Matrix3Xd(cloud(Eigen::all, Eigen::seq(0, cloud.cols() - 1, stride)));
  }
  return stride;
}

// [3H x T] m.
Eigen::MatrixXd HandlePositions(const RecordedMotion& motion) {
  const Handles& handles = motion.scene.handles;
  Eigen::MatrixXd positions(3 * static_cast<Eigen::Index>(handles.nodes.size()), motion.num_frames());
  const bool has_path = handles.path.num_handles() > 0;
  const Eigen::MatrixXd start = motion.scene.initial_positions.reshaped(3, motion.scene.mesh.num_nodes());
  const Eigen::VectorXd held = start(Eigen::all, handles.nodes).reshaped();
  for (int frame = 0; frame < motion.num_frames(); ++frame) {
    positions.col(frame) = has_path ? handles.path.At(motion.times[frame]) : held;
  }
  return positions;
}

// Those of all frames that were seen [3K x T], one after the other.
template <typename Function>
void ForEachSeen(const Eigen::MatrixXd& positions, const Function& function) {
  for (Eigen::Index i = 0; i + 3 <= positions.size(); i += 3) {
    const Eigen::Vector3d point = Eigen::Map<const Eigen::Vector3d>(positions.data() + i);
    if (point.allFinite()) function(point);
  }
}

// What nearly all coordinates of the points lie between, and somewhat more, but nothing beyond the last point.
Eigen::AlignedBox3d UsualPlaces(const Eigen::MatrixXd& positions) {
  const Eigen::Index every = positions.size() / 3 / kMaxUsualPoints + 1;
  std::vector<double> values[3];
  Eigen::AlignedBox3d all;
  Eigen::Index index = 0;
  ForEachSeen(positions, [&](const Eigen::Vector3d& point) {
    all.extend(point);
    if (index++ % every != 0) return;
    for (int axis = 0; axis < 3; ++axis) values[axis].push_back(point[axis]);
  });
  if (all.isEmpty()) return all;
  Eigen::AlignedBox3d usual;
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = [&](double share) {
      const auto place = values[axis].begin() +
                         static_cast<std::ptrdiff_t>(std::lround(share * static_cast<double>(values[axis].size() - 1)));
      std::nth_element(values[axis].begin(), place, values[axis].end());
      return *place;
    };
    usual.min()[axis] = at(1.0 - kUsualShare);
    usual.max()[axis] = at(kUsualShare);
  }
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(kUsualMargin * usual.diagonal().norm());
  return Eigen::AlignedBox3d(usual.min() - margin, usual.max() + margin).intersection(all);
}

void ExtendBy(const Eigen::MatrixXd& positions, Eigen::AlignedBox3d* box) {
  ForEachSeen(positions, [&](const Eigen::Vector3d& point) { box->extend(point); });
}

// The points that `ReplayJson` leaves out.
int CountFar(const Eigen::MatrixXd& positions, const Eigen::AlignedBox3d& middle) {
  const double margin = middle.diagonal().norm();
  int count = 0;
  ForEachSeen(positions, [&](const Eigen::Vector3d& point) {
    count +=
        (point.array() < middle.min().array() - margin).any() || (point.array() > middle.max().array() + margin).any();
  });
  return count;
}

// In the middle of the cloth.
Json WindOverTime(const RecordedMotion& motion, int every) {
  const Scene& scene = motion.scene;
  const Wind wind = scene.nominal_parameters().wind;
  const Eigen::VectorXd areas = NodeAreas(scene.mesh);
  RestPlace place;
  place.position = scene.mesh.rest_positions * areas / areas.sum();
  Json x = Json::array(), y = Json::array(), z = Json::array();
  for (int frame = 0; frame < motion.num_frames(); frame += every) {
    const Eigen::Vector3d velocity = wind.At(motion.times[frame], place);
    x.push_back(RoundedJson(velocity.x(), kViewDigits));
    y.push_back(RoundedJson(velocity.y(), kViewDigits));
    z.push_back(RoundedJson(velocity.z(), kViewDigits));
  }
  return {{"x", x}, {"y", y}, {"z", z}};
}

// Per frame that is shown.
void AddFrames(const RecordedMotion& motion, int every, Json* json) {
  Json unseen = Json::array(), cloud_points = Json::array();
  for (int frame = 0; frame < motion.num_frames(); frame += every) {
    int count = 0;
    for (int p = 0; p < motion.num_points(); ++p) count += !motion.positions.col(frame).segment<3>(3 * p).allFinite();
    unseen.push_back(count);
    if (!motion.clouds.empty()) cloud_points.push_back(motion.clouds[static_cast<std::size_t>(frame)].cols());
  }
  (*json)["unseen"] = unseen;
  if (!motion.clouds.empty()) (*json)["cloud_points"] = cloud_points;
  if (motion.scene.has_wind()) (*json)["wind"] = WindOverTime(motion, every);
}

// The replay of at most `max_bytes`, and what it leaves out.
void AddReplay(const RecordedMotion& motion, std::size_t max_bytes, Json* json) {
  RecordedMotion shown = motion;
  if (!motion.clouds.empty()) {
    (*json)["cloud_stride"] = ThinClouds(&shown);
    shown = CloudsAsPoints(shown);
  }
  const Eigen::MatrixXd handles = HandlePositions(motion), start = motion.scene.initial_positions;
  ReplaySource source;
  source.motion = &shown;
  if (handles.size() > 0) source.handles = &handles;
  source.start = &start;
  source.middle = UsualPlaces(shown.positions);
  ExtendBy(handles, &source.middle);
  ExtendBy(start, &source.middle);
  (*json)["far"] = CountFar(shown.positions, source.middle);
  (*json)["replay"] = ReplayJson(source, max_bytes);
}

// The data of view.html, in at most `max_bytes`: "name", "simulated", "sha256", "provenance"; "verdict" and "findings"
// as `FindingsJson` has them, but for "runs", the first and the last frame of those that follow each other, in place of
// frames and points, and "num_frames"; "scene", its constants, obstacles and handles; "points", "frames", "times", the
// first and the last, s; "replay" as `ReplayJson` has it. Per frame of the replay, where there is one: "unseen",
// tracked points that were not seen, "cloud_points", and "wind" {"x", "y", "z"} in the middle of the cloth, m/s. "far":
// points of all frames that are so far from the others that the replay leaves them out. "cloud_stride": of so many
// points of a cloud one is shown. "forces" as `ForcesJson` has them. What a recording does not have is absent.
Json ViewData(const RecordedMotion& motion, bool is_simulated, std::size_t max_bytes) {
  Json json = {
      {"name", motion.name}, {"simulated", is_simulated}, {"sha256", motion.sha256}, {"provenance", motion.provenance}};
  AddFindings(motion, &json);
  json["scene"] = SceneJson(motion.scene);
  json["points"] = motion.num_points();
  json["frames"] = motion.num_frames();
  json["times"] = {motion.times[0], motion.times[motion.num_frames() - 1]};
  if (!motion.forces.is_empty()) json["forces"] = ForcesJson(motion.forces, nullptr, kMaxViewForceBytes);
  const std::size_t used = ScriptText(json).size();
  // What is told of every frame takes room, too, as long as all of them are shown.
  constexpr std::size_t kBytesPerFrame = 60;
  std::size_t room = used < max_bytes ? max_bytes - used : 0;
  room -= std::min(room / 4, kBytesPerFrame * static_cast<std::size_t>(motion.num_frames()));
  for (;; room /= 2) {
    AddReplay(motion, room, &json);
    if (!json["replay"].contains("every")) break;
    AddFrames(motion, json["replay"]["every"], &json);
    if (ScriptText(json).size() <= max_bytes) break;
  }
  return json;
}

Json ChartJson(const ViewChart& chart) {
  Json lines = Json::object();
  for (const auto& [name, values] : chart.lines) lines[name] = RoundedJson(values, kViewDigits);
  return {
      {"name", chart.name}, {"unit", chart.unit}, {"times", RoundedJson(chart.times, kViewDigits)}, {"lines", lines}};
}

Json PredictionJson(const PredictionView& view) {
  Json json = {
      {"status", view.status}, {"facts", view.facts}, {"cloths", view.cloths.size()}, {"charts", Json::array()}};
  for (const ViewChart& chart : view.charts) json["charts"].push_back(ChartJson(chart));
  return json;
}

// Every frame has the nodes of all cloths as a cloud.
void AddCloths(const std::vector<Eigen::MatrixXd>& cloths, RecordedMotion* motion) {
  if (cloths.empty()) return;
  const Eigen::Index num_nodes = cloths.front().rows() / 3;
  motion->clouds.resize(static_cast<std::size_t>(motion->num_frames()));
  for (Eigen::Index frame = 0; frame < motion->num_frames(); ++frame) {
    Eigen::Matrix3Xd& cloud = motion->clouds[static_cast<std::size_t>(frame)];
    cloud.resize(3, num_nodes * static_cast<Eigen::Index>(cloths.size()));
    for (std::size_t i = 0; i < cloths.size(); ++i) {
      cloud.middleCols(static_cast<Eigen::Index>(i) * num_nodes, num_nodes) =
          cloths[i].col(frame).reshaped(3, num_nodes);
    }
  }
}

constexpr std::size_t kMostChartBytes = 4000000;

}  // namespace

std::string PredictionHtml(RecordedMotion median, const PredictionView& view) {
  const PageParts page = {"Prediction", ViewPage(), {}, /*has_charts=*/false, {ReplayScript(), ViewScript()}};
  Json prediction = PredictionJson(view);
  if (ScriptText(prediction).size() > kMostChartBytes) prediction["charts"] = Json::array();
  const std::size_t used = MakePage(page, "").size() + ScriptText(prediction).size();
  AddCloths(view.cloths, &median);
  Json json = ViewData(median, /*is_simulated=*/true, used < kMaxReportBytes ? kMaxReportBytes - used : 0);
  json["findings"] = Json::array();
  json["prediction"] = prediction;
  return MakePage(page, ScriptText(json));
}

std::string ViewHtml(const RecordedMotion& motion, bool is_simulated) {
  const PageParts page = {"View", ViewPage(), {}, /*has_charts=*/false, {ReplayScript(), ViewScript()}};
  return MakePage(page, ScriptText(ViewData(motion, is_simulated, kMaxReportBytes - MakePage(page, "").size())));
}

void CheckPageOutput(const std::string& flag, const std::string& path) {
  constexpr std::string_view kEnding = ".html";
  const bool is_page = path.size() > kEnding.size() && path.substr(path.size() - kEnding.size()) == kEnding;
  if (!is_page && !IsStream(path)) {
    throw Error(ErrorKind::kUsage, flag + ": expected a name that ends in .html, got '" + Printable(path) + "'");
  }
  CheckFileCanBeWritten(path);
}

}  // namespace clothid
