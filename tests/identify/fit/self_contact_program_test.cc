// A cloth that meets itself, from the command line to the files: a recording, its friction, bad requests.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "tests/sim/self_contact_scenes.h"
#include "tests/tools/tool_test.h"

namespace clothid::self_contact_program_test {
namespace {

using Json = nlohmann::ordered_json;

class SelfContactProgramTest : public ToolTest {
 protected:
  // A layer that lies on a held one and slides down on it.
  SelfContactProgramTest() {
    const Scene layers = LayersOnASlope(2, 0.44, 0.3, Integrator::kSdirk2, 0.005);
    std::ostringstream text;
    text.precision(17);
    for (int i = 0; i < layers.mesh.num_nodes(); ++i) {
      text << "v " << layers.mesh.rest_positions.col(i).transpose() << "\n";
    }
    for (int f = 0; f < layers.mesh.num_faces(); ++f) {
      text << "f " << (layers.mesh.faces.col(f).array() + 1).transpose() << "\n";
    }
    WriteBytes(folder() / "layers.obj", text.str());
    const Eigen::Vector3d& g = layers.gravity;
    scene_ = {{"clothid_scene", 2},
              {"time_step", 0.005},
              {"duration", 0.2},
              {"gravity", {g.x(), g.y(), g.z()}},
              {"mesh", {{"obj", "layers.obj"}}},
              {"handles", layers.handles.nodes},
              {"self_contact", {{"mu", 0.35}, {"thickness", 0.003}}},
              {"materials", {{"k_stretch", 100}, {"k_bend", 1e-5}}}};
    WriteBytes(folder() / "scene.json", scene_.dump(1));
  }

  Json FitOf(const std::string& recording) {
    const ToolResult fit =
        Run("identify --target " + recording + " --fit mu.self --threads 1 --output result_" + recording);
    EXPECT_EQ(fit.exit_code, 0) << fit.out << fit.err;
    EXPECT_NE(fit.out.find("the simulated cloth stays out of itself"), std::string::npos) << fit.out;
    return Json::parse(ReadBytes(folder() / ("result_" + recording) / "result.json"))["parameters"]["mu.self"];
  }

  Json scene_;
};

TEST_F(SelfContactProgramTest, FindsTheFrictionOfTheClothWithItself) {
  const ToolResult made = Run("simulate --scene scene.json --set mu.self=0.2 --output exact.bin");
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_NE(made.out.find("0 pairs of triangles that cut each other"), std::string::npos) << made.out;
  const Json exact = FitOf("exact.bin");
  EXPECT_NEAR(exact["value"].get<double>(), 0.2, 0.002) << exact.dump(1);
  // 1 % of the motion.
  ASSERT_EQ(Run("simulate --scene scene.json --set mu.self=0.2 --noise 0.0005 --seed 2 --output noisy.bin").exit_code,
            0);
  const Json noisy = FitOf("noisy.bin");
  EXPECT_LT(noisy["lower95"].get<double>(), 0.2) << noisy.dump(1);
  EXPECT_GT(noisy["upper95"].get<double>(), 0.2) << noisy.dump(1);
}

// "mu" is that of obstacles, here of one that nothing touches.
TEST_F(SelfContactProgramTest, FitsItBesideTheFrictionOfObstacles) {
  scene_["obstacles"] = {{{"name", "floor"}, {"type", "plane"}, {"point", {0, 0, -1}}, {"normal", {0, 0, 1}}}};
  WriteBytes(folder() / "scene.json", scene_.dump(1));
  ASSERT_EQ(Run("simulate --scene scene.json --set mu.self=0.2 --output exact.bin").exit_code, 0);
  const ToolResult fit = Run("identify --target exact.bin --fit mu.self,mu --threads 1 --output result");
  const Json parameters = Json::parse(ReadBytes(folder() / "result/result.json"))["parameters"];
  EXPECT_NEAR(parameters["mu.self"]["value"].get<double>(), 0.2, 0.002) << fit.out << fit.err;
  EXPECT_TRUE(parameters.contains("mu"));
}

// The held layer is not where the recording says.
TEST_F(SelfContactProgramTest, FindsHandlesThatItTouches) {
  ASSERT_EQ(Run("simulate --scene scene.json --set mu.self=0.2 --output exact.bin").exit_code, 0);
  const ToolResult fit = Run("identify --target exact.bin --fit mu.self,handle_shift.z --threads 1 --output result");
  EXPECT_EQ(fit.exit_code, 0) << fit.out << fit.err;
  const Json parameters = Json::parse(ReadBytes(folder() / "result/result.json"))["parameters"];
  EXPECT_NEAR(parameters["mu.self"]["value"].get<double>(), 0.2, 0.002);
  EXPECT_NEAR(parameters["handle_shift.z"]["value"].get<double>(), 0.0, 1e-5);
}

}  // namespace
}  // namespace clothid::self_contact_program_test
