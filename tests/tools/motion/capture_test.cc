// The recording `capture` from the files of its camera and its gripper to estimates, as a laboratory would go.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "datasets/formats/track_file.h"
#include "datasets/motion/motion_file.h"
#include "tests/tools/tool_test.h"

namespace clothid::capture_test {
namespace {

#define RAW CLOTHID_SOURCE_DIR "/datasets/capture/"

constexpr char kShipped[] = CLOTHID_SOURCE_DIR "/datasets/capture.motion.bin";
// The command of README.md.
constexpr char kConvert[] =
    "motion convert " RAW "points.npy capture.bin --scene " RAW "scene.json --transform " RAW
    "camera.json --start_at 0 --handle_nodes 0,15,30,45,60,75,90,105,120,135,150,165,180,195,210 "
    "--handles " RAW "gripper.csv --handle_time_offset 0.75";

class CaptureTest : public ToolTest {
 protected:
  nlohmann::json Json(const std::string& name) const { return nlohmann::json::parse(ReadBytes(folder() / name)); }

  static const nlohmann::json& FindingOf(const nlohmann::json& check, const std::string& what) {
    static const nlohmann::json nothing;
    for (const nlohmann::json& finding : check["findings"]) {
      if (finding["what"] == what) return finding;
    }
    ADD_FAILURE() << "no finding about " << what;
    return nothing;
  }
};

TEST_F(CaptureTest, CheckNamesItsFaults) {
  ExpectSuccess(kConvert);
  const ToolResult result = Run("motion check capture.bin --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json check = nlohmann::json::parse(result.out);
  EXPECT_EQ(FindingOf(check, "order of points")["frames"], (std::vector<int>{21, 22}));
  EXPECT_EQ(FindingOf(check, "gaps")["frames"], std::vector<int>{18});
  EXPECT_EQ(FindingOf(check, "missing points")["verdict"], "note");
  EXPECT_EQ(FindingOf(check, "edge lengths")["verdict"], "ok");
  EXPECT_EQ(FindingOf(check, "contact")["verdict"], "ok");
}

TEST_F(CaptureTest, ConvertGivesTheShippedRecording) {
  ExpectSuccess(std::string(kConvert) + " --skip_frames 21,22");
  const MotionTensors made = ReadMotionTensors((folder() / "capture.bin").string());
  const MotionTensors shipped = ReadMotionTensors(kShipped);
  EXPECT_LT((made.times - shipped.times).cwiseAbs().maxCoeff(), 1e-12);
  ASSERT_EQ(made.handle_times.size(), shipped.handle_times.size());
  EXPECT_LT((made.handle_times - shipped.handle_times).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((made.handle_positions - shipped.handle_positions).cwiseAbs().maxCoeff(), 1e-9);
  ASSERT_EQ(made.positions.size(), shipped.positions.size());
  for (Eigen::Index i = 0; i < made.positions.size(); ++i) {
    const double a = made.positions.reshaped()[i], b = shipped.positions.reshaped()[i];
    ASSERT_TRUE(std::abs(a - b) < 1e-9 || (std::isnan(a) && std::isnan(b))) << i;
  }
}

TEST_F(CaptureTest, SimulateGivesTheRawFiles) {
  // It takes seconds, so that stderr may hold progress.
  const ToolResult result =
      Run("simulate --scene " RAW "scene.json --sensor " RAW
          "sensor.json --set mu=0.35,k_stretch=25 --seed 1 --output points.npy --handles_output gripper.csv");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const PointTracks made = ReadTracks((folder() / "points.npy").string()), shipped = ReadTracks(RAW "points.npy");
  ASSERT_EQ(made.times, shipped.times);
  ASSERT_EQ(made.positions.array().isNaN().count(), shipped.positions.array().isNaN().count());
  const Eigen::MatrixXd difference = made.positions - shipped.positions;
  EXPECT_LT(difference.array().isNaN().select(0.0, difference).cwiseAbs().maxCoeff(), 1e-5);
  EXPECT_EQ(ReadBytes(folder() / "gripper.csv"), ReadBytes(RAW "gripper.csv"));
}

TEST_F(CaptureTest, TheTruthIsInsideTheIntervals) {
  const ToolResult result = Run(std::string("identify --target ") + kShipped +
                                " --fit mu,k_stretch,time_offset --sigma auto --output result --report=false");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json parameters = Json("result/result.json")["parameters"];
  const auto expect_inside = [&](const char* name, double truth) {
    EXPECT_LE(parameters[name]["lower95"].get<double>(), truth) << name;
    EXPECT_GE(parameters[name]["upper95"].get<double>(), truth) << name;
  };
  expect_inside("mu", 0.35);
  expect_inside("k_stretch", 25.0);
  expect_inside("time_offset", 0.01);
}

}  // namespace
}  // namespace clothid::capture_test
