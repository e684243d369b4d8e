// A cloth with constants of its own along warp and weft, from its scene to the verdict of a fit.
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/tools/tool_test.h"

namespace clothid::woven_cloth_test {
namespace {

const char* const kConstants = "k_warp,k_weft,k_shear,k_poisson,bend_warp,bend_weft,bend_twist";
const std::map<std::string, double> kTruth = {{"k_warp", 90.0},    {"k_weft", 50.0},    {"k_shear", 6.0},
                                              {"k_poisson", 15.0}, {"bend_warp", 2e-4}, {"bend_weft", 1e-4},
                                              {"bend_twist", 7e-5}};

class WovenClothTest : public ToolTest {
 protected:
  // A sheet that hangs by `handles` in a wind that blows through it. The nominal constants are off by 1/3 to 2/3.
  void WriteScene(const std::string& name, const std::vector<int>& handles, const nlohmann::json& wind) const {
    nlohmann::json scene = {{"clothid_scene", 1}, {"time_step", 0.01}, {"integrator", "sdirk2"}, {"duration", 0.5}};
    scene["mesh"]["grid"] = {{"nodes", {8, 8}}, {"size", {0.3, 0.3}}, {"axes", {{1, 0, 0}, {0, 0, -1}}}};
    scene["materials"] = {{"density", 0.15},      {"membrane", "orthotropic"},
                          {"k_warp", 60},         {"k_weft", 70},
                          {"k_shear", 8},         {"k_poisson", 5},
                          {"bending", "patches"}, {"bend_warp", 1.3e-4},
                          {"bend_weft", 1.5e-4},  {"bend_twist", 1e-4},
                          {"drag", 0.1},          {"damping", 0.3}};
    scene["handles"] = handles;
    scene["wind"] = wind;
    std::ofstream(folder() / (name + ".json")) << scene;
  }

  void WriteSwinging(const std::string& name, const std::vector<int>& handles) const {
    WriteScene(name, handles,
               {{"mean", {0, 1.5, 0}}, {"gust", {0, 1.5, 0}}, {"frequency", 9}, {"wave_vector", {4, 0, 3}}});
  }

  void Record(const std::string& name, const std::string& flags) const {
    std::string truth;
    for (const auto& [parameter, value] : kTruth) truth += " --set " + parameter + "=" + std::to_string(value);
    const ToolResult result = Run("simulate --scene " + name + ".json --output " + name + ".bin" + truth + " " + flags);
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }

  nlohmann::json Fit(const std::string& flags, int exit_code) const {
    const ToolResult result = Run("identify --jacobian sensitivity --report=false --output result " + flags);
    EXPECT_EQ(result.exit_code, exit_code) << result.out << result.err;
    return nlohmann::json::parse(ReadBytes(folder() / "result" / "result.json"));
  }
};

TEST_F(WovenClothTest, SevenConstantsFromTwoRecordings) {
  WriteSwinging("corners", {0, 7});
  WriteSwinging("diagonal", {0, 63});  // pulled along the bias, which shears it
  Record("corners", "--noise 0.0003 --seed 1");
  Record("diagonal", "--noise 0.0003 --seed 2");
  const nlohmann::json result = Fit(std::string("--target corners.bin,diagonal.bin --fit ") + kConstants, 0);
  for (const auto& [name, truth] : kTruth) {
    const nlohmann::json& parameter = result["parameters"][name];
    EXPECT_NEAR(parameter["value"].get<double>(), truth, 0.02 * truth) << name;
    EXPECT_EQ(parameter["identifiable"], true) << name;
  }
}

// A sheet that hangs by its upper edge in still air is stretched along its weft, which is vertical, and stays flat.
TEST_F(WovenClothTest, WhatOneRecordingDoesNotDetermineIsNamed) {
  WriteScene("edge", {0, 1, 2, 3, 4, 5, 6, 7}, {{"mean", {0, 0, 0}}});
  Record("edge", "--noise 0.0003");
  const nlohmann::json result = Fit(std::string("--target edge.bin --fit ") + kConstants, 4);
  const nlohmann::json& weft = result["parameters"]["k_weft"];
  EXPECT_EQ(weft["identifiable"], true);
  EXPECT_NEAR(weft["value"].get<double>(), kTruth.at("k_weft"), 0.05 * kTruth.at("k_weft"));
  for (const char* name : {"bend_warp", "bend_weft", "bend_twist"}) {
    EXPECT_EQ(result["parameters"][name]["identifiable"], false) << name;
    EXPECT_NE(result["verdict"].dump().find(name), std::string::npos) << name;
  }
}

TEST_F(WovenClothTest, ParametersOfAnotherLawAreNamed) {
  WriteSwinging("corners", {0, 7});
  Record("corners", "--noise 0.0003");
  const std::string known = "expected one of density, drag, damping, k_warp, k_weft, k_shear, k_poisson, bend_warp";
  for (const std::string command : {"identify --target corners.bin --output result --fit k_stretch",
                                    "simulate --scene corners.json --output other.bin --set k_bend=1e-4",
                                    "landscape --target corners.bin --output cost --y k_warp=50:100:2 "
                                    "--x k_stretch=1:2:2"}) {
    const ToolResult result = Run(command);
    EXPECT_EQ(result.exit_code, 1) << command;
    EXPECT_NE(result.err.find("the scene has no such term; " + known), std::string::npos) << result.err;
  }
  const ToolResult plain = Run("identify --target '" CLOTHID_SOURCE_DIR "/datasets/wind.motion.bin' --fit k_warp");
  EXPECT_EQ(plain.exit_code, 1);
  EXPECT_NE(plain.err.find("'k_warp': the scene has no such term; expected one of k_stretch, k_bend"),
            std::string::npos)
      << plain.err;
}

TEST_F(WovenClothTest, PoissonsCouplingMayBeNegativeButNotTooLarge) {
  WriteSwinging("corners", {0, 7});
  const ToolResult indefinite = Run("simulate --scene corners.json --output other.bin --set k_poisson=-65");
  EXPECT_EQ(indefinite.exit_code, 1);
  EXPECT_NE(indefinite.err.find("--set: k_poisson^2 must be below k_warp k_weft, and is 4225, not below 4200"),
            std::string::npos)
      << indefinite.err;
  Record("corners", "");
  // Cells in which the membrane would be unstable are failed ones.
  const ToolResult scan = Run("landscape --target corners.bin --output cost --x k_poisson=-70:20:4 --y k_warp=60:70:2");
  EXPECT_EQ(scan.exit_code, 0) << scan.out << scan.err;
  // A fit that goes through zero.
  const nlohmann::json result =
      Fit(std::string("--target corners.bin --fit ") + kConstants + " --start k_poisson=-20", 0);
  EXPECT_NEAR(result["parameters"]["k_poisson"]["value"].get<double>(), 15.0, 0.01);
}

}  // namespace
}  // namespace clothid::woven_cloth_test
