// Forces at the gripper from the recording to the verdict: with them stiffness and density are absolute.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "datasets/motion/motion_file.h"
#include "sim/base/error.h"
#include "tests/tools/tool_test.h"

namespace clothid::force_fit_test {
namespace {

class ForceFitTest : public ToolTest {
 protected:
  // A sheet that hangs by its upper edge, which a robot shakes. Motion alone tells k_stretch/density and no more.
  void SetUp() override {
    nlohmann::json scene = {{"clothid_scene", 2}, {"time_step", 0.01}, {"duration", 0.5}};
    scene["mesh"]["grid"] = {{"nodes", {6, 6}}, {"size", {0.25, 0.25}}, {"axes", {{1, 0, 0}, {0, 0, -1}}}};
    scene["materials"] = {{"density", 0.15}, {"k_stretch", 60}};
    scene["handles"] = {{"nodes", {0, 1, 2, 3, 4, 5}}, {"path", "path.csv"}};
    std::ofstream(folder() / "scene.json") << scene;
    std::ofstream path(folder() / "path.csv");
    path.precision(17);
    path << "time,x0,y0,z0,x1,y1,z1,x2,y2,z2,x3,y3,z3,x4,y4,z4,x5,y5,z5\n";
    for (int k = 0; k <= 50; ++k) {
      const double time = 0.01 * k;
      path << time;
      for (int node = 0; node < 6; ++node) {
        path << "," << 0.05 * node << "," << 0.02 * (1.0 - std::cos(12.0 * time)) << ","
             << 0.015 * (1.0 - std::cos(18.0 * time));
      }
      path << "\n";
    }
  }

  ToolResult Record(const std::string& flags) const {
    return Run("simulate --scene scene.json --output r.bin --set density=0.22,k_stretch=85 " + flags);
  }

  // Exit code and result.json.
  nlohmann::json Fit(const std::string& flags, int exit_code) const {
    const ToolResult result =
        Run("identify --target r.bin --jacobian sensitivity --report=false --output result " + flags);
    EXPECT_EQ(result.exit_code, exit_code) << result.out << result.err;
    return nlohmann::json::parse(ReadBytes(folder() / "result" / "result.json"));
  }

  static double Value(const nlohmann::json& result, const char* name) { return result["parameters"][name]["value"]; }
};

TEST_F(ForceFitTest, StiffnessAndDensityComeFromAWristSensor) {
  ASSERT_EQ(Record("--forces").exit_code, 0);
  const nlohmann::json result = Fit("--fit k_stretch,density", 0);
  EXPECT_NEAR(Value(result, "k_stretch"), 85.0, 85e-4);
  EXPECT_NEAR(Value(result, "density"), 0.22, 0.22e-4);
  EXPECT_LT(result["force"]["rms_N"].get<double>(), 1e-5);
  EXPECT_GT(result["force"]["start_rms_N"].get<double>(), 1e-2);
  EXPECT_EQ(result["parameters"]["density"]["identifiable"], true);
  // What was predicted is a recording with forces.
  const RecordedMotion predicted = ReadMotion((folder() / "result" / "predicted.bin").string());
  EXPECT_EQ(predicted.forces.num_readings(), 51);
}

TEST_F(ForceFitTest, WithoutForcesTheirRatioAloneIsToldApart) {
  ASSERT_EQ(Record("--noise 0.0005").exit_code, 0);
  const nlohmann::json result = Fit("--fit k_stretch,density", 4);
  EXPECT_EQ(result["parameters"]["k_stretch"]["identifiable"], false);
  EXPECT_EQ(result["parameters"]["density"]["identifiable"], false);
  EXPECT_FALSE(result.contains("force"));
}

// Its own rate, noise and offset, each half of the edge held by a hand of its own.
TEST_F(ForceFitTest, NoiseAndOffsetsOfTwoSensorsAreFoundBeside) {
  const std::string sensors =
      "--force_nodes 0,1,2:3,4,5 --force_rate 160 --force_sigma 0.01 --force_bias 0.1,-0.05,0.2";
  ASSERT_EQ(Record("--noise 0.0005 --forces " + sensors).exit_code, 0);
  const nlohmann::json result = Fit("--fit k_stretch,density,force_bias,force_bias2", 0);
  const std::pair<const char*, double> truths[] = {
      {"k_stretch", 85.0},   {"density", 0.22},      {"force_bias.x", 0.1},    {"force_bias.y", -0.05},
      {"force_bias.z", 0.2}, {"force_bias2.x", 0.1}, {"force_bias2.y", -0.05}, {"force_bias2.z", 0.2}};
  for (const auto& [name, truth] : truths) {
    const nlohmann::json& parameter = result["parameters"][name];
    const double std = parameter["std"];
    EXPECT_NEAR(parameter["value"].get<double>(), truth, 4.0 * std) << name;
    EXPECT_LT(std, 0.1 * std::abs(truth)) << name;
  }
  EXPECT_NEAR(result["force"]["rms_N"].get<double>(), 0.01, 0.001);
}

TEST_F(ForceFitTest, HoldsForcesOutWithTheirFrames) {
  ASSERT_EQ(Record("--forces --force_sigma 0.005 --noise 0.0005").exit_code, 0);
  const nlohmann::json result = Fit("--fit k_stretch,density --holdout_frames 40:51", 0);
  EXPECT_EQ(result["holdout"]["failed"], false);
  EXPECT_LT(result["holdout"]["force_rms_N"].get<double>(), 0.01);
  EXPECT_GT(result["holdout"]["nominal_force_rms_N"].get<double>(), 0.02);
  EXPECT_EQ(result["force"]["num_components"], 3 * 40);
}

// Where stiffness varies over the cloth its level is absolute, too.
TEST_F(ForceFitTest, TellsTheLevelOfAField) {
  ASSERT_EQ(Record("--noise 0.0005 --forces --force_sigma 0.002").exit_code, 0);
  // The cloth is even, so that the field itself has nothing to tell.
  const nlohmann::json result = Fit("--fit k_stretch,density --field k_stretch:3x3", kExitNotIdentifiable);
  for (const auto& [name, truth] : {std::pair("k_stretch", 85.0), std::pair("density", 0.22)}) {
    const nlohmann::json& parameter = result["parameters"][name];
    EXPECT_EQ(parameter["identifiable"], true) << name;
    EXPECT_NEAR(parameter["value"].get<double>(), truth, 4.0 * parameter["std"].get<double>()) << name;
    EXPECT_NEAR(parameter["value"].get<double>(), truth, 0.05 * truth) << name;
  }
}

// Whatever else acts at the gripper: the air across the cloth and behind it, and how large it is at rest.
TEST_F(ForceFitTest, GoesWithDragByDirectionPressureAndSize) {
  nlohmann::json scene = nlohmann::json::parse(ReadBytes(folder() / "scene.json"));
  scene["materials"].update({{"k_bend", 1e-4}, {"drag_normal", 0.2}, {"pressure", 0.5}});
  scene["wind"]["mean"] = {0.2, 1.0, 0.0};
  std::ofstream(folder() / "scene.json") << scene;
  const ToolResult recorded =
      Run("simulate --scene scene.json --output r.bin --forces --force_sigma 0.002 --noise 0.0005 "
          "--set density=0.22,k_stretch=85,drag_normal=0.35,pressure=1.2,size.x=1.02");
  ASSERT_EQ(recorded.exit_code, 0) << recorded.err;
  const nlohmann::json result = Fit("--fit k_stretch,density,drag_normal,pressure,size.x", 0);
  for (const auto& [name, truth] :
       {std::pair("k_stretch", 85.0), std::pair("density", 0.22), std::pair("drag_normal", 0.35),
        std::pair("pressure", 1.2), std::pair("size.x", 1.02)}) {
    const nlohmann::json& parameter = result["parameters"][name];
    EXPECT_NEAR(parameter["value"].get<double>(), truth, 4.0 * parameter["std"].get<double>()) << name;
    EXPECT_NEAR(parameter["value"].get<double>(), truth, 0.1 * truth) << name;
  }
}

// Pulled along its weft by a fifth of its length: the curve of force has the stiffness and how it grows.
TEST_F(ForceFitTest, TellsHowYarnsStiffen) {
  nlohmann::json scene = nlohmann::json::parse(ReadBytes(folder() / "scene.json"));
  scene["materials"] = {{"density", 0.15}, {"membrane", "yarn"},   {"k_warp", 80},        {"k_weft", 60},
                        {"k_shear", 10},   {"stiffening_warp", 3}, {"stiffening_weft", 3}};
  scene["handles"] = {{"nodes", {0, 1, 2, 3, 4, 5, 30, 31, 32, 33, 34, 35}}, {"path", "path.csv"}};
  std::ofstream(folder() / "scene.json") << scene;
  std::ofstream path(folder() / "path.csv");
  path.precision(17);
  path << "time";
  for (int i = 0; i < 12; ++i) path << ",x" << i << ",y" << i << ",z" << i;
  path << "\n";
  for (int k = 0; k <= 50; ++k) {
    path << 0.01 * k;
    for (int i = 0; i < 12; ++i) {
      path << "," << 0.05 * (i % 6) << ",0," << (i < 6 ? 0.0 : -0.25 * (1.0 + 0.2 * k / 50.0));
    }
    path << "\n";
  }
  path.close();
  const ToolResult recorded =
      Run("simulate --scene scene.json --output r.bin --forces --force_nodes 0,1,2,3,4,5 --force_sigma 0.02 "
          "--set k_weft=90,stiffening_weft=6");
  ASSERT_EQ(recorded.exit_code, 0) << recorded.err;
  const nlohmann::json result = Fit("--fit k_weft,stiffening_weft", 0);
  for (const auto& [name, truth] : {std::pair("k_weft", 90.0), std::pair("stiffening_weft", 6.0)}) {
    const nlohmann::json& parameter = result["parameters"][name];
    EXPECT_NEAR(parameter["value"].get<double>(), truth, 4.0 * parameter["std"].get<double>()) << name;
    EXPECT_NEAR(parameter["value"].get<double>(), truth, 0.05 * truth) << name;
  }
}

TEST_F(ForceFitTest, NamesWhatIsWrong) {
  EXPECT_NE(Record("--force_sigma 0.1").err.find("--force_sigma: expected with --forces"), std::string::npos);
  EXPECT_NE(Record("--forces --force_nodes 0,7").err.find("node 7 is no handle"), std::string::npos);
  ASSERT_EQ(Record("--forces").exit_code, 0);
  const ToolResult bias = Run("identify --target r.bin --fit k_stretch,force_bias2.x --output result");
  EXPECT_EQ(bias.exit_code, 1);
  EXPECT_NE(bias.err.find("has no forces along x of group 2"), std::string::npos) << bias.err;
}

}  // namespace
}  // namespace clothid::force_fit_test
