// A strip in a jaw from the recording to k_bend: what turns the jaw, a finer mesh as the truth, points of a camera.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <vector>

#include "datasets/motion/motion_file.h"
#include "sim/scene/scene_json.h"
#include "tests/tools/tool_test.h"

namespace clothid::clamp_fit_test {
namespace {

constexpr int kRows = 3;

class ClampFitTest : public ToolTest {
 protected:
  // A strip of 0.1 m x 0.025 m that juts out from a jaw and is let go straight; nodes row by row from the jaw.
  void WriteScene(const std::string& name, int cells, const nlohmann::json& jaw) const {
    nlohmann::json scene = {{"clothid_scene", 2}, {"time_step", 0.01}, {"duration", 0.5}};
    scene["mesh"]["grid"] = {{"nodes", {kRows, cells + 1}}, {"size", {0.025, 0.1}}, {"axes", {{1, 0, 0}, {0, 1, 0}}}};
    scene["materials"] = {{"density", 0.2}, {"k_stretch", 1000}, {"k_bend", 2e-4}, {"drag", 0.2}};
    scene["handles"] = jaw;
    scene["handles"]["nodes"] = {0, 1, 2};
    std::ofstream(folder() / name) << scene;
  }

  double FittedBending(const std::string& target) const {
    const ToolResult result = Run("identify --target " + target + " --fit k_bend --report=false --output result");
    EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
    return nlohmann::json::parse(ReadBytes(folder() / "result" / "result.json"))["parameters"]["k_bend"]["value"];
  }
};

TEST_F(ClampFitTest, ARecordingKnowsHowItsJawTurns) {
  std::ofstream poses(folder() / "jaw.csv");
  poses << "time,x,y,z,qx,qy,qz,qw\n";
  for (int k = 0; k <= 25; ++k) {
    const double half = 0.15 * std::sin(0.6 * k);  // about the row itself, which the row does not show
    poses << 0.02 * k << ",0,0,0," << std::sin(half) << ",0,0," << std::cos(half) << "\n";
  }
  poses.close();
  WriteScene("scene.json", 10, {{"clamp", true}, {"poses", "jaw.csv"}});
  const ToolResult recorded = Run("simulate --scene scene.json --output r.bin --set k_bend=4e-4 --forces");
  ASSERT_EQ(recorded.exit_code, 0) << recorded.err;
  const Scene scene = ReadScene((folder() / "scene.json").string());
  ASSERT_EQ(Run("motion convert r.bin again.bin").exit_code, 0);
  for (const char* name : {"r.bin", "again.bin"}) {
    const RecordedMotion motion = ReadMotion((folder() / name).string());
    ASSERT_EQ(motion.scene.handles.clamped.size(), 2u) << name;
    EXPECT_EQ(motion.scene.handles.clamped[0].nodes, scene.handles.clamped[0].nodes);
    for (const double time : {0.0, 0.07, 0.333}) {
      EXPECT_LE((motion.scene.handles.slopes.At(time) - scene.handles.slopes.At(time)).norm(), 1e-9) << name;
    }
    EXPECT_EQ(motion.forces.moments.rows(), 3) << name;
  }
  ASSERT_EQ(Run("motion convert r.bin cut.bin --frames 10:30").exit_code, 0);
  const RecordedMotion whole = ReadMotion((folder() / "r.bin").string());
  const RecordedMotion cut = ReadMotion((folder() / "cut.bin").string());
  EXPECT_EQ(cut.forces.moments, whole.forces.moments.middleCols(10, 20));
  EXPECT_LE((cut.scene.handles.slopes.At(0.25) - whole.scene.handles.slopes.At(0.25)).norm(), 1e-9);
  EXPECT_NE(Run("motion info r.bin").out.find("handles 3 (moving), clamped at 2 edges"), std::string::npos);
  const ToolResult checked = Run("motion check r.bin");  // it juts out, and swings as stiff as it is
  EXPECT_EQ(checked.out.find("warning"), std::string::npos) << checked.out;
  EXPECT_NEAR(FittedBending("r.bin"), 4e-4, 4e-8);
}

// Of second order in the mesh; with 12 elements 1.7 % too high of one of 192.
TEST_F(ClampFitTest, OneRowGivesTheRigidityOfAFinerMesh) {
  WriteScene("fine.json", 48, {{"clamp", true}});
  WriteScene("coarse.json", 12, {{"clamp", true}});
  ASSERT_EQ(Run("simulate --scene fine.json --output fine.bin --set k_bend=4e-4").exit_code, 0);
  std::ofstream map(folder() / "map.csv");
  map << "id,node\n";
  for (int node = 0; node < 13 * kRows; ++node) {
    map << 4 * kRows * (node / kRows) + node % kRows << "," << node << "\n";
  }
  map.close();
  const ToolResult converted =
      Run("motion convert fine.bin coarse.bin --scene coarse.json --grid 3x13:0.025x0.1 --map map.csv --handle_nodes "
          "0,1,2:clamp");
  ASSERT_EQ(converted.exit_code, 0) << converted.err;
  EXPECT_NEAR(FittedBending("coarse.bin"), 4e-4, 0.02 * 4e-4);
}

}  // namespace
}  // namespace clothid::clamp_fit_test
