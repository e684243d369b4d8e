// Every fault that a recording may have, alone in an otherwise clean one, is found, and nothing else is.
#include "datasets/checking/motion_check.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "datasets/motion/motion_validation.h"
#include "tests/datasets/importing/made_up_capture.h"

namespace clothid::motion_check_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::vector<Finding> Check(const MotionTensors& tensors) {
  ValidateMotionTensors(tensors, "capture");
  ReadMotionOptions options;
  options.smooth_handles = false;
  return CheckMotion(InterpretMotion(tensors, "capture", options));
}

// The one finding that is not ok; the test fails where it is another one, or not alone.
Finding OnlyFinding(const MotionTensors& tensors, const std::string& what) {
  Finding found;
  for (const Finding& finding : Check(tensors)) {
    if (finding.severity == Severity::kOk) continue;
    EXPECT_EQ(finding.what, what) << finding.value;
    EXPECT_FALSE(finding.hint.empty()) << finding.what;
    if (finding.what == what) found = finding;
  }
  EXPECT_EQ(found.what, what);
  return found;
}

// Puts the points of a frame in another order: point p becomes what order(i, j) was.
template <typename Order>
void Reorder(int frame, const Order& order, MotionTensors* tensors) {
  const Eigen::VectorXd before = tensors->positions.col(frame);
  for (int j = 0; j < kCaptureRows; ++j) {
    for (int i = 0; i < kCaptureColumns; ++i) {
      tensors->positions.col(frame).segment<3>(3 * (i + kCaptureColumns * j)) = before.segment<3>(3 * order(i, j));
    }
  }
}

std::string WithObstacle(const std::string& obstacle) {
  return R"({"clothid_scene": 1, "time_step": 0.005, "handles": [0, 7], "obstacles": [)" + obstacle + "]}";
}

TEST(MotionCheck, FindsNothingInACleanCapture) {
  for (const Finding& finding : Check(MadeUpCapture())) {
    EXPECT_EQ(finding.severity, Severity::kOk) << finding.what << ": " << finding.value;
  }
}

TEST(MotionCheck, FindsNothingInMarkersOnTriangles) {
  MotionTensors tensors = MadeUpCapture();
  tensors.face_index = {3, 30, 61, 90};
  tensors.barycentric = Eigen::Matrix3Xd::Constant(3, 4, 1.0 / 3.0);
  Eigen::MatrixXd markers(12, tensors.times.size());
  for (Eigen::Index m = 0; m < 4; ++m) {
    const Eigen::Vector3i face = tensors.mesh.faces.col(tensors.face_index[m]);
    markers.middleRows<3>(3 * m) =
        (tensors.positions.middleRows<3>(3 * face[0]) + tensors.positions.middleRows<3>(3 * face[1]) +
         tensors.positions.middleRows<3>(3 * face[2])) /
        3.0;
  }
  tensors.positions = markers;
  tensors.sigma = Eigen::VectorXd::Constant(4, kCaptureNoise);
  EXPECT_EQ(Worst(Check(tensors)), Severity::kOk) << FindingsTable(Check(tensors));
}

TEST(MotionCheck, FindsIrregularTimes) {
  std::mt19937_64 generator(2);
  std::uniform_real_distribution<double> jitter(-0.2, 0.2);
  Eigen::VectorXd times(kCaptureFrames);
  for (int frame = 0; frame < kCaptureFrames; ++frame) times[frame] = (frame + jitter(generator)) / kCaptureRate;
  EXPECT_EQ(OnlyFinding(MadeUpCapture(times), "frame rate").severity, Severity::kNote);
}

TEST(MotionCheck, FindsGaps) {
  Eigen::VectorXd times(kCaptureFrames);
  for (int frame = 0; frame < kCaptureFrames; ++frame) times[frame] = (frame + (frame > 20 ? 4 : 0)) / kCaptureRate;
  EXPECT_EQ(OnlyFinding(MadeUpCapture(times), "gaps").frames, std::vector<int>{20});
}

TEST(MotionCheck, FindsMissingPoints) {
  MotionTensors tensors = MadeUpCapture();
  for (const auto& [frame, point] : {std::pair{7, 12}, {7, 30}, {41, 30}}) {
    tensors.positions.col(frame).segment<3>(3 * point).setConstant(kNaN);
  }
  const Finding finding = OnlyFinding(tensors, "missing points");
  EXPECT_EQ(finding.frames, (std::vector<int>{7, 41}));
  EXPECT_EQ(finding.points, (std::vector<int>{12, 30}));
  EXPECT_EQ(finding.severity, Severity::kNote);
  tensors.positions.middleRows<3>(3 * 5).setConstant(kNaN);
  EXPECT_EQ(OnlyFinding(tensors, "missing points").severity, Severity::kWarning);
}

// Of a tensile test: the clamps are known, and a gauge reads at one of them.
TEST(MotionCheck, FindsNothingMissingInForcesBesideKnownHandles) {
  const auto severity = [](const MotionTensors& tensors) {
    for (const Finding& finding : Check(tensors)) {
      if (finding.what == "missing points") return finding.severity;
    }
    ADD_FAILURE() << "nothing was said of missing points";
    return Severity::kProblem;
  };
  MotionTensors tensors = MadeUpCapture();
  tensors.scene_text =
      R"({"clothid_scene": 1, "time_step": 0.005, "handles": [0, 7], "initial": {"positions": "rest"}})";
  for (Eigen::Index p = 0; p < tensors.positions.rows() / 3; ++p) {
    if (p != 0 && p != kCaptureColumns - 1) tensors.positions.middleRows<3>(3 * p).setConstant(kNaN);
  }
  EXPECT_EQ(severity(tensors), Severity::kWarning) << "nothing is compared";
  tensors.forces.times = tensors.times;
  tensors.forces.values = Eigen::MatrixXd::Constant(3, tensors.times.size(), kNaN);
  tensors.forces.values.row(2) = Eigen::VectorXd::LinSpaced(tensors.times.size(), 0.0, 5.0).transpose();
  tensors.forces.sigma = Eigen::VectorXd::Constant(1, 0.1);
  EXPECT_EQ(severity(tensors), Severity::kOk);
  tensors.positions.setConstant(kNaN);
  EXPECT_EQ(severity(tensors), Severity::kOk);
}

// The handles stand where they are, and are seen all the time; the cloth between them is not.
TEST(MotionCheck, FramesThatSeeHandlesAloneAreNotRepeated) {
  MotionTensors tensors = MadeUpCapture();
  for (const int node : tensors.handle_index) {
    tensors.positions.middleRows<3>(3 * node) =
        tensors.positions.col(0).segment<3>(3 * node).replicate(1, kCaptureFrames);
  }
  tensors.handle_positions = tensors.handle_positions.col(0).replicate(1, kCaptureFrames).eval();
  MotionTensors seen = tensors;
  for (const int frame : {20, 21}) {
    for (Eigen::Index p = 0; p < tensors.positions.rows() / 3; ++p) {
      if (p != 0 && p != kCaptureColumns - 1) tensors.positions.col(frame).segment<3>(3 * p).setConstant(kNaN);
    }
  }
  for (const Finding& finding : Check(tensors)) EXPECT_NE(finding.what, "repeated frames") << finding.value;
  seen.positions.col(21) = seen.positions.col(20);
  const std::vector<Finding> findings = Check(seen);
  EXPECT_TRUE(std::any_of(findings.begin(), findings.end(),
                          [](const Finding& finding) { return finding.what == "repeated frames"; }));
}

TEST(MotionCheck, EstimatesNoise) {
  MotionTensors tensors = MadeUpCapture();
  tensors.sigma.setConstant(0.1 * kCaptureNoise);
  EXPECT_NE(OnlyFinding(tensors, "noise").hint.find("more than the file says"), std::string::npos);
  tensors.sigma.setConstant(10.0 * kCaptureNoise);
  EXPECT_NE(OnlyFinding(tensors, "noise").hint.find("less than the file says"), std::string::npos);
  tensors.sigma.resize(0);
  EXPECT_NE(OnlyFinding(tensors, "noise").hint.find("--sigma"), std::string::npos);
}

TEST(MotionCheck, FindsFlippedFrames) {
  const int last = kCaptureColumns - 1;
  const auto mirrored = [&](int i, int j) { return last - i + kCaptureColumns * j; };
  const auto upside_down = [&](int i, int j) { return i + kCaptureColumns * (kCaptureRows - 1 - j); };
  const auto transposed = [&](int i, int j) { return j + kCaptureColumns * i; };
  MotionTensors tensors = MadeUpCapture();
  Reorder(12, mirrored, &tensors);
  Reorder(30, transposed, &tensors);
  Reorder(31, transposed, &tensors);
  Reorder(50, upside_down, &tensors);
  EXPECT_EQ(OnlyFinding(tensors, "order of points").frames, (std::vector<int>{12, 30, 31, 50}));
}

TEST(MotionCheck, FindsSwappedRowsAndColumns) {
  MotionTensors tensors = MadeUpCapture();
  Reorder(
      9, [](int i, int j) { return i + kCaptureColumns * (j == 3   ? 4
                                                          : j == 4 ? 3
                                                                   : j); }, &tensors);
  Reorder(
      44, [](int i, int j) { return (i == 0   ? 1
                                     : i == 1 ? 0
                                              : i) +
                                    kCaptureColumns * j; }, &tensors);
  EXPECT_EQ(OnlyFinding(tensors, "order of points").frames, (std::vector<int>{9, 44}));
}

TEST(MotionCheck, FindsJumpsOfTheWholeCloth) {
  MotionTensors tensors = MadeUpCapture();
  for (const int frame : {25, 26}) tensors.positions.col(frame).reshaped(3, 64).row(1).array() += 0.15;
  EXPECT_EQ(OnlyFinding(tensors, "jumps of the cloth").frames, (std::vector<int>{25, 27}));
}

TEST(MotionCheck, FindsTeleportingPoints) {
  MotionTensors tensors = MadeUpCapture();
  tensors.positions.col(33).segment<3>(3 * 27) += Eigen::Vector3d(0.0, 0.08, 0.05);
  tensors.positions.col(18).segment<3>(3 * 60) -= Eigen::Vector3d(0.03, 0.0, 0.0);
  const Finding finding = OnlyFinding(tensors, "jumps of points");
  EXPECT_EQ(finding.frames, (std::vector<int>{18, 33}));
  EXPECT_EQ(finding.points, (std::vector<int>{27, 60}));
}

// One point in twenty is far off, in every frame anew: that is no matter of their order.
TEST(MotionCheck, FindsStrayPoints) {
  MotionTensors tensors = MadeUpCapture();
  std::mt19937_64 generator(3);
  std::bernoulli_distribution is_stray(0.05);
  std::normal_distribution<double> distance(0.0, 0.1);
  std::set<int> frames;
  for (int frame = 1; frame + 1 < kCaptureFrames; ++frame) {
    for (int point = 0; point < 64; ++point) {
      if (!is_stray(generator)) continue;
      frames.insert(frame);
      for (int axis = 0; axis < 3; ++axis) tensors.positions(3 * point + axis, frame) += distance(generator);
    }
  }
  for (const Finding& finding : Check(tensors)) {
    if (finding.what == "order of points") {
      EXPECT_TRUE(finding.frames.empty()) << finding.value;
    }
    if (finding.what != "jumps of points") continue;
    EXPECT_EQ(finding.severity, Severity::kWarning);
    EXPECT_GE(finding.frames.size(), 0.9 * static_cast<double>(frames.size()));
  }
}

TEST(MotionCheck, NamesTheUnit) {
  for (const auto& [scale, hint] : {std::pair{1000.0, "--scale 0.001"},
                                    {100.0, "--scale 0.01"},
                                    {1.0 / 0.0254, "--scale 0.0254"},
                                    {0.001, "mesh seems to be in mm"}}) {
    MotionTensors tensors = MadeUpCapture();
    tensors.positions *= scale;
    tensors.handle_positions *= scale;
    const Finding finding = OnlyFinding(tensors, "edge lengths");
    EXPECT_EQ(finding.severity, Severity::kProblem);
    EXPECT_NE(finding.hint.find(hint), std::string::npos) << finding.hint;
  }
}

TEST(MotionCheck, FindsAMeshOfAnotherSize) {
  MotionTensors tensors = MadeUpCapture();
  tensors.mesh.rest_positions *= 1.1;
  EXPECT_EQ(OnlyFinding(tensors, "edge lengths").severity, Severity::kNote);
  tensors.mesh.rest_positions *= 1.2;
  EXPECT_EQ(OnlyFinding(tensors, "edge lengths").severity, Severity::kWarning);
}

TEST(MotionCheck, FindsPointsListedAlongTheOtherAxis) {
  MotionTensors tensors = MadeUpCapture();
  tensors.positions.conservativeResize(3 * 48, Eigen::NoChange);  // 8 x 6
  GridOptions grid;
  grid.nodes = {6, 8};
  grid.size = {5 * kCaptureSpacing, 7 * kCaptureSpacing};
  tensors.mesh = MakeGrid(grid);
  tensors.sigma = Eigen::VectorXd::Constant(48, kCaptureNoise);
  tensors.handle_index = {0};
  tensors.handle_positions = tensors.handle_positions.topRows<3>().eval();
  tensors.scene_text = R"({"clothid_scene": 1})";
  const Finding finding = OnlyFinding(tensors, "edge lengths");
  EXPECT_EQ(finding.severity, Severity::kWarning);
  EXPECT_NE(finding.hint.find("--transpose"), std::string::npos) << finding.value << finding.hint;
}

TEST(MotionCheck, FindsHandlesThatStandStill) {
  MotionTensors tensors = MadeUpCapture();
  tensors.handle_index.clear();
  tensors.handle_positions.resize(0, 0);
  tensors.scene_text =
      R"({"clothid_scene": 1, "time_step": 0.005, "handles": [0, 7], "initial": {"velocity": [0.48, 0, 0]}})";
  EXPECT_NE(OnlyFinding(tensors, "handles").hint.find("--handle_nodes"), std::string::npos);
}

TEST(MotionCheck, FindsHandlesOnAnotherClock) {
  constexpr double kAhead = 0.25;  // s
  MotionTensors tensors = MadeUpCapture();
  for (Eigen::Index frame = 0; frame < tensors.times.size(); ++frame) {
    tensors.handle_positions.col(frame) << CapturedPlace(0, 0, tensors.times[frame] - kAhead),
        CapturedPlace(7, 0, tensors.times[frame] - kAhead);
  }
  const Finding finding = OnlyFinding(tensors, "handles");
  EXPECT_NE(finding.hint.find("0.25 s ahead"), std::string::npos) << finding.hint;
}

TEST(MotionCheck, FindsHandlesInAnotherFrameOfReference) {
  MotionTensors tensors = MadeUpCapture();
  tensors.handle_positions.reshaped(3, 2 * tensors.times.size()).row(1).array() += 0.05;
  EXPECT_NE(OnlyFinding(tensors, "handles").hint.find("--handle_transform"), std::string::npos);
}

TEST(MotionCheck, FindsJumpingHandles) {
  MotionTensors tensors = MadeUpCapture();
  tensors.handle_positions(4, 25) += 0.09;
  const Finding finding = OnlyFinding(tensors, "jumps of handles");
  EXPECT_EQ(finding.frames, (std::vector<int>{25, 26}));
  EXPECT_NE(finding.value.find("node 7"), std::string::npos) << finding.value;
}

// The lower edge swings towards a ball and is nearest to it at the start.
TEST(MotionCheck, FindsAStartInsideAnObstacle) {
  MotionTensors tensors = MadeUpCapture();
  const auto ball = [](double y) {
    return WithObstacle(R"({"type": "sphere", "center": [0.12, )" + std::to_string(y) + R"(, 0.72], "radius": 0.05})");
  };
  tensors.scene_text = ball(0.089);
  EXPECT_LE(Worst(Check(tensors)), Severity::kNote) << FindingsTable(Check(tensors));  // no more than the noise
  tensors.scene_text = ball(0.08);
  EXPECT_EQ(OnlyFinding(tensors, "start").severity, Severity::kWarning);
}

TEST(MotionCheck, FindsAnObstacleThatIsNotTouchedOrFarTooDeep) {
  MotionTensors tensors = MadeUpCapture();
  const auto floor = [](const char* height) {
    return WithObstacle(R"({"type": "plane", "point": [0, 0, )" + std::string(height) + R"(], "normal": [0, 0, 1]})");
  };
  tensors.scene_text = floor("0.6");
  EXPECT_NE(OnlyFinding(tensors, "contact").hint.find("friction"), std::string::npos);
  tensors.scene_text = floor("0.8");
  bool deep = false;
  for (const Finding& finding : Check(tensors)) deep |= finding.what == "contact" && finding.frames.size() == 60;
  EXPECT_TRUE(deep);
}

TEST(MotionCheck, FindsAnotherFrameOfReference) {
  MotionTensors tensors = MadeUpCapture();
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.5, Eigen::Vector3d::UnitX()).toRotationMatrix();
  for (Eigen::MatrixXd* positions : {&tensors.positions, &tensors.handle_positions}) {
    const Eigen::Matrix3Xd turned = turn * positions->reshaped(3, positions->size() / 3);
    *positions = turned.reshaped(positions->rows(), positions->cols());
  }
  EXPECT_NE(OnlyFinding(tensors, "direction of gravity").hint.find("--transform"), std::string::npos);
}

TEST(MotionCheck, FindsATimeStepThatIsTooLarge) {
  MotionTensors tensors = MadeUpCapture();
  tensors.scene_text = R"({"clothid_scene": 1, "time_step": 0.1, "handles": [0, 7]})";
  EXPECT_EQ(OnlyFinding(tensors, "time step").severity, Severity::kWarning);
}

TEST(MotionCheck, LooksAtShortRecordings) {
  for (const int num_frames : {2, 3, 4}) {
    MotionTensors tensors = MadeUpCapture(Eigen::VectorXd::LinSpaced(num_frames, 0.0, (num_frames - 1) / kCaptureRate));
    EXPECT_LE(Worst(Check(tensors)), Severity::kNote) << num_frames << "\n" << FindingsTable(Check(tensors));
  }
}

TEST(MotionCheck, WritesFindingsAsJson) {
  MotionTensors tensors = MadeUpCapture();
  tensors.positions.col(7).segment<3>(3 * 12).setConstant(kNaN);
  const std::vector<Finding> findings = Check(tensors);
  const nlohmann::json report = nlohmann::json::parse(FindingsJson(findings, "cloth \"a\".bin"));
  EXPECT_EQ(report["schema"], "clothid.check/1");
  EXPECT_EQ(report["file"], "cloth \"a\".bin");
  EXPECT_EQ(report["verdict"], "note");
  ASSERT_EQ(report["findings"].size(), findings.size());
  EXPECT_EQ(report["findings"][2]["what"], "missing points");
  EXPECT_EQ(report["findings"][2]["frames"], nlohmann::json::array({7}));
  EXPECT_EQ(report["findings"][2]["points"], nlohmann::json::array({12}));
}

}  // namespace
}  // namespace clothid::motion_check_test
