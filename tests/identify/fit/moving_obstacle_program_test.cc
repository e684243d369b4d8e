// Obstacles that move from the command line to the files: a path, its recording, fit, landscape, replay, export.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "tests/tools/small_drape.h"
#include "tests/tools/tool_test.h"

namespace clothid::moving_obstacle_program_test {
namespace {

using Json = nlohmann::ordered_json;

// A bar that sweeps under the cloth, rises and turns a little.
std::string BarPath() {
  std::ostringstream text;
  text.precision(17);
  text << "time,x,y,z,qx,qy,qz,qw\n";
  for (int i = 0; i <= 40; ++i) {
    const double t = 0.01 * i, turn = 0.5 * t;
    text << t << "," << 0.15 * std::sin(5.0 * t) << "," << 0.25 - 0.2 * t << "," << -0.3 + 0.3 * t * t << ",0,0,"
         << std::sin(0.5 * turn) << "," << std::cos(0.5 * turn) << "\n";
  }
  return text.str();
}

class MovingObstacleProgramTest : public ToolTest {
 protected:
  MovingObstacleProgramTest() {
    WriteBytes(folder() / "bar.csv", BarPath());
    scene_ = Json::parse(SmallDrape(6));
    scene_["clothid_scene"] = 2;
    scene_["obstacles"] = {{{"name", "bar"},
                            {"type", "capsule"},
                            {"from", {-0.3, 0, 0}},
                            {"to", {0.3, 0, 0}},
                            {"radius", 0.08},
                            {"mu", 0.4},
                            {"path", "bar.csv"}}};
    scene_["duration"] = 0.4;
    WriteScene(scene_);
  }

  Json scene_;
};

TEST_F(MovingObstacleProgramTest, GoFromThePathToTheResult) {
  ExpectSuccess(
      "simulate --scene scene.json --set bar.time_offset=0.012,bar.shift.z=0.004 --noise 0.0005 "
      "--output cloth.bin");
  std::filesystem::remove(folder() / "bar.csv");  // a recording stands on its own
  ExpectSuccess("motion check cloth.bin");
  const ToolResult fit =
      Run("identify --target cloth.bin --start mu=0.3 --fit mu,k_stretch,bar.time_offset,bar.shift.z --output result "
          "--export mujoco");
  EXPECT_EQ(fit.exit_code, 0) << fit.err << fit.out;
  const Json parameters = Json::parse(ReadBytes(folder() / "result" / "result.json"))["parameters"];
  const auto expect_held = [&](const char* name, double truth, double most_width) {
    const double lower = parameters[name]["lower95"], upper = parameters[name]["upper95"];
    EXPECT_LE(lower, truth) << name << fit.out;
    EXPECT_GE(upper, truth) << name << fit.out;
    EXPECT_LE(upper - lower, most_width) << name << fit.out;
  };
  expect_held("mu", 0.4, 0.6);
  expect_held("bar.time_offset", 0.012, 0.03);
  expect_held("bar.shift.z", 0.004, 0.01);
  const std::string model = ReadBytes(folder() / "result" / "export_mujoco.xml");
  EXPECT_NE(model.find("<body name=\"bar.path\" mocap=\"true\""), std::string::npos);
  EXPECT_NE(model.find("<weld body1=\"bar.path\" body2=\"bar\""), std::string::npos);
  const ToolResult scan =
      Run("landscape --target cloth.bin --x bar.time_offset=0:0.02:3 --y mu=0.3:0.5:3 --output map");
  EXPECT_EQ(scan.exit_code, 0) << scan.err;
}

TEST_F(MovingObstacleProgramTest, TakesAttachedNodesAlong) {
  scene_["handles"] = {{"nodes", {0, 1}}, {"attach", "bar"}};
  scene_["obstacles"].push_back({{"name", "floor"}, {"type", "plane"}, {"point", {0, 0, -2}}, {"normal", {0, 0, 1}}});
  WriteScene(scene_);
  ExpectSuccess("simulate --scene scene.json --output held.bin");
  const ToolResult info = Run("motion info held.bin");
  EXPECT_NE(info.out.find("handles 2 (moving)"), std::string::npos) << info.out;
  ExpectSuccess("motion check held.bin");
  const auto expect = [&](const Json& handles, const char* message) {
    scene_["handles"] = handles;
    WriteScene(scene_, "wrong.json");
    ExpectRefused("simulate --scene wrong.json --output x.bin", 2, message);
  };
  expect({{"nodes", {0, 1}}, {"attach", "floor"}}, "handles.attach': expected the name of an obstacle that has a path");
  expect({{"nodes", {0, 1}}, {"attach", "bar"}, {"path", "bar.csv"}},
         "expected one of \"path\", \"poses\" and \"attach\"");
}

TEST_F(MovingObstacleProgramTest, WrongPathsAreOneLineEach) {
  ExpectRefused("simulate --scene scene.json --set bar.shift=0.1 --output x.bin", 1, "unknown parameter 'bar.shift'");
  Json& bar = scene_["obstacles"][0];
  const auto expect = [&](const Json& path, const char* message) {
    bar["path"] = path;
    WriteScene(scene_, "wrong.json");
    ExpectRefused("simulate --scene wrong.json --output x.bin", 2, message);
  };
  expect({{0, 0, 0, 0, 0, 0, 1}}, "expected [time, x, y, z, qx, qy, qz, qw]");
  expect({{0, 0, 0, 0, 0, 0, 0, 1}, {0.1, 9, 0, 0, 0, 0, 0, 1}}, "row 1: the path jumps: it has a speed of 90");
  expect({{0, 0, 0, 0, 0, 0, 0, 2}}, "row 0: expected a quaternion");
  expect(Json::array(), "at least one pose");
  WriteBytes(folder() / "bad.csv", "time,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n0,0,0,0,0,0,0,1\n");
  expect("bad.csv", "bad.csv:3: column 'time': expected a time after 0 s of line 2, found '0'");
  bar.erase("path");
  WriteScene(scene_, "still.json");
  ExpectRefused("simulate --scene still.json --set bar.shift.x=0.1 --output x.bin", 1, "the scene has no such term");
}

}  // namespace
}  // namespace clothid::moving_obstacle_program_test
