// Folders of .npy and .ply clouds become recordings.
#include "datasets/importing/cloud_import.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <limits>
#include <random>
#include <string>

#include "datasets/importing/clock_times.h"
#include "sim/base/npy_file.h"
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
  std::string WriteArray(const std::string& name, const NpyArray& array) const {
    return folder_.Write(name, NpyBytes(array));
  }
  // Ascii, with what scanners add: normals, colours, faces.
  std::string WritePly(const std::string& name, const std::vector<std::string>& points) const {
    std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(points.size()) +
                       "\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\n"
                       "property uchar red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    for (const std::string& point : points) text += point + " nan 255\n";
    return folder_.Write(name, text + "4 0 1 0 1\n");
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
  ExpectError([&] { ImportClouds(options_); }, ErrorKind::kBadData, {"clouds: expected 3 times", "found 2"});
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

TEST_F(CloudImportTest, ReadsPlyFiles) {
  for (int i = 0; i < 3; ++i) {
    WritePly("clouds/f" + std::to_string(i) + ".PLY", {"1 2 " + std::to_string(i), "nan nan nan", "4 inf 6", "7 8 9"});
  }
  folder_.Write("clouds/times.npy", "one array is none of the clouds");
  options_.scale = 0.5;
  const MotionTensors motion = ImportClouds(options_);
  ASSERT_EQ(motion.clouds.size(), 3U);
  ASSERT_EQ(motion.clouds[2].cols(), 2);
  EXPECT_EQ(motion.clouds[2].col(0), Eigen::Vector3d(0.5, 1.0, 1.0));
  EXPECT_EQ(motion.clouds[2].col(1), Eigen::Vector3d(3.5, 4.0, 4.5));
  for (const char* pattern : {"clouds/f?.PLY", "clouds/f###.PLY"}) {
    options_.input = folder_.File(pattern);
    EXPECT_EQ(ImportClouds(options_).clouds[2], motion.clouds[2]) << pattern;
  }
  options_.input = folder_.File("clouds");
  folder_.Write("clouds/f1.PLY", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n");
  ExpectError([&] { ImportClouds(options_); }, ErrorKind::kBadData, {"f1.PLY: ", "lacks the property 'y'"});
}

// Those of an image, with a colour; and all frames in one array.
TEST_F(CloudImportTest, ReadsOrganisedCloudsAndFurtherColumns) {
  std::vector<double> values;
  for (int pixel = 0; pixel < 12; ++pixel) {
    for (const double value : {1.0 * pixel, 2.0, pixel == 5 ? kNaN : 3.0, 99.0, kNaN}) values.push_back(value);
  }
  Eigen::Matrix3Xd expected(3, 11);
  for (int i = 0; i < 11; ++i) expected.col(i) = Eigen::Vector3d(i < 5 ? i : i + 1, 2.0, 3.0);
  for (const std::vector<long long>& shape : std::vector<std::vector<long long>>{{12, 5}, {3, 4, 5}, {1, 12, 5}}) {
    EXPECT_EQ(ReadCloud(WriteArray("0.npy", {shape, values}), 1.0), expected);
  }
  for (const std::vector<long long>& shape : std::vector<std::vector<long long>>{{2, 6, 5}, {2, 3, 2, 5}}) {
    options_.input = WriteArray("all.npy", {shape, values});
    const MotionTensors motion = ImportClouds(options_);
    ASSERT_EQ(motion.clouds.size(), 2U);
    EXPECT_EQ(motion.clouds[0], expected.leftCols(5));
    EXPECT_EQ(motion.clouds[1], expected.rightCols(6));
    EXPECT_NEAR(motion.times[1], 0.1, 1e-15);
  }
  const auto refuses = [&](const std::vector<long long>& shape, const char* found) {
    std::size_t size = 1;
    for (const long long length : shape) size *= static_cast<std::size_t>(length);
    const std::string path = WriteArray("bad.npy", {shape, std::vector<double>(size)});
    ExpectError([&] { ReadCloud(path, 1.0); }, ErrorKind::kBadData,
                {"bad.npy: expected an array of shape (M, 3)", found});
  };
  refuses({3, 100}, "found (3, 100)");  // columns of points
  refuses({3, 4, 60}, "found (3, 4, 60)");
  refuses({12, 2}, "found (12, 2)");
  refuses({12}, "found (12)");
  refuses({2, 3, 2, 3}, "found (2, 3, 2, 3)");
}

TEST_F(CloudImportTest, SentinelsAreNoPoints) {
  WritePly("clouds/0.ply", {"0 0 0", "0 0 1", "-9999.9 -9999.9 -9999.9", "1 2 3"});
  WritePly("clouds/1.ply", {"0 0 0", "0 0 0"});
  options_.scale = 0.001;
  options_.transform.translation() = Eigen::Vector3d(1.0, 0.0, 0.0);
  EXPECT_EQ(ImportClouds(options_).clouds[0].cols(), 4);
  options_.missing = MissingValues::Parse("0,0,0:-9999.9", "--missing");
  const MotionTensors motion = ImportClouds(options_);
  ASSERT_EQ(motion.clouds[0].cols(), 2);
  EXPECT_LT((motion.clouds[0].col(0) - Eigen::Vector3d(1.0, 0.0, 0.001)).norm(), 1e-15);
  EXPECT_EQ(motion.clouds[1].cols(), 0);
}

// In the axes of the scene, before points are thinned out.
TEST_F(CloudImportTest, ABoxCutsWhatIsMovedToTheScene) {
  Eigen::Matrix3Xd points(3, 5);
  points << 100, 200, 300, 400, 500, 0, 0, 0, 0, 0, -100, -200, -300, -400, -500;
  for (const char* name : {"0.npy", "1.npy"}) WriteCloud(name, points);
  options_.scale = 0.001;
  options_.transform = Eigen::Translation3d(0.0, 0.0, 1.0) * Eigen::AngleAxisd(M_PI / 2.0, Eigen::Vector3d::UnitZ());
  constexpr double kInf = std::numeric_limits<double>::infinity();
  options_.box = Eigen::AlignedBox3d(Eigen::Vector3d(-kInf, 0.15, 0.65), Eigen::Vector3d(kInf, kInf, kInf));
  const MotionTensors motion = ImportClouds(options_);
  ASSERT_EQ(motion.clouds[0].cols(), 2);
  EXPECT_LT((motion.clouds[0].col(0) - Eigen::Vector3d(0.0, 0.2, 0.8)).norm(), 1e-15);
  EXPECT_LT((motion.clouds[0].col(1) - Eigen::Vector3d(0.0, 0.3, 0.7)).norm(), 1e-15);
  options_.max_points = 2;
  EXPECT_EQ(ImportClouds(options_).clouds[0], motion.clouds[0]);
  options_.box = Eigen::AlignedBox3d(Eigen::Vector3d(0.1, 0.0, 0.0), Eigen::Vector3d(1.0, 1.0, 1.0));
  ExpectError([&] { ImportClouds(options_); }, ErrorKind::kBadData,
              {"clouds: none of its points is in the box (0.1, 0, 0) to (1, 1, 1)", "0.5, 0.9) m"});
  options_.box = Eigen::AlignedBox3d();
  ExpectError([&] { ImportClouds(options_); }, ErrorKind::kUsage, {"box"});
}

// A double of 1.7e9 s resolves 0.24 us, one of 1.7e18 ns 256 ns.
TEST_F(CloudImportTest, TimesSince1970KeepTheirDigits) {
  const long long start = 1700000000123456789;
  for (const int i : {0, 1, 2}) WriteCloud(std::to_string(i) + ".npy", Eigen::Matrix3Xd::Zero(3, 2));
  options_.frame_rate = 0.0;
  options_.start_at = 0.5;
  double shift = 0.0;
  const auto expect = [&](const FrameTimes& times, double time_scale) {
    options_.times = times.times;
    options_.times_since_first = times.since_first;
    options_.time_scale = time_scale;
    const MotionTensors motion = ImportClouds(options_, &shift);
    EXPECT_LT((motion.times - Eigen::Vector3d(0.5, 0.533333333, 0.566666667)).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_NEAR(shift, 0.5 - 1700000000.123456789, 1e-6);
  };
  const auto file = folder_.Write("times.npy", NpyBytes(NpyIntegers{{3}, {start, start + 33333333, start + 66666667}}));
  expect(ReadFrameTimes(file), 1e-9);
  expect(ReadFrameTimes(folder_.Write("ns.txt", "1700000000123456789\n1700000000156790122\n\n1700000000190123456\n")),
         1e-9);
  expect(ReadFrameTimes(folder_.Write("s.txt", "1700000000.123456789\n1700000000.156790122\n1700000000.190123456\n")),
         1.0);
  for (const char* text : {"time\n\"1700000000.123456789\"\n1700000000.156790122\n1700000000.190123456\n",
                           "n,t\n1,1700000000.123456789\n2,1700000000.156790122\n3,1700000000.190123456\n",
                           "time;n\n1700000000,123456789;1\n1700000000,156790122;2\n1700000000,190123456;3\n",
                           "time\nns\n1700000000123456789\n1700000000156790122\n1700000000190123456\n"}) {
    expect(ReadFrameTimes(folder_.Write("t.csv", text)), 1.0);
  }
  expect(TimesOfNames({"c2/1700000000123456789.npy", "c2/1700000000156790122.npy", "c2/1700000000190123456.npy"}), 1.0);
  expect(TimesOfNames({"a_1700000000.123456789_c.ply", "a_1700000000.156790122_c.ply", "a_1700000000.190123456_c.ply"}),
         1.0);
  expect(TimesOfNames({"1700000000_123456789.ply", "1700000000_156790122.ply", "1700000000_190123456.ply"}), 1.0);
}

TEST_F(CloudImportTest, NamesTellTimes) {
  EXPECT_EQ(TimesOfNames({"take3/f1.npy", "take3/f3.npy"}).times, Eigen::Vector2d(1.0, 3.0));
  EXPECT_EQ(TimesOfNames({"f0.25.npy", "f1.5.npy"}).times, Eigen::Vector2d(0.25, 1.5));
  EXPECT_EQ(TimesOfNames({"1700000000000.npy", "1700000000500.npy"}).since_first, Eigen::Vector2d(0.0, 0.5));
  EXPECT_EQ(TimesOfNames({"1700000000000000.npy", "1700000000500000.npy"}).times, Eigen::Vector2d(1.7e9, 1700000000.5));
  ExpectError([] { TimesOfNames({"a/1.npy", "b/rest.npy"}); }, ErrorKind::kBadData, {"b/rest.npy: expected a time in"});
  ExpectError([] { TimesOfNames({"1700000000000.npy", "7.npy"}); }, ErrorKind::kBadData, {"7.npy: ", "as many digits"});
  ExpectError(
      [&] {
        ReadFrameTimes(folder_.Write("t.npy", NpyBytes(NpyIntegers{{1, 2}, {1, 2}})));
      },
      ErrorKind::kBadData, {"t.npy: expected an array of shape (T)"});
  ExpectError([&] { ReadFrameTimes(folder_.Write("t.txt", "1\ntwo\n")); }, ErrorKind::kBadData, {"t.txt:2"});
}

// Half of the frames would be left out without a word.
TEST_F(CloudImportTest, RefusesFramesOfTwoKinds) {
  for (const char* name : {"0.npy", "1.npy"}) WriteCloud(name, Eigen::Matrix3Xd::Zero(3, 2));
  for (const char* name : {"2.ply", "3.ply"}) folder_.Write(std::string("clouds/") + name, "ply\n");
  ExpectError([&] { ImportClouds(options_); }, ErrorKind::kBadData, {"clouds: holds 2 .npy and 2 .ply files", "*.ply"});
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
  ExpectError([&] { ImportClouds(options_); }, ErrorKind::kBadData, {"2 times", "found 3"});
}

}  // namespace
}  // namespace clothid::cloud_import_test
