// Point clouds through the programs: made, converted, looked at, fitted; and a real capture, where it is there.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "datasets/motion/motion_file.h"
#include "tests/npy_bytes.h"
#include "tests/tools/tool_test.h"

namespace clothid::motion_clouds_test {
namespace {

using Json = nlohmann::ordered_json;

class MotionCloudsTest : public ToolTest {
 protected:
  void WriteClouds(const std::vector<Eigen::Matrix3Xd>& clouds) const {
    std::filesystem::create_directory(folder() / "clouds");
    for (std::size_t i = 0; i < clouds.size(); ++i) {
      WriteBytes(folder() / "clouds" / (std::to_string(i) + ".npy"), NpyBytes(clouds[i]));
    }
  }
};

TEST_F(MotionCloudsTest, ASimulatedCloudIsLookedAtAndFitted) {
  Json scene = BareScene();
  scene["duration"] = 0.2;
  ExpectSuccess("simulate --scene " + WriteScene(scene) + " --set k_stretch=20 --cloud 40 --noise 1e-4 --output c.bin");
  const ToolResult info = Run("motion info c.bin");
  EXPECT_EQ(info.exit_code, 0) << info.err;
  for (const char* text : {"cloud_positions F64 [840, 3]", "cloud_offsets I32 [22]", "cloud_sigma F64 [1]",
                           "clouds 21, of 40 to 40 points, 840 in all, sigma 0.0001 m", "points 0"}) {
    EXPECT_NE(info.out.find(text), std::string::npos) << text << "\n" << info.out;
  }
  const ToolResult fit = Run("identify --target c.bin --fit k_stretch --loss huber:3 --output result");
  EXPECT_EQ(fit.exit_code, 0) << fit.out << fit.err;
  EXPECT_NE(fit.out.find("from points to the surface"), std::string::npos) << fit.out;
  const Json result = Json::parse(ReadBytes(folder() / "result" / "result.json"));
  EXPECT_NEAR(result["parameters"]["k_stretch"]["value"].get<double>(), 20.0, 0.6);
  EXPECT_TRUE(result["fit_percent"].is_null());
  EXPECT_EQ(result["cloud"]["num_points"], 840);
  EXPECT_DOUBLE_EQ(result["cloud"]["rmse_m"].get<double>(), result["rmse_m"].get<double>());
  EXPECT_LT(result["cloud"]["far_share"].get<double>(), 0.01);
  ExpectSuccess("motion check result/predicted.bin");
}

TEST_F(MotionCloudsTest, AFolderOfCloudsBecomesARecording) {
  std::vector<Eigen::Matrix3Xd> clouds;
  std::srand(1);
  for (int i = 0; i < 3; ++i) clouds.push_back(0.1 * Eigen::Matrix3Xd::Random(3, 50).array() + 0.1);
  WriteClouds(clouds);
  WriteScene(BareScene());
  ExpectSuccess("motion convert_clouds clouds c.bin --scene scene.json --frame_rate 25 --max_points 20 --sigma 0.003");
  const RecordedMotion motion = ReadMotion((folder() / "c.bin").string());
  EXPECT_EQ(motion.num_frames(), 3);
  EXPECT_NEAR(motion.times[2], 0.08, 1e-15);
  EXPECT_EQ(motion.clouds[1].cols(), 20);
  EXPECT_EQ(motion.cloud_sigma, 0.003);
  ExpectSuccess(
      "motion convert_clouds 'clouds/?.npy' d.bin --scene scene.json --frame_rate 25 --max_points 20 --sigma 0.003");
  EXPECT_EQ(ReadBytes(folder() / "c.bin"), ReadBytes(folder() / "d.bin"));
}

// Points of a depth camera in mm that looks down, on a clock that counts from 1970: half of them a table, some not
// seen.
TEST_F(MotionCloudsTest, CloudsAreTakenAsTheyCome) {
  std::filesystem::create_directory(folder() / "camera");
  for (const char* stamp : {"1700000000000000000", "1700000000040000000", "1700000000080000000"}) {
    WriteBytes(folder() / "camera" / (std::string(stamp) + ".ply"),
               "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
               "property uchar red\nend_header\n0 0 0 0\n100 50 1000 9\n120 50 1000 9\n100 50 1400 9\nnan nan nan 9\n");
  }
  WriteBytes(folder() / "pose.json", R"({"rotation": [1, 0, 0, 0], "translation": [0, 0, 1.5]})");
  WriteScene(BareScene());
  const std::string convert = "motion convert_clouds camera c.bin --scene scene.json --times names --start_at 0 ";
  ExpectSuccess(convert + "--scale 0.001 --transform pose.json --missing 0,0,0 --box -1,-1,0.3,1,1,inf --float64");
  const RecordedMotion motion = ReadMotion((folder() / "c.bin").string());
  EXPECT_EQ(motion.times, Eigen::Vector3d(0.0, 0.04, 0.08));
  ASSERT_EQ(motion.clouds[1].cols(), 2);
  EXPECT_LT((motion.clouds[1].col(0) - Eigen::Vector3d(0.1, -0.05, 0.5)).norm(), 1e-7);
  ExpectRefused(convert + "--box 0,0,0,1,1", 1, "--box: expected x0,y0,z0,x1,y1,z1 with x0 < x1");
  ExpectRefused(convert + "--box 0,0,0,1,0,1", 1, "--box: expected x0,y0,z0");
  ExpectRefused(convert + "--box 0,0,0,1,nan,1", 1, "--box: expected x0,y0,z0");
  ExpectRefused(convert + "--box 7,7,7,8,8,8", 2, "camera: none of its points is in the box");
  ExpectRefused(convert + "--missing 0,0", 1, "--missing: expected a position as in 0,0,0");
  ExpectRefused(convert + "--invert_transform", 1, "--invert_transform: expected with --transform");
  ExpectRefused(convert + "--transform absent.json", 1, "absent.json");
}

TEST_F(MotionCloudsTest, RefusesWhatItCannotConvert) {
  WriteClouds({Eigen::Matrix3Xd::Zero(3, 4), Eigen::Matrix3Xd::Zero(3, 4)});
  WriteScene(BareScene());
  WriteBytes(folder() / "bad.npy", "no array");
  WriteBytes(folder() / "bad.bin", "no array");
  ExpectRefused("motion convert_clouds clouds", 1, "convert_clouds");
  ExpectRefused("motion convert_clouds clouds c.bin --frame_rate 25", 1, "scene");
  ExpectRefused("motion convert_clouds clouds c.bin --scene scene.json --frame_rate 25 --seed 2", 1,
                "--seed: expected with --max_points");
  ExpectRefused("motion convert_clouds clouds c.bin --scene scene.json", 1, "frame rate");
  ExpectRefused("motion convert_clouds clouds c.npy --scene scene.json --frame_rate 25", 1,
                "c.npy: expected a name that");
  ExpectRefused("motion convert_clouds '*.bin' bad.bin --scene scene.json --frame_rate 25", 1,
                "would replace an input");
  ExpectRefused("motion convert_clouds clouds c.bin --scene scene.json --frame_rate 1e300", 2,
                "clouds: scene: key 'duration'");
  ExpectRefused("motion convert_clouds clouds/0.npy c.bin --scene scene.json --frame_rate 1", 2, "at least two frames");
  ExpectRefused("motion convert_clouds nowhere c.bin --scene scene.json --frame_rate 25", 2, "nowhere");
  ExpectRefused("motion convert_clouds bad.npy c.bin --scene scene.json --frame_rate 25", 2, "bad.npy");
  ExpectRefused("motion convert_clouds clouds c.bin --scene absent.json --frame_rate 25", 1, "absent.json");
  ExpectRefused("motion convert_clouds clouds nowhere/c.bin --scene scene.json --frame_rate 25", 1, "nowhere");
  ExpectRefused("motion convert_clouds clouds c.bin --scene scene.json --times bad.npy", 2, "bad.npy");
}

}  // namespace
}  // namespace clothid::motion_clouds_test
