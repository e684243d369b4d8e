// Obstacles that deform from the command line to the files: a sequence, its recording, fit, replay, export.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "sim/base/npy_file.h"
#include "tests/sim/scene/triangle_meshes.h"
#include "tests/tools/small_drape.h"
#include "tests/tools/tool_test.h"

namespace clothid::deforming_obstacle_program_test {
namespace {

using Json = nlohmann::ordered_json;

// A ball under the cloth that wanders, and is squeezed along x.
Eigen::Vector3d PlaceAt(const Eigen::Vector3d& p, double t) {
  const double squeeze = 0.3 * (1.0 - std::cos(6.0 * t));
  return {p.x() * (1.0 - squeeze) + 0.03 + 0.1 * std::sin(5.0 * t), p.y() + 0.25 - 0.1 * t,
          p.z() * (1.0 + 0.5 * squeeze) - 0.35 + 0.2 * t * t};
}

class DeformingObstacleProgramTest : public ToolTest {
 protected:
  DeformingObstacleProgramTest() : ball_(IcosphereMesh(2, 0.2)) {
    scene_ = Json::parse(SmallDrape(6));
    scene_["clothid_scene"] = 2;
    Json body = {{"name", "body"}, {"type", "mesh"}, {"mu", 0.4}, {"contact_distance", 0.01}};
    for (const auto& vertex : ball_.vertices.colwise()) body["vertices"].push_back({vertex[0], vertex[1], vertex[2]});
    for (const auto& face : ball_.faces.colwise()) body["faces"].push_back({face[0], face[1], face[2]});
    body["sequence"] = {{"file", "body.npy"}, {"frame_rate", 50}, {"start_time", -0.1}};
    scene_["obstacles"] = {body};
    NpyArray array;
    array.shape = {31, ball_.vertices.cols(), 3};
    for (int frame = 0; frame < 31; ++frame) {
      for (const auto& vertex : ball_.vertices.colwise()) {
        for (const double x : PlaceAt(vertex, 0.02 * frame - 0.1)) array.values.push_back(x);
      }
    }
    WriteBytes(folder() / "body.npy", NpyBytes(array));
    WriteScene(scene_);
  }

  TriangleMesh ball_;
  Json scene_;
};

TEST_F(DeformingObstacleProgramTest, GoesFromTheSequenceToTheResult) {
  ExpectSuccess("simulate --scene scene.json --set body.time_offset=0.012 --noise 0.0005 --output cloth.bin");
  ExpectRefused("simulate --scene scene.json --output body.npy", 1, "body.npy");
  std::filesystem::remove(folder() / "body.npy");  // a recording stands on its own
  const ToolResult check = Run("motion check cloth.bin");
  EXPECT_NE(check.out.find("sequence of body"), std::string::npos) << check.out;
  EXPECT_NE(check.out.find("31 frames from -0.1 s to 0.5 s"), std::string::npos) << check.out;
  const ToolResult fit =
      Run("identify --target cloth.bin --start mu=0.3 --fit mu,k_stretch,body.time_offset --output result --export "
          "mujoco");
  EXPECT_EQ(fit.exit_code, 0) << fit.err << fit.out;
  const Json parameters = Json::parse(ReadBytes(folder() / "result" / "result.json"))["parameters"];
  const auto expect_held = [&](const char* name, double truth) {
    EXPECT_LE(double(parameters[name]["lower95"]), truth) << name << fit.out;
    EXPECT_GE(double(parameters[name]["upper95"]), truth) << name << fit.out;
  };
  expect_held("mu", 0.4);
  expect_held("body.time_offset", 0.012);
  EXPECT_NE(ReadBytes(folder() / "result" / "export_mujoco.xml").find("a mesh that deforms is left out"),
            std::string::npos);
  EXPECT_NE(ReadBytes(folder() / "result" / "report.html").find("\"surfaces\":{\"body\":{"), std::string::npos);
  EXPECT_EQ(Run("motion check result/predicted.bin").exit_code, 0);
}

}  // namespace
}  // namespace clothid::deforming_obstacle_program_test
