// view.html: what it holds of a recording, complete, one file, small, names shown and never run.
#include "identify/view/view_page.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <regex>
#include <vector>

#include "datasets/checking/motion_check.h"
#include "identify/report/report_page.h"
#include "tests/costs/synthetic_clouds.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"
#include "tests/identify/report/packed_page.h"
#include "tests/temporary_folder.h"

namespace clothid::view_page_test {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kUnseen = 65535;

// Ball, two corners held, 1 mm of noise, two points missing in frame 3.
RecordedMotion SphereMotion() {
  MotionOptions options;
  options.noise = 1e-3;
  RecordedMotion motion = MakeMotion(SphereScene(), options);
  motion.positions.block<6, 1>(3 * 7, 3).setConstant(kNaN);
  return motion;
}

// Handles that go up at 1 m/s.
void MoveHandles(RecordedMotion* motion) {
  const std::vector<int>& nodes = motion->scene.handles.nodes;
  Eigen::MatrixXd path(3 * static_cast<Eigen::Index>(nodes.size()), motion->num_frames());
  for (int frame = 0; frame < motion->num_frames(); ++frame) {
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      path.col(frame).segment<3>(3 * static_cast<Eigen::Index>(i)) =
          motion->scene.initial_positions.segment<3>(3 * nodes[i]) + motion->times[frame] * Eigen::Vector3d::UnitZ();
    }
  }
  motion->scene.handles.path = HandlePath(motion->times, path);
}

// What the page says of point `point` in a frame, m; NaN: not seen.
Eigen::Vector3d PositionOf(const Json& replay, const char* array, std::size_t num_points, int frame, int point) {
  const std::vector<int> rows = UnpackPositions(replay[array], 3 * num_points)[static_cast<std::size_t>(frame)];
  Eigen::Vector3d position;
  for (int axis = 0; axis < 3; ++axis) {
    const int q = rows[static_cast<std::size_t>(3 * point + axis)];
    position[axis] = q == kUnseen ? kNaN : replay["origin"][axis].get<double>() + replay["step"].get<double>() * q;
  }
  return position;
}

TEST(ViewPageTest, HoldsTheRecording) {
  RecordedMotion motion = SphereMotion();
  MoveHandles(&motion);
  motion.scene.initial_velocities.setZero();
  const Json data = PageData(ViewHtml(motion));
  const Json& replay = data["replay"];
  EXPECT_EQ(data["simulated"], false);
  EXPECT_EQ(data["frames"], 21);
  EXPECT_EQ(data["points"], 25);
  EXPECT_EQ(replay["points_are_nodes"], true);
  EXPECT_FALSE(replay.contains("predicted"));
  EXPECT_FALSE(replay.contains("errors"));
  const double rounding = replay["step"].get<double>();
  EXPECT_LT(rounding, 1e-4);
  for (const int point : {0, 12, 24}) {
    const Eigen::Vector3d shown = PositionOf(replay, "recorded", 25, 5, point);
    EXPECT_LT((shown - motion.positions.col(5).segment<3>(3 * point)).norm(), rounding) << point;
  }
  EXPECT_TRUE(std::isnan(PositionOf(replay, "recorded", 25, 3, 7).x()));
  EXPECT_EQ(data["unseen"][2], 0);
  EXPECT_EQ(data["unseen"][3], 2);
  EXPECT_EQ(data["far"], 0);
  const Eigen::Vector3d lifted =
      motion.scene.initial_positions.segment<3>(6) + motion.times[8] * Eigen::Vector3d::UnitZ();
  EXPECT_LT((PositionOf(replay, "handle_path", 5, 8, 2) - lifted).norm(), rounding);
  EXPECT_LT((PositionOf(replay, "start", 25, 0, 24) - motion.scene.initial_positions.tail<3>()).norm(), rounding);
  EXPECT_EQ(replay["obstacles"][0]["type"], "sphere");
  EXPECT_EQ(data["scene"]["obstacles"][0], Json({{"name", "ball"}, {"mu", 0.2}}));
  EXPECT_EQ(data["scene"]["constants"]["density"], 0.2);
  EXPECT_FALSE(data.contains("forces"));
  EXPECT_FALSE(data.contains("wind"));
  EXPECT_EQ(PageData(ViewHtml(motion, true))["simulated"], true);
}

TEST(ViewPageTest, FindingsNameTheirFrames) {
  RecordedMotion motion = SphereMotion();
  for (const int frame : {9, 10, 14}) motion.positions(3 * 20, frame) = kNaN;
  const std::vector<Finding> findings = CheckMotion(motion);
  const Json data = PageData(ViewHtml(motion));
  EXPECT_EQ(data["verdict"], SeverityName(Worst(findings)));
  ASSERT_EQ(data["findings"].size(), findings.size());
  bool is_named = false;
  for (std::size_t i = 0; i < findings.size(); ++i) {
    const Json& shown = data["findings"][i];
    EXPECT_EQ(shown["what"], findings[i].what);
    EXPECT_EQ(shown["value"], findings[i].value);
    EXPECT_EQ(shown["verdict"], SeverityName(findings[i].severity));
    EXPECT_EQ(shown["num_frames"], findings[i].frames.size());
    if (findings[i].what != "missing points") continue;
    is_named = true;
    EXPECT_EQ(shown["runs"], Json({{3, 3}, {9, 10}, {14, 14}}));
  }
  EXPECT_TRUE(is_named);
}

// Neither coarser numbers nor a wider view for the sake of one point; but it is counted.
TEST(ViewPageTest, PointsFarOffAreLeftOutAndTold) {
  RecordedMotion motion = SphereMotion();
  motion.positions(3 * 20, 4) = 1e5;
  motion.positions(3 * 21 + 2, 6) = -1e5;
  const Json data = PageData(ViewHtml(motion)), &replay = data["replay"];
  EXPECT_EQ(data["far"], 2);
  EXPECT_EQ(data["unseen"][4], 0);
  EXPECT_LT(replay["step"].get<double>(), 1e-4);
  EXPECT_TRUE(std::isnan(PositionOf(replay, "recorded", 25, 4, 20).x()));
  EXPECT_FALSE(std::isnan(PositionOf(replay, "recorded", 25, 5, 20).x()));
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_GT(replay["middle"][0][axis].get<double>(), -2.0);
    EXPECT_LT(replay["middle"][1][axis].get<double>(), 2.0);
  }
}

TEST(ViewPageTest, CloudsMayChangeFromFrameToFrame) {
  for (const bool keep_points : {false, true}) {
    RecordedMotion motion = MakeMotion(SwingScene(), {});
    AddClouds(20, 1e-3, keep_points, &motion);
    motion.clouds[2].conservativeResize(3, 7);
    motion.clouds[5].resize(3, 0);
    const Json data = PageData(ViewHtml(motion)), &replay = data["replay"];
    const int num_points = keep_points ? 45 : 20, first = keep_points ? 25 : 0;
    EXPECT_EQ(data["points"], first);
    EXPECT_EQ(replay["points"], num_points);
    EXPECT_EQ(replay["points_are_nodes"], false);
    EXPECT_EQ(data["cloud_points"][2], 7);
    EXPECT_EQ(data["cloud_points"][5], 0);
    EXPECT_EQ(data["cloud_stride"], 1);
    EXPECT_LT((PositionOf(replay, "recorded", num_points, 2, first + 6) - motion.clouds[2].col(6)).norm(), 1e-4);
    EXPECT_TRUE(std::isnan(PositionOf(replay, "recorded", num_points, 2, first + 7).x()));
  }
}

// Every k-th point of each cloud, so that all frames have room.
TEST(ViewPageTest, LargeCloudsAreThinned) {
  RecordedMotion motion = MakeMotion(SwingScene(), {});
  AddClouds(50000, 1e-3, false, &motion);
  const std::string html = ViewHtml(motion);
  EXPECT_LT(html.size(), kMaxReportBytes);
  const Json data = PageData(html);
  EXPECT_EQ(data["cloud_stride"], 3);
  EXPECT_EQ(data["cloud_points"][0], 50000);
  EXPECT_EQ(data["replay"]["every"], 1);
  EXPECT_EQ(data["replay"]["points"], 16667);
  EXPECT_LT((PositionOf(data["replay"], "recorded", 16667, 4, 100) - motion.clouds[4].col(300)).norm(), 1e-4);
}

// As from a tensile test: clamps and a gauge, and nobody looked at the cloth.
TEST(ViewPageTest, ForcesAloneAreShown) {
  RecordedMotion motion = MakeMotion(SwingScene(), {});
  MoveHandles(&motion);
  motion.positions.setConstant(kNaN);
  motion.forces.times = 1.7e9 + Eigen::ArrayXd::LinSpaced(5, 0.0, 0.2);
  motion.forces.values = Eigen::MatrixXd::Constant(3, 5, kNaN);
  motion.forces.values.row(2) << 1.0, 2.0, kNaN, 4.0, 5.0;
  motion.forces.sigma = Eigen::VectorXd::Constant(1, 0.1);
  const Json data = PageData(ViewHtml(motion));
  EXPECT_EQ(data["unseen"][0], 25);
  EXPECT_EQ(data["forces"]["components"].size(), 1u);
  const Json& component = data["forces"]["components"][0];
  EXPECT_EQ(component["axis"], "z");
  EXPECT_EQ(component["measured"], Json({1.0, 2.0, nullptr, 4.0, 5.0}));
  EXPECT_FALSE(component.contains("predicted"));
  EXPECT_NEAR(data["forces"]["times"][3].get<double>() - 1.7e9, 0.15, 1e-5) << "a clock that counts from 1970";
  EXPECT_NEAR(PositionOf(data["replay"], "handle_path", 2, 20, 0).z(), 0.2, 1e-4);
  EXPECT_TRUE(data["replay"].contains("start"));
}

TEST(ViewPageTest, WindIsThatOfTheScene) {
  RecordedMotion motion = MakeMotion(SwingScene(), {});
  motion.scene.wind.mean = {0.0, 1.0, 0.0};
  motion.scene.wind.gust = {0.5, 0.0, 0.0};
  motion.scene.wind.frequency = 10.0;
  const Json data = PageData(ViewHtml(motion));
  ASSERT_TRUE(data.contains("wind"));
  EXPECT_NEAR(data["wind"]["x"][6].get<double>(), 0.5 * std::sin(10.0 * motion.times[6]), 1e-5);
  EXPECT_EQ(data["wind"]["y"][6], 1.0);
  EXPECT_EQ(data["wind"]["z"][6], 0.0);
}

RecordedMotion LongMotion(int nodes_per_side, int num_frames) {
  RecordedMotion motion;
  motion.name = "long";
  motion.scene = ClothScene(nodes_per_side, num_frames);
  motion.times = Eigen::VectorXd::LinSpaced(num_frames, 0.0, 0.01 * (num_frames - 1));
  std::mt19937_64 generator(3);
  std::normal_distribution<double> normal(0.0, 2e-3);
  motion.points.resize(static_cast<std::size_t>(motion.scene.mesh.num_nodes()));
  for (int p = 0; p < motion.num_points(); ++p) motion.points[static_cast<std::size_t>(p)].nodes[0] = p;
  motion.positions = motion.scene.initial_positions.replicate(1, num_frames);
  for (double& coordinate : motion.positions.reshaped()) coordinate += normal(generator);
  return motion;
}

TEST(ViewPageTest, IsSmallWhateverTheRecording) {
  for (const auto& [nodes, frames] : {std::pair{60, 300}, std::pair{2, 120000}}) {
    RecordedMotion motion = LongMotion(nodes, frames);
    motion.scene.wind.mean = {0.0, 0.123456, 0.0};
    const std::string html = ViewHtml(motion);
    EXPECT_LT(html.size(), kMaxReportBytes);
    const Json data = PageData(html);
    ASSERT_TRUE(data["replay"].contains("every")) << nodes;
    EXPECT_GT(data["replay"]["every"], 1) << nodes;
    EXPECT_EQ(data["unseen"].size(), data["replay"]["times"].size());
    EXPECT_EQ(data["wind"]["y"].size(), data["replay"]["times"].size());
  }
}

TEST(ViewPageTest, IsOneFileWhoseNamesAreNotRun) {
  const std::string hostile = "</script><img src=x onerror=\"alert(1)\">";
  RecordedMotion motion = SphereMotion();
  motion.name = motion.provenance = motion.scene.obstacles[0].name = hostile;
  const std::string html = ViewHtml(motion);
  EXPECT_EQ(PageData(html)["name"], hostile);
  EXPECT_EQ(html.find("<img"), std::string::npos);
  EXPECT_EQ(html.find("http:"), std::string::npos);
  EXPECT_EQ(html.find("https:"), std::string::npos);
  EXPECT_EQ(html.find("{{"), std::string::npos);
  EXPECT_FALSE(std::regex_search(html, std::regex("<(script|link|iframe)[^>]*(src|href)", std::regex::icase)));
  const std::string policy =
      "content=\"default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:\"";
  EXPECT_NE(html.find(policy), std::string::npos);
  EXPECT_EQ(ViewHtml(motion), html) << "the same bytes on every run";
}

TEST(ViewPageTest, PagesHaveAName) {
  const TemporaryFolder folder;
  CheckPageOutput("--output", folder.File("a.html"));
  CheckPageOutput("--output", "/dev/null");
  ExpectError([&] { CheckPageOutput("--view", folder.File("a.bin")); }, ErrorKind::kUsage, {"--view: expected a name"});
  ExpectError([&] { CheckPageOutput("--view", folder.File("b/a.html")); }, ErrorKind::kIo, {"a.html"});
}

}  // namespace
}  // namespace clothid::view_page_test
