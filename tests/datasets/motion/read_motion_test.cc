// What ReadMotion makes of a file: start, handles, sigma and scene of a recording.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>
#include <string>

#include "datasets/motion/motion_file.h"
#include "tests/datasets/motion/motion_file_fixture.h"

namespace clothid::read_motion_test {
namespace {

using namespace motion_file_fixture;
using ReadMotionTest = MotionFile;

TEST_F(ReadMotionTest, BecomesARecording) {
  const RecordedMotion motion = Read(SmallMotion());
  EXPECT_EQ(motion.name, Path());
  EXPECT_EQ(motion.num_frames(), 4);
  ASSERT_EQ(motion.num_points(), 9);
  EXPECT_EQ(motion.points[7].num_nodes, 1);
  EXPECT_EQ(motion.points[7].nodes[0], 7);
  EXPECT_EQ(motion.sha256, Sha256Hex({ReadAll(Path())}));
  EXPECT_EQ(motion.scene.start_time, 1.0);
  EXPECT_DOUBLE_EQ(motion.scene.duration, 0.4);
  EXPECT_EQ(motion.scene.mesh.num_nodes(), 9);
  EXPECT_EQ(motion.scene.handles.nodes, (std::vector<int>{0, 6}));
  EXPECT_EQ(motion.scene.handles.path.times(), motion.times);
  EXPECT_LT((motion.scene.initial_positions - motion.positions.col(0)).norm(), 1e-6);
  EXPECT_EQ(motion.scene.initial_positions.head<3>(), SmallMotion().handle_positions.col(0).head<3>());
}

TEST_F(ReadMotionTest, KindsOfPointsBecomePartOfARecording) {
  MotionTensors tensors = SmallMotion();
  const std::string before = Written(tensors);
  tensors.point_kind = {0, 2, 0, 2, 1, 2, 0, 2, 0};
  EXPECT_NE(Written(tensors), before);
  EXPECT_EQ(ReadMotionTensors(Path()).point_kind, tensors.point_kind);
  const RecordedMotion motion = ReadMotion(Path());
  EXPECT_EQ(motion.points[0].kind, PointKind::kMaterial);
  EXPECT_EQ(motion.points[4].kind, PointKind::kSurface);
  EXPECT_EQ(motion.points[7].kind, PointKind::kBorder);
  tensors.point_kind.clear();
  EXPECT_EQ(Written(tensors), before);
}

TEST_F(ReadMotionTest, CloudsBecomePartOfARecording) {
  MotionTensors tensors = SmallMotion();
  AddClouds(&tensors);
  tensors.positions.resize(0, 4);
  tensors.sigma.resize(0);
  tensors.scene_text = R"({"clothid_scene": 1, "handles": [0, 6], "initial": {"positions": "rest"}})";
  const RecordedMotion motion = Read(tensors);
  EXPECT_EQ(motion.num_points(), 0);
  ASSERT_EQ(motion.clouds.size(), 4U);
  EXPECT_EQ(motion.clouds[3].cols(), 7);
  EXPECT_EQ(motion.cloud_sigma, 0.002);
  EXPECT_EQ(motion.scene.initial_positions.segment<3>(3), tensors.mesh.rest_positions.col(1));
  // Nothing else says where the cloth starts.
  tensors.scene_text = R"({"clothid_scene": 1, "handles": [0, 6]})";
  ExpectError([&] { Read(tensors); }, kBadData, {"cloth.motion.bin", "initial"});
}

TEST_F(ReadMotionTest, CompletesAGapInTheFirstFrame) {
  MotionTensors tensors = SmallMotion();
  tensors.single_precision = false;
  const Eigen::Isometry3d motion =
      Eigen::Translation3d(0.3, -2.0, 1.0) * Eigen::AngleAxisd(2.0, Eigen::Vector3d(1, 2, 3).normalized());
  const Eigen::Matrix3Xd moved = motion * tensors.mesh.rest_positions;
  tensors.handle_index.clear();
  tensors.handle_positions.resize(0, 0);
  tensors.scene_text = "{\"clothid_scene\": 1}";
  tensors.positions.col(0) = moved.reshaped();
  tensors.positions.col(0).segment<3>(12).setConstant(kNaN);
  tensors.positions(25, 0) = kNaN;
  EXPECT_LT((Read(tensors).scene.initial_positions - moved.reshaped()).norm(), 1e-12);
  tensors.positions.col(0).tail(21).setConstant(kNaN);
  ExpectError([&] { Read(tensors); }, kBadData, {"cloth.motion.bin: scene:1: key 'initial.positions': is missing"});
  tensors.positions.col(0).segment<3>(6) = moved.col(2);  // three nodes, all on one line
  ExpectError([&] { Read(tensors); }, kBadData, {"key 'initial.positions': is missing"});
  tensors.scene_text = R"({"clothid_scene": 1, "initial": {"positions": "rest"}})";
  EXPECT_EQ(Read(tensors).scene.initial_positions, tensors.mesh.rest_positions.reshaped());
}

TEST_F(ReadMotionTest, PlacesTheRestShapeUnderMarkers) {
  MotionTensors tensors = SmallMotion();
  tensors.single_precision = false;
  const Eigen::Isometry3d motion =
      Eigen::Translation3d(0.3, -2.0, 1.0) * Eigen::AngleAxisd(-1.0, Eigen::Vector3d(3, 2, 1).normalized());
  const Eigen::Matrix3Xd moved = motion * tensors.mesh.rest_positions;
  tensors.handle_index.clear();
  tensors.handle_positions.resize(0, 0);
  tensors.sigma.resize(0);
  tensors.scene_text = "{\"clothid_scene\": 1}";
  tensors.face_index = {0, 5, 7, 2};
  tensors.barycentric = Eigen::Vector3d(0.5, 0.125, 0.375).replicate(1, 4);
  tensors.positions.resize(12, 4);
  for (int p = 0; p < 4; ++p) {
    const Eigen::Vector3i face = tensors.mesh.faces.col(tensors.face_index[static_cast<std::size_t>(p)]);
    const Eigen::Vector3d place = 0.5 * moved.col(face[0]) + 0.125 * moved.col(face[1]) + 0.375 * moved.col(face[2]);
    tensors.positions.middleRows(3 * p, 3).colwise() = place;
  }
  const RecordedMotion recording = Read(tensors);
  EXPECT_LT((recording.scene.initial_positions - moved.reshaped()).norm(), 1e-12);
  EXPECT_EQ(recording.points[1].num_nodes, 3);
  EXPECT_EQ(recording.points[1].nodes[2], tensors.mesh.faces(2, 5));
  EXPECT_EQ(recording.points[1].weights[2], 0.375);
}

// What moves the handles is known at other times than the cloth is seen.
TEST_F(ReadMotionTest, HandlesMayHaveTimesOfTheirOwn) {
  MotionTensors tensors = SmallMotion();
  tensors.single_precision = false;
  tensors.handle_times = Eigen::Vector3d(0.5, 1.2, 2.0);
  tensors.handle_positions = Eigen::MatrixXd::Random(6, 3);
  WriteMotion(tensors, Path());
  ExpectSame(tensors, ReadMotionTensors(Path()));
  const HandlePath path = ReadMotion(Path()).scene.handles.path;
  EXPECT_EQ(path.times(), tensors.handle_times);
  EXPECT_EQ(path.positions(), tensors.handle_positions);
}

TEST_F(ReadMotionTest, SmoothsHandlePathsOnRequest) {
  MotionTensors tensors = SmallMotion();
  tensors.times = Eigen::VectorXd::LinSpaced(60, 0.0, 6.0);
  tensors.positions = tensors.positions.col(0).replicate(1, 60).eval();
  tensors.handle_positions = 0.01 * Eigen::MatrixXd::Random(6, 60);
  ReadMotionOptions options;
  const double smoothed = Read(tensors, options).scene.handles.path.positions().norm();
  EXPECT_LT(smoothed, 0.5 * tensors.handle_positions.norm());
  options.smooth_handles = false;
  const RecordedMotion raw = Read(tensors, options);
  EXPECT_EQ(raw.scene.handles.path.positions(), tensors.handle_positions);
  EXPECT_EQ(raw.scene.initial_positions.head<3>(), tensors.handle_positions.col(0).head<3>());
}

// 60 frames of a cloth that hangs still, with noise of 2 mm.
TEST_F(ReadMotionTest, EstimatesSigmaAndSmoothsTheStartOnRequest) {
  MotionTensors tensors = SmallMotion();
  tensors.scene_text = "{\"clothid_scene\": 1}";
  tensors.handle_index.clear();
  tensors.handle_positions.resize(0, 0);
  tensors.sigma.resize(0);
  tensors.times = Eigen::VectorXd::LinSpaced(60, 0.0, 6.0);
  tensors.positions = tensors.mesh.rest_positions.reshaped().replicate(1, 60);
  std::mt19937_64 generator(1);
  std::normal_distribution<double> normal(0.0, 2e-3);
  for (double& position : tensors.positions.reshaped()) position += normal(generator);

  RecordedMotion motion = Read(tensors);
  EXPECT_EQ(motion.sigma_source, SigmaSource::kUnknown);
  EXPECT_EQ(motion.sigma.size(), 0);
  EXPECT_EQ(motion.start_source, StartSource::kFirstFrame);
  const auto error = [&] { return (motion.scene.initial_positions - tensors.mesh.rest_positions.reshaped()).norm(); };
  const double first_error = error();

  ReadMotionOptions options;
  options.start = StartSource::kSmoothed;
  options.sigma_source = SigmaSource::kEstimated;
  motion = Read(tensors, options);
  EXPECT_EQ(motion.sigma_source, SigmaSource::kEstimated);
  EXPECT_NEAR(motion.sigma.mean(), 2e-3, 3e-4);
  EXPECT_EQ(motion.start_source, StartSource::kSmoothed);
  EXPECT_LT(error(), 0.6 * first_error);
  EXPECT_TRUE(motion.scene.initial_velocities.isZero());

  options.sigma_source = SigmaSource::kGiven;
  options.sigma = 5e-3;
  EXPECT_TRUE((Read(tensors, options).sigma.array() == 5e-3).all());
  tensors.sigma = Eigen::VectorXd::Constant(9, 1e-3);
  EXPECT_EQ(Read(tensors, options).sigma_source, SigmaSource::kGiven);
  options.sigma_source = SigmaSource::kEstimated;
  EXPECT_EQ(Read(tensors, options).sigma, tensors.sigma) << "what a recording knows is not estimated";
  tensors.scene_text = R"({"clothid_scene": 1, "initial": {"positions": "rest"}})";
  motion = Read(tensors, options);
  EXPECT_EQ(motion.start_source, StartSource::kScene);
  EXPECT_EQ(error(), 0.0) << "what the scene says stays";
}

TEST_F(ReadMotionTest, TakesAnotherSceneOnRequest) {
  ReadMotionOptions options;
  options.scene_path = folder_.Write("other.json", "{\"clothid_scene\": 1, \"time_step\": 0.02}");
  const RecordedMotion motion = Read(SmallMotion(), options);
  EXPECT_EQ(motion.scene.time_step, 0.02);
  EXPECT_EQ(motion.scene_text, "{\"clothid_scene\": 1, \"time_step\": 0.02}");
  folder_.Write("other.json", "{\"clothid_scene\": 1,\n\"handles\": [1]}");
  ExpectError([&] { ReadMotion(Path(), options); }, kBadData, {"other.json:2: key 'handles'", "0, 6"});
  options.scene_path = folder_.File("none.json");
  ExpectError([&] { ReadMotion(Path(), options); }, ErrorKind::kIo, {"none.json"});
}

TEST_F(ReadMotionTest, NamesTheLineOfItsScene) {
  MotionTensors tensors = SmallMotion();
  tensors.scene_text = "{\"clothid_scene\": 1,\n\n \"gravty\": 0}";
  ExpectError([&] { Read(tensors); }, kBadData, {"cloth.motion.bin: scene:3: key 'gravty': unknown key"});
}

}  // namespace
}  // namespace clothid::read_motion_test
