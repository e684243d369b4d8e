// What `motion check` says of a recording against its scene: the start, the handles, gravity, constants, clouds; and
// that its hints name what is wrong.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "datasets/checking/check_start.h"
#include "datasets/checking/motion_check.h"
#include "datasets/synthetic/synthetic.h"
#include "datasets/synthetic/true_parameters.h"
#include "sim/scene/scene_json.h"
#include "tests/datasets/importing/made_up_capture.h"
#include "tests/sim/scene/triangle_meshes.h"

namespace clothid::scene_check_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::vector<Finding> Check(const MotionTensors& tensors) {
  ReadMotionOptions options;
  options.smooth_handles = false;
  return CheckMotion(InterpretMotion(tensors, "capture", options));
}

// The finding of this name; one without a name where there is none.
Finding FindingOf(const MotionTensors& tensors, const std::string& what) {
  for (const Finding& finding : Check(tensors)) {
    if (finding.what == what) return finding;
  }
  return {};
}

void ExpectWarning(const MotionTensors& tensors, const std::string& what, const std::string& hint) {
  const Finding finding = FindingOf(tensors, what);
  EXPECT_EQ(finding.severity, Severity::kWarning) << what << "\n" << FindingsTable(Check(tensors));
  EXPECT_NE(finding.hint.find(hint), std::string::npos) << finding.hint;
}

// The capture in a scene whose cloth starts where the mesh is: at rest, in the plane of the capture.
MotionTensors StartAtRest() {
  MotionTensors tensors = MadeUpCapture();
  for (int p = 0; p < 64; ++p) tensors.mesh.rest_positions.col(p) = CapturedPlace(p % 8, p / 8, 0.0);
  tensors.scene_text =
      R"({"clothid_scene": 1, "time_step": 0.005, "handles": [0, 7], "initial": {"positions": "rest"}})";
  return tensors;
}

// A cloth of 8 x 8 nodes that is let go and falls as a whole, without handles.
MotionTensors FreeFall(double gravity, double duration = 0.25) {
  MotionTensors tensors = MadeUpCapture(Eigen::VectorXd::LinSpaced(15, 0.0, duration));
  tensors.handle_index.clear();
  tensors.handle_positions.resize(0, 0);
  tensors.scene_text = R"({"clothid_scene": 1, "time_step": 0.005})";
  const Eigen::VectorXd start = tensors.positions.col(0);
  std::mt19937_64 generator(5);
  std::normal_distribution<double> noise(0.0, kCaptureNoise);
  for (Eigen::Index frame = 0; frame < tensors.times.size(); ++frame) {
    tensors.positions.col(frame) = start;
    tensors.positions.col(frame).reshaped(3, 64).row(2).array() -= 0.5 * gravity * std::pow(tensors.times[frame], 2);
    for (double& coordinate : tensors.positions.col(frame)) coordinate += noise(generator);
  }
  return tensors;
}

TEST(SceneCheck, TellsWhereTheClothStarts) {
  MotionTensors tensors = StartAtRest();
  EXPECT_EQ(FindingOf(tensors, "first frame").severity, Severity::kOk);
  tensors.mesh.rest_positions.row(0).array() += 0.03;
  ExpectWarning(tensors, "first frame", "all of them are off by (-29");
  ExpectWarning(tensors, "start of handles", "their path begins elsewhere");
  tensors.mesh.rest_positions.row(0).array() += 3.0;
  EXPECT_EQ(FindingOf(tensors, "first frame").severity, Severity::kProblem);
}

TEST(SceneCheck, NamesMistakenAxesAndOrders) {
  MotionTensors tensors = StartAtRest();
  for (auto point : tensors.positions.reshaped(3, tensors.positions.size() / 3).colwise()) {
    point = Eigen::Vector3d(point.z(), -point.x(), point.y());
  }
  EXPECT_NE(FindingOf(tensors, "first frame").hint.find("axes (-y, z, x)"), std::string::npos);
  tensors = StartAtRest();
  const Eigen::MatrixXd before = tensors.positions;
  for (int p = 0; p < 64; ++p) {
    tensors.positions.middleRows<3>(3 * p) = before.middleRows<3>(3 * (p / 8 + 8 * (p % 8)));
  }
  ExpectWarning(tensors, "first frame", "another order of the grid");
}

TEST(SceneCheck, ExplainsTurnedPoints) {
  Eigen::Matrix3Xd expected = MadeUpCapture().positions.col(0).reshaped(3, 64);
  expected.colwise() -= expected.rowwise().mean().eval();
  const Eigen::AngleAxisd turn(0.7, Eigen::Vector3d(1.0, 2.0, 3.0).normalized());
  const Eigen::Matrix3Xd turned = (turn.toRotationMatrix() * expected).colwise() + Eigen::Vector3d(0.3, 0.2, 0.1);
  EXPECT_NE(Explanation(expected, turned, {}).find("turned and shifted"), std::string::npos);
  EXPECT_EQ(Explanation(expected, expected * 1.3, {}), "");
}

TEST(SceneCheck, NamesOutliersOfTheFirstFrame) {
  MotionTensors tensors = MadeUpCapture();
  tensors.positions.col(0).segment<3>(3 * 20).array() += 0.05;
  ExpectWarning(tensors, "first frame", "--skip_frames 0");
  EXPECT_EQ(FindingOf(tensors, "first frame").points, std::vector<int>{20});
  EXPECT_EQ(FindingOf(tensors, "jumps of points").frames, std::vector<int>{0});
  ReadMotionOptions options;
  options.start = StartSource::kSmoothed;  // which an outlier does not move
  for (const Finding& finding : CheckMotion(InterpretMotion(tensors, "capture", options))) {
    EXPECT_TRUE(finding.severity < Severity::kWarning || finding.what == "jumps of points") << finding.what;
  }
}

TEST(SceneCheck, TellsThatNothingIsSeen) {
  MotionTensors tensors = StartAtRest();
  tensors.positions.setConstant(kNaN);
  const std::vector<Finding> findings = Check(tensors);
  EXPECT_EQ(FindingOf(tensors, "missing points").severity, Severity::kProblem);
  EXPECT_EQ(FindingsTable(findings).find("in mm"), std::string::npos) << FindingsTable(findings);
}

TEST(SceneCheck, MeasuresAFreeFall) {
  EXPECT_EQ(FindingOf(FreeFall(9.81), "fall").severity, Severity::kOk);
  EXPECT_NE(FindingOf(FreeFall(9.81), "fall").value.find("gravity alone: 9.81"), std::string::npos);
  EXPECT_LE(Worst(Check(FreeFall(9.81))), Severity::kNote) << FindingsTable(Check(FreeFall(9.81)));
  ExpectWarning(FreeFall(2.5), "fall", "--frame_rate");
  EXPECT_EQ(FindingOf(FreeFall(6.0), "fall").severity, Severity::kOk) << "in air";
  ExpectWarning(FreeFall(-9.81), "fall", "direction of gravity");
  ExpectWarning(FreeFall(20.0), "energy", "--frame_rate");
}

// In slow motion no hand holds cloth that falls evenly.
TEST(SceneCheck, TellsASlowClockFromAHandThatHolds) {
  for (const double clock : {2.0, 3.0, 4.0}) {
    MotionTensors slow = FreeFall(9.81 / (clock * clock), 0.25 * clock);
    EXPECT_EQ(FindingOf(slow, "held points").what, "") << clock << FindingOf(slow, "held points").value;
    ExpectWarning(slow, "fall", "--time_scale " + std::string(clock == 2.0 ? "0.5" : clock == 3.0 ? "0.3" : "0.2"));
    const Eigen::VectorXd start = slow.positions.col(0);
    for (const int corner : {0, 7}) {
      slow.positions.middleRows(3 * corner, 3).colwise() = start.segment<3>(3 * corner);
    }
    EXPECT_EQ(FindingOf(slow, "held points").points, (std::vector<int>{0, 7})) << clock;
  }
}

// A strip of 5 x 9 nodes, 0.2 m x 0.4 m, that hangs from its upper edge at `tilt` degrees from level, let go and seen
// for two seconds; by a clock that shows `clock` of the time that went by, the handles measured like all points.
MotionTensors LetGo(double tilt, double clock, double noise) {
  const double angle = tilt * 3.14159265358979 / 180.0;
  const nlohmann::json text = {
      {"clothid_scene", 2},
      {"time_step", 0.01},
      {"duration", 3.0},
      {"mesh",
       {{"grid",
         {{"nodes", {5, 9}}, {"size", {0.2, 0.4}}, {"axes", {{1, 0, 0}, {0, std::cos(angle), -std::sin(angle)}}}}}}},
      {"initial", {{"positions", "rest"}}},
      {"handles", {0, 1, 2, 3, 4}},
      {"materials", {{"density", 0.2}, {"k_stretch", 200}, {"k_bend", 1e-4}, {"drag", 0.1}}}};
  const Scene scene = ParseScene(text.dump(), "scene", "");
  SyntheticOptions options;
  options.noise_sigma = noise;
  MotionTensors tensors = RecordRollout(SimulateTruth({}, "scene", scene), scene, text.dump(), options);
  tensors.times *= clock;
  tensors.handle_index = {0, 1, 2, 3, 4};
  tensors.handle_positions = tensors.positions.topRows(15);
  return tensors;
}

// Neither cloth that is let go from level, nor one that swings, is taken for one on another clock.
TEST(SceneCheck, KnowsTheClockOfClothThatIsLetGo) {
  for (const double noise : {0.0, 0.001, 0.003}) {
    for (const double tilt : {0.0, 30.0, 70.0}) {
      for (const char* what : {"fall", "swing", "energy"}) {
        const Finding finding = FindingOf(LetGo(tilt, 1.0, noise), what);
        EXPECT_EQ(finding.severity, Severity::kOk) << tilt << ", " << noise << ": " << finding.value;
      }
    }
    const Finding fast = FindingOf(LetGo(0.0, 0.316, noise), "fall");
    if (noise < 0.002) {
      EXPECT_EQ(fast.severity, Severity::kProblem) << noise;
      EXPECT_NE(fast.value.find("times gravity"), std::string::npos) << fast.value;
      const std::size_t place = fast.hint.find("--time_scale ");
      ASSERT_NE(place, std::string::npos) << fast.hint;
      EXPECT_NEAR(std::stod(fast.hint.substr(place + 13)), 1.0 / 0.316, 0.3);
    }
    ExpectWarning(LetGo(70.0, 0.316, noise), "swing", "--time_scale");
    ExpectWarning(LetGo(70.0, 4.0, noise), "swing", "--time_scale 0.2");
  }
  EXPECT_EQ(FindingOf(FreeFall(98.1, 0.14), "fall").severity, Severity::kProblem);
}

// Air that moves with a cloth has no weight: 0.1 kg/m^2 of cloth that moves 0.2 kg/m^2 of air falls by a third of g.
TEST(SceneCheck, AFallMovesTheMassOfTheAir) {
  MotionTensors tensors = FreeFall(3.27);
  EXPECT_EQ(FindingOf(tensors, "fall").severity, Severity::kWarning);
  tensors.scene_text = R"({"clothid_scene": 2, "time_step": 0.005, "materials": {"density": 0.1, "added_mass": 0.2}})";
  EXPECT_EQ(FindingOf(tensors, "fall").severity, Severity::kOk);
  EXPECT_NE(FindingOf(tensors, "fall").value.find("gravity alone: 3.27"), std::string::npos);
}

TEST(SceneCheck, KnowsUsualConstants) {
  MotionTensors tensors = MadeUpCapture();
  const auto with = [&](const std::string& constant) {
    tensors.scene_text = R"({"clothid_scene": 1, "time_step": 0.005, "handles": [0, 7], )" + constant + "}";
    return tensors;
  };
  EXPECT_EQ(FindingOf(with(R"("materials": {"density": 0.2})"), "density").what, "");
  EXPECT_EQ(FindingOf(with(R"("materials": {"density": 0.7})"), "density").severity, Severity::kNote);
  ExpectWarning(with(R"("materials": {"density": 200})"), "density", "g/m^2");
  ExpectWarning(with(R"("materials": {"density": 0.002})"), "density", "kg/m^2");
  ExpectWarning(with(R"("gravity": [0, 0, -9810])"), "gravity", "9.81");
  EXPECT_EQ(FindingOf(with(R"("gravity": [0, 0, 0])"), "gravity").severity, Severity::kNote);
}

TEST(SceneCheck, FindsHolesInThePathOfHandles) {
  MotionTensors tensors = MadeUpCapture();
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = 0; k < tensors.times.size(); ++k) {
    if (k < 20 || k > 35) kept.push_back(k);
  }
  tensors.handle_times = tensors.times(kept);
  tensors.handle_positions = tensors.handle_positions(Eigen::all, kept).eval();
  EXPECT_NE(FindingOf(tensors, "path of handles").value.find("0.567 s from 0.633 s on"), std::string::npos)
      << FindingOf(tensors, "path of handles").value;
}

// The capture, with a bar that goes along x beside it, 0.01 m and 0.02 rad per row at 30 Hz, but for what `change`
// does.
MotionTensors WithBar(int num_rows, const std::function<void(nlohmann::json*)>& change) {
  MotionTensors tensors = MadeUpCapture();
  nlohmann::json rows = nlohmann::json::array();
  for (int i = 0; i < num_rows; ++i) {
    rows.push_back({i / kCaptureRate, 0.01 * i, 0.3, 0.5, 0.0, 0.0, std::sin(0.01 * i), std::cos(0.01 * i)});
  }
  change(&rows);
  nlohmann::json scene = nlohmann::json::parse(tensors.scene_text);
  scene["obstacles"] = {{{"name", "bar"}, {"type", "sphere"}, {"center", {0, 0, 0}}, {"radius", 0.1}, {"path", rows}},
                        {{"name", "floor"}, {"type", "plane"}, {"point", {0, 0, 0}}, {"normal", {0, 0, 1}}}};
  tensors.scene_text = scene.dump();
  return tensors;
}

// The capture, with a box that is stretched beside it, by 0.02 of its length per frame at 30 Hz, but for a jump.
TEST(SceneCheck, FindsJumpsAndEndsOfASequence) {
  const auto with_box = [](int num_frames, double jump) {
    MotionTensors tensors = MadeUpCapture();
    const TriangleMesh box = CubeMesh(0.1);
    nlohmann::json body = {{"name", "box"}, {"type", "mesh"}}, times;
    for (const auto& vertex : box.vertices.colwise()) body["vertices"].push_back({vertex[0], vertex[1], vertex[2]});
    for (const auto& face : box.faces.colwise()) body["faces"].push_back({face[0], face[1], face[2]});
    Eigen::MatrixXd& positions = tensors.sequences["box"];
    positions.resize(24, num_frames);
    for (int i = 0; i < num_frames; ++i) {
      times.push_back(i / kCaptureRate);
      positions.col(i) = (1.0 + 0.02 * i) * box.vertices.reshaped();
      if (i > 20) positions.col(i).array() += jump;
    }
    body["sequence"] = {{"times", times}};
    nlohmann::json scene = nlohmann::json::parse(tensors.scene_text);
    scene["obstacles"] = {body};
    tensors.scene_text = scene.dump();
    return tensors;
  };
  const Finding whole = FindingOf(with_box(kCaptureFrames, 0.0), "sequence of box");
  EXPECT_EQ(whole.severity, Severity::kOk) << whole.value;
  EXPECT_EQ(whole.value, "60 frames from 0 s to 1.97 s");
  ExpectWarning(with_box(kCaptureFrames, 0.3), "sequence of box", "hit or left behind");
  ExpectWarning(with_box(37, 0.0), "sequence of box", "complete the path");
}

TEST(SceneCheck, FindsEndsAndHolesOfThePathOfAnObstacle) {
  const auto keep = [](nlohmann::json*) {};
  const Finding whole = FindingOf(WithBar(kCaptureFrames, keep), "path of bar");
  EXPECT_EQ(whole.severity, Severity::kOk) << whole.value;
  EXPECT_EQ(whole.value, "60 poses from 0 s to 1.97 s");
  EXPECT_EQ(FindingOf(WithBar(kCaptureFrames, keep), "path of floor").what, "");
  EXPECT_EQ(FindingOf(WithBar(1, keep), "path of bar").severity, Severity::kOk);
  ExpectWarning(WithBar(37, keep), "path of bar", "complete the path");
  EXPECT_NE(FindingOf(WithBar(37, keep), "path of bar").value.find("not known for all after its end at 1.2 s"),
            std::string::npos);
  const auto rest_at_end = [](nlohmann::json* rows) {
    for (std::size_t i = 31; i < rows->size(); ++i) {
      for (std::size_t k = 1; k < 8; ++k) (*rows)[i][k] = (*rows)[30][k];
    }
  };
  EXPECT_EQ(FindingOf(WithBar(37, rest_at_end), "path of bar").severity, Severity::kOk);
  const auto leave_out = [](nlohmann::json* rows) { rows->erase(rows->begin() + 20, rows->begin() + 30); };
  EXPECT_NE(FindingOf(WithBar(kCaptureFrames, leave_out), "path of bar").value.find("0.367 s from 0.633 s on"),
            std::string::npos);
}

TEST(SceneCheck, FindsThePathOfAnObstacleOnAnotherClock) {
  const auto late = [](nlohmann::json* rows) {
    for (auto& row : *rows) row[0] = row[0].get<double>() + 100.0;
  };
  ExpectWarning(WithBar(kCaptureFrames, late), "path of bar", "--obstacle_time_offset");
}

TEST(SceneCheck, FindsJumpsOfThePathOfAnObstacle) {
  const auto shift = [](nlohmann::json* rows) { (*rows)[25][2] = 0.42; };
  const auto turn = [](nlohmann::json* rows) {
    (*rows)[25][6] = std::sin(0.85);
    (*rows)[25][7] = std::cos(0.85);
  };
  const auto lasting = [](nlohmann::json* rows) {
    for (std::size_t i = 40; i < rows->size(); ++i) (*rows)[i][3] = 0.7;
  };
  for (const auto& [change, value] :
       {std::pair<std::function<void(nlohmann::json*)>, const char*>{shift, "jumps at 0.833 s and until 0.867 s"},
        {turn, "jumps at 0.833 s and until 0.867 s"},
        {lasting, "jumps at 1.33 s"}}) {
    const MotionTensors tensors = WithBar(kCaptureFrames, change);
    ExpectWarning(tensors, "path of bar", "hit or left behind");
    const std::string found = FindingOf(tensors, "path of bar").value;
    EXPECT_NE(found.find(value), std::string::npos) << found;
  }
}

// A ball flies into the cloth and stays there from 1 s on.
TEST(SceneCheck, NamesTheObstacleThatPointsAreDeepInside) {
  const MotionTensors tensors = WithBar(kCaptureFrames, [](nlohmann::json* rows) {
    for (std::size_t i = 0; i < rows->size(); ++i) {
      (*rows)[i][1] = 0.14;
      (*rows)[i][2] = i < 30 ? 0.3 - 0.01 * static_cast<double>(i) : 0.0;
      (*rows)[i][3] = 0.86;
    }
  });
  ExpectWarning(tensors, "contact", "deep inside bar in frames");
  const std::vector<int> frames = FindingOf(tensors, "contact").frames;
  ASSERT_FALSE(frames.empty());
  EXPECT_GT(frames.front(), 20);
  EXPECT_EQ(frames.back(), kCaptureFrames - 1);
}

TEST(SceneCheck, FindsCopies) {
  MotionTensors tensors = MadeUpCapture();
  tensors.positions.col(30) = tensors.positions.col(31) = tensors.positions.col(29);
  EXPECT_EQ(FindingOf(tensors, "repeated frames").frames, (std::vector<int>{30, 31}));
  tensors = MadeUpCapture();
  tensors.positions.middleRows<3>(3 * 9) = tensors.positions.middleRows<3>(3 * 50);
  EXPECT_EQ(FindingOf(tensors, "repeated points").points, std::vector<int>{50});
}

TEST(SceneCheck, LooksAtClouds) {
  MotionTensors tensors = MadeUpCapture();
  for (Eigen::Index frame = 0; frame < tensors.times.size(); ++frame) {
    tensors.clouds.emplace_back(tensors.positions.col(frame).reshaped(3, 64));
  }
  tensors.positions.resize(0, tensors.times.size());
  tensors.sigma.resize(0);
  tensors.cloud_sigma = kCaptureNoise;
  tensors.node_index.clear();
  Eigen::MatrixXd rest(3, 64);
  for (int p = 0; p < 64; ++p) rest.col(p) = CapturedPlace(p % 8, p / 8, 0.0);
  tensors.mesh.rest_positions = rest;
  tensors.scene_text =
      R"({"clothid_scene": 1, "time_step": 0.005, "handles": [0, 7], "initial": {"positions": "rest"}})";
  EXPECT_EQ(Worst(Check(tensors)), Severity::kOk) << FindingsTable(Check(tensors));
  MotionTensors far = tensors, large = tensors;
  for (Eigen::Matrix3Xd& cloud : far.clouds) cloud.row(1).array() += 318.0;
  EXPECT_EQ(FindingOf(far, "place of clouds").severity, Severity::kProblem);
  for (Eigen::Matrix3Xd& cloud : large.clouds) cloud *= 1000.0;
  EXPECT_NE(FindingOf(large, "size of clouds").hint.find("--scale 0.001"), std::string::npos);
  MotionTensors late = tensors;
  late.handle_positions.reshaped(3, late.handle_positions.size() / 3).row(1).array() += 0.2;
  ExpectWarning(late, "clouds near handles", "frame of reference");
}

}  // namespace
}  // namespace clothid::scene_check_test
