// Folders of .npy clouds become recordings.
#include "datasets/importing/cloud_import.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <limits>
#include <random>
#include <string>

#include "tests/expect_error.h"
#include "tests/npy_bytes.h"
#include "tests/temporary_folder.h"

namespace clothid::cloud_import_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

constexpr char kScene[] = R"({
  "clothid_scene": 1, "time_step": 0.01, "duration": 1.0,
  "mesh": {"grid": {"nodes": [4, 4], "size": [0.3, 0.3]}},
  "obstacles": [{"type": "plane", "point": [0, 0, 0], "normal": [0, 0, 1]}]
})";

class CloudImportTest : public testing::Test {
 protected:
  CloudImportTest() {
    folder_.Write("scene.json", kScene);
    std::filesystem::create_directory(folder_.File("clouds"));
    options_.input = folder_.File("clouds");
    options_.scene_path = folder_.File("scene.json");
    options_.frame_rate = 10.0;
    options_.single_precision = false;
  }

  void WriteCloud(const std::string& name, const Eigen::Matrix3Xd& points) const {
    folder_.Write("clouds/" + name, NpyBytes(points));
  }

  TemporaryFolder folder_;
  CloudImportOptions options_;
};

TEST_F(CloudImportTest, FramesAreInTheOrderOfTheirNumbers) {
  for (const int number : {10, 9, 11, 8}) {
    WriteCloud("frame_" + std::to_string(number) + ".npy", Eigen::Matrix3Xd::Constant(3, 2, number));
  }
  folder_.Write("clouds/notes.txt", "no cloud");
  options_.scale = 0.5;
  options_.sigma = 0.004;
  const MotionTensors motion = ImportClouds(options_);
  ASSERT_EQ(motion.clouds.size(), 4U);
  EXPECT_EQ(motion.clouds[1](0, 0), 4.5);
  EXPECT_EQ(motion.clouds[3](2, 1), 5.5);
  EXPECT_NEAR(motion.times[3], 0.3, 1e-15);
  EXPECT_EQ(motion.cloud_sigma, 0.004);
  EXPECT_EQ(motion.positions.rows(), 0);

  WriteMotion(motion, folder_.File("motion.bin"));
  const RecordedMotion read = ReadMotion(folder_.File("motion.bin"));
  EXPECT_EQ(read.scene.mesh.num_nodes(), 16);
  EXPECT_EQ(read.scene.initial_positions, read.scene.mesh.rest_positions.reshaped());
  EXPECT_EQ(read.scene.obstacles.size(), 1U);

  options_.input = folder_.File("clouds/frame_?.npy");
  EXPECT_EQ(ImportClouds(options_).clouds.size(), 2U);
  options_.frame_rate = 0.0;
  options_.times = Eigen::Vector2d(1.0, 1.7);
  EXPECT_EQ(ImportClouds(options_).times, options_.times);
}

TEST_F(CloudImportTest, AMissingFileLeavesAGapOfTime) {
  for (const int number : {0, 1, 3}) WriteCloud(std::to_string(number) + ".npy", Eigen::Matrix3Xd::Zero(3, 2));
  EXPECT_TRUE(ImportClouds(options_).times.isApprox(Eigen::Vector3d(0.0, 0.1, 0.3), 1e-15));
  options_.frame_rate = 0.0;
  options_.times = Eigen::Vector4d(0.0, 1.0, 2.0, 3.5);
  EXPECT_EQ(ImportClouds(options_).times, Eigen::Vector3d(0.0, 1.0, 3.5));
  options_.times = Eigen::Vector3d(0.0, 1.0, 2.0);
  EXPECT_EQ(ImportClouds(options_).times, options_.times);
  options_.times = Eigen::Vector2d(0.0, 1.0);
  ExpectError([&] { ImportClouds(options_); }, ErrorKind::kBadData, {"each of the 2 times, found 3"});
  WriteCloud("100.npy", Eigen::Matrix3Xd::Zero(3, 2));
  options_.times.resize(0);
  options_.frame_rate = 10.0;
  ExpectError([&] { ImportClouds(options_); }, ErrorKind::kBadData, {"its 4 files leave out 97"});
  WriteCloud("rest.npy", Eigen::Matrix3Xd::Zero(3, 2));
  ExpectError([&] { ImportClouds(options_); }, ErrorKind::kUsage, {"clouds: rest.npy is not numbered like "});
}

TEST_F(CloudImportTest, HandlesHaveTheClockOfTheClouds) {
  for (const int number : {0, 1, 2}) WriteCloud(std::to_string(number) + ".npy", Eigen::Matrix3Xd::Zero(3, 2));
  std::string text = kScene;
  text.insert(text.rfind('}'), R"(, "handles": {"nodes": [0], "path": "path.csv"})");
  folder_.Write("scene.json", text);
  folder_.Write("path.csv", "time,x0,y0,z0\n0,0,0,0\n0.1,0,0,0\n");
  EXPECT_EQ(ImportClouds(options_).handle_positions.cols(), 3);
  folder_.Write("path.csv", "time,x0,y0,z0\n0.3,0,0,0\n0.4,0,0,0\n");
  ExpectError([&] { ImportClouds(options_); }, ErrorKind::kBadData,
              {"scene.json: the path of its handles", "one clock"});
}

TEST_F(CloudImportTest, LeavesOutRowsThatAreNotFinite) {
  Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Random(3, 4);
  points(1, 2) = kNaN;
  points(0, 0) = std::numeric_limits<double>::infinity();
  WriteCloud("0.npy", points);
  const Eigen::Matrix3Xd read = ReadCloud(folder_.File("clouds/0.npy"), 1.0);
  ASSERT_EQ(read.cols(), 2);
  EXPECT_EQ(read.col(0), points.col(1));
  EXPECT_EQ(read.col(1), points.col(3));
}

TEST_F(CloudImportTest, VoxelsKeepTheMeanOfTheirPoints) {
  Eigen::Matrix3Xd points(3, 4);
  points << 0.01, 0.51, 0.03, -0.01, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.04, 0.0;
  Eigen::Matrix3Xd expected(3, 3);
  expected << 0.02, 0.51, -0.01, 0.0, 0.0, 0.0, 0.02, 0.0, 0.0;
  const Eigen::Matrix3Xd means = MeanPerVoxel(points, 0.5);
  ASSERT_EQ(means.cols(), 3);
  EXPECT_LT((means - expected).norm(), 1e-15);
  EXPECT_EQ(MeanPerVoxel(points, 0.0), points);
  ExpectError([&] { MeanPerVoxel(points, 1e-300); }, ErrorKind::kUsage, {"voxel"});
}

TEST_F(CloudImportTest, ChoiceOfPointsDependsOnSeedAndFrame) {
  const Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Random(3, 100);
  const Eigen::Matrix3Xd chosen = ChoosePoints(points, 10, 1, 0);
  EXPECT_EQ(chosen.cols(), 10);
  EXPECT_EQ(chosen, ChoosePoints(points, 10, 1, 0));
  EXPECT_NE(chosen, ChoosePoints(points, 10, 2, 0));
  EXPECT_NE(chosen, ChoosePoints(points, 10, 1, 1));
  EXPECT_EQ(ChoosePoints(points, 200, 1, 0), points);
}

// Moved by 4 cm and 10 degrees, a fifth of the points far away.
TEST_F(CloudImportTest, PoseIsFoundFromNearBy) {
  GridOptions grid;
  grid.nodes = {6, 6};
  Mesh mesh = MakeGrid(grid);
  for (auto node : mesh.rest_positions.colwise()) node.z() = 2.0 * node.x() * node.x() - node.y() * node.y();
  const Eigen::Isometry3d truth =
      Eigen::Translation3d(0.02, -0.02, 0.03) * Eigen::AngleAxisd(0.17, Eigen::Vector3d(0.3, 0.5, 0.9).normalized());
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  Eigen::Matrix3Xd cloud(3, 500);
  for (Eigen::Index i = 0; i < cloud.cols(); ++i) {
    const Eigen::Vector3i face = mesh.faces.col(static_cast<Eigen::Index>(uniform(generator) * mesh.num_faces()));
    const double a = uniform(generator), b = (1.0 - a) * uniform(generator);
    cloud.col(i) = truth * (a * mesh.rest_positions.col(face[0]) + b * mesh.rest_positions.col(face[1]) +
                            (1.0 - a - b) * mesh.rest_positions.col(face[2]));
    if (i % 5 == 0) cloud.col(i) += Eigen::Vector3d(0.3, 0.2, 0.5);
  }
  EXPECT_LT((FitPose(mesh, cloud) - truth * mesh.rest_positions).colwise().norm().maxCoeff(), 1e-4);
  ExpectError([&] { FitPose(mesh, cloud.leftCols(2)); }, ErrorKind::kBadData, {"three points"});
}

TEST_F(CloudImportTest, AStartFromAFileBecomesTheFirstFrame) {
  const Mesh mesh = MakeGrid({{4, 4}, {0.3, 0.3}});
  const Eigen::Matrix3Xd start = mesh.rest_positions.colwise() + Eigen::Vector3d(0.1, 0.2, 0.3);
  folder_.Write("start.npy", NpyBytes(start));
  std::string scene = kScene;
  scene.insert(scene.find("\"mesh\""), "\"initial\": {\"positions\": \"start.npy\"},\n  ");
  folder_.Write("scene.json", scene);
  for (const char* name : {"0.npy", "1.npy"}) WriteCloud(name, start);
  WriteMotion(ImportClouds(options_), folder_.File("motion.bin"));
  options_.fit_pose = true;
  ExpectError([&] { ImportClouds(options_); }, ErrorKind::kUsage, {"fit_pose"});
  std::filesystem::remove(folder_.File("start.npy"));
  EXPECT_EQ(ReadMotion(folder_.File("motion.bin")).scene.initial_positions, start.reshaped());
}

TEST_F(CloudImportTest, RefusesWhatItCannotUse) {
  ExpectError([&] { ImportClouds(options_); }, ErrorKind::kBadData, {"clouds", ".npy"});
  WriteCloud("0.npy", Eigen::Matrix3Xd::Zero(3, 4));
  WriteCloud("1.npy", Eigen::Matrix3Xd::Zero(3, 4));
  const auto refuses = [&](void (*spoil)(CloudImportOptions*), ErrorKind kind, const char* word) {
    CloudImportOptions options = options_;
    spoil(&options);
    ExpectError([&] { ImportClouds(options); }, kind, {word});
  };
  refuses([](CloudImportOptions* o) { o->frame_rate = 0.0; }, ErrorKind::kUsage, "frame rate");
  refuses([](CloudImportOptions* o) { o->frame_rate = -1.0; }, ErrorKind::kUsage, "frame_rate");
  refuses([](CloudImportOptions* o) { o->times = Eigen::Vector2d(0, 1); }, ErrorKind::kUsage, "frame rate");
  refuses([](CloudImportOptions* o) { o->scale = 0.0; }, ErrorKind::kUsage, "scale");
  refuses([](CloudImportOptions* o) { o->voxel = kNaN; }, ErrorKind::kUsage, "voxel");
  refuses([](CloudImportOptions* o) { o->sigma = -1.0; }, ErrorKind::kUsage, "sigma");
  refuses([](CloudImportOptions* o) { o->max_points = -1; }, ErrorKind::kUsage, "max_points");
  refuses([](CloudImportOptions* o) { o->scene_path = ""; }, ErrorKind::kUsage, "scene");
  refuses([](CloudImportOptions* o) { o->input += "/nowhere"; }, ErrorKind::kBadData, "nowhere");
  options_.frame_rate = 0.0;
  options_.times = Eigen::Vector3d(0, 1, 2);
  ExpectError([&] { ImportClouds(options_); }, ErrorKind::kBadData, {"3 times", "found 2"});
}

}  // namespace
}  // namespace clothid::cloud_import_test
