// A real capture of point clouds, where it is there: 25 frames of a cloth that a robot picks up from a table by one
// point, lifts to half a metre and lays down again, with patches of the robot in the first frames and without times.
//
// The scene is a guess throughout: a flat square in place of a heap, 5 frames a second, and a gripper that holds the
// middle of the cloth at the highest points of the clouds. What is expected is an end that says so, not an estimate.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>
#include <sstream>
#include <string>
#include <vector>

#include "datasets/importing/cloud_import.h"
#include "tests/tools/tool_test.h"

namespace clothid::fold_test {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kNodesPerSide = 11;
constexpr double kSide = 0.9;           // m
constexpr double kTableHeight = 0.243;  // m: nothing was seen below
constexpr double kFrameRate = 5.0;      // Hz

class FoldTest : public ToolTest {
 protected:
  void SetUp() override {
    const char* variable = std::getenv("CLOTHID_RECORDINGS");
    clouds_ = (variable != nullptr ? variable : CLOTHID_SOURCE_DIR "/../shared/recordings") + std::string("/fold");
    if (!std::filesystem::exists(clouds_)) {
      GTEST_SKIP() << clouds_ << " is not there; set CLOTHID_RECORDINGS to the folder that it is in";
    }
  }

  // The mean of the highest hundredth of a cloud.
  static Eigen::Vector3d Top(const Eigen::Matrix3Xd& cloud) {
    std::vector<Eigen::Index> order(static_cast<std::size_t>(cloud.cols()));
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) { return cloud(2, a) > cloud(2, b); });
    order.resize(order.size() / 100);
    return cloud(Eigen::all, order).rowwise().mean();
  }

  void WriteFiles() const {
    std::ostringstream path;
    path << "time,x0,y0,z0\n";
    const std::vector<std::string> files = ListCloudFiles(clouds_);
    Eigen::Vector3d first_top;
    for (std::size_t i = 0; i < files.size(); ++i) {
      const Eigen::Vector3d top = Top(ReadCloud(files[i], 1.0));
      if (i == 0) first_top = top;
      path << static_cast<double>(i) / kFrameRate << "," << top.x() << "," << top.y() << "," << top.z() << "\n";
    }
    WriteBytes(folder() / "gripper.csv", path.str());
    Json scene = {{"clothid_scene", 1}, {"time_step", 0.02}, {"duration", 4.8}};
    scene["mesh"]["grid"] = {{"nodes", {kNodesPerSide, kNodesPerSide}},
                             {"size", {kSide, kSide}},
                             {"origin", {first_top.x() - kSide / 2, first_top.y() - kSide / 2, kTableHeight + 0.002}}};
    scene["handles"] = {{"nodes", {(kNodesPerSide * kNodesPerSide) / 2}}, {"path", "gripper.csv"}};
    scene["obstacles"] = {
        {{"name", "table"}, {"type", "plane"}, {"point", {0, 0, kTableHeight}}, {"normal", {0, 0, 1}}}};
    scene["materials"] = {{"density", 0.2}, {"k_stretch", 50}, {"k_bend", 1e-3}, {"drag", 0.1}};
    scene["parameters"]["k_stretch"] = {{"lower", 5}, {"upper", 1000}};
    scene["solver"] = {{"step_tolerance", 1e-6}};
    WriteScene(scene);
  }

  std::string clouds_;
};

TEST_F(FoldTest, ImportsAndFitsToAnEnd) {
  WriteFiles();
  const ToolResult import =
      Run("motion convert_clouds '" + clouds_ +
          "' fold.bin --scene scene.json --frame_rate 5 --voxel 0.01 --max_points 300 --sigma 0.005");
  ASSERT_EQ(import.exit_code, 0) << import.err;
  EXPECT_NE(import.out.find("clouds 25, of 300 to 300 points, 7500 in all"), std::string::npos) << import.out;
  const ToolResult fit =
      Run("identify --target fold.bin --fit mu,k_stretch --loss huber:2 --max_iterations 4 --output result");
  const std::vector<int> honest = {0, 3, 4, 6};
  EXPECT_NE(std::find(honest.begin(), honest.end(), fit.exit_code), honest.end()) << fit.exit_code << fit.err;
  ASSERT_NE(fit.out.find("cloud "), std::string::npos) << fit.out << fit.err;
  const Json result = Json::parse(ReadBytes(folder() / "result" / "result.json"));
  RecordProperty("rmse_m", result["rmse_m"].dump());
  // Far better than nothing: the clouds are spread over a metre.
  EXPECT_LT(result["rmse_m"].get<double>(), 0.2);
  EXPECT_FALSE(result["verdict"].empty());
  // Nobody predicts with a fit that must not be used: what it misses of its recordings is not looked into.
  EXPECT_LE(result["missing_force"].size(), 1u) << result["missing_force"];
}

}  // namespace
}  // namespace clothid::fold_test
