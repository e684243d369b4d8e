#include "datasets/synthetic/synthetic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <iomanip>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>

#include "sim/base/error.h"
#include "sim/base/npy_file.h"
#include "sim/obstacle/triangulated_surface.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/scene_json.h"
#include "tests/expect_error.h"
#include "tests/sim/scene/triangle_meshes.h"
#include "tests/temporary_folder.h"

namespace clothid::synthetic_test {
namespace {

constexpr char kSceneText[] = R"({
  "clothid_scene": 1, "time_step": 0.01, "duration": 0.2, "handles": [0, 1, 2],
  "mesh": {"grid": {"nodes": [3, 3], "size": [0.2, 0.2]}}
})";

// A scene, and a rollout of it in which every node moves along x by a square law of time.
class SyntheticTest : public testing::Test {
 protected:
  SyntheticTest() : scene_(ParseScene(kSceneText, "scene.json", "")) {
    rollout_.time_step = scene_.time_step;
    rollout_.initial_positions = scene_.initial_positions;
    for (int step = 1; step <= scene_.num_steps(); ++step) {
      StepRecord record;
      record.positions = PositionsAfter(step);
      rollout_.records.push_back(record);
      rollout_.last_record.push_back(step - 1);
    }
  }

  Eigen::VectorXd PositionsAfter(double step) const {
    Eigen::VectorXd positions = scene_.initial_positions;
    for (Eigen::Index i = 0; i < positions.size(); i += 3) positions[i] += step * step;
    return positions;
  }

  MotionTensors Record(const SyntheticOptions& options) const {
    return RecordRollout(rollout_, scene_, kSceneText, options);
  }

  Scene scene_;
  Rollout rollout_;
};

TEST_F(SyntheticTest, WithoutOptionsEveryStepIsAFrame) {
  const MotionTensors motion = Record({});
  ASSERT_EQ(motion.times.size(), 21);
  EXPECT_EQ(motion.times[20], 20 * scene_.time_step);
  EXPECT_EQ(motion.positions.col(7), PositionsAfter(7));
  EXPECT_FALSE(motion.single_precision);
  EXPECT_TRUE(motion.node_index.empty());
  EXPECT_TRUE(motion.handle_index.empty());
  EXPECT_EQ(motion.sigma.size(), 0);
}

TEST_F(SyntheticTest, FrameRatesThatDivideTheStepRateFallOnSteps) {
  EXPECT_EQ(FrameSteps(0.0, 0.01, 3), Eigen::Vector4d(0, 1, 2, 3));
  EXPECT_EQ(FrameSteps(50.0, 0.01, 6), Eigen::Vector4d(0, 2, 4, 6));
  EXPECT_EQ(FrameSteps(30.0, 1.0 / 60.0, 7), Eigen::Vector4d(0, 2, 4, 6));
  EXPECT_EQ(FrameSteps(30.0, 0.0166666667, 7), Eigen::Vector4d(0, 2, 4, 6));
  EXPECT_EQ(FrameSteps(40.0, 0.01, 5), Eigen::Vector3d(0, 2.5, 5));
  EXPECT_EQ(FrameSteps(200.0, 0.01, 1), Eigen::Vector3d(0, 0.5, 1));
  for (const double rate : {1e12, 1e308}) {
    ExpectError([&] { FrameSteps(rate, 0.01, 100); }, ErrorKind::kUsage, {"frame_rate", "at most 10000000 frames"});
  }
}

TEST_F(SyntheticTest, FramesBetweenStepsAreLinear) {
  SyntheticOptions options;
  options.frame_rate = 40.0;
  const MotionTensors motion = Record(options);
  ASSERT_EQ(motion.times.size(), 9);
  EXPECT_DOUBLE_EQ(motion.times[1], 0.025);
  EXPECT_LE((motion.positions.col(1) - 0.5 * (PositionsAfter(2) + PositionsAfter(3))).norm(), 1e-14);
}

TEST_F(SyntheticTest, NoiseHasTheStatedDeviation) {
  SyntheticOptions options;
  options.noise_sigma = 0.02;
  const MotionTensors exact = Record({}), noisy = Record(options);
  const Eigen::ArrayXXd noise = (noisy.positions - exact.positions).array();
  const double num_values = static_cast<double>(noise.size());
  EXPECT_NEAR(std::sqrt(noise.square().mean()), options.noise_sigma,
              4.0 * options.noise_sigma / std::sqrt(2.0 * num_values));
  EXPECT_NEAR(noise.mean(), 0.0, 4.0 * options.noise_sigma / std::sqrt(num_values));
  EXPECT_EQ(noisy.sigma, Eigen::VectorXd::Constant(9, options.noise_sigma));
}

TEST_F(SyntheticTest, DroppedPointsMissAllCoordinates) {
  SyntheticOptions options;
  options.drop_fraction = 0.3;
  const MotionTensors motion = Record(options);
  const auto missing = motion.positions.reshaped(3, 9 * 21).array().isNaN().eval();
  EXPECT_TRUE((missing.row(0) == missing.row(1) && missing.row(1) == missing.row(2)).all());
  EXPECT_NEAR(static_cast<double>(missing.row(0).count()) / (9 * 21), 0.3, 0.14);  // four standard deviations
}

TEST_F(SyntheticTest, MarkersAreFreeNodesChosenBySeed) {
  SyntheticOptions options;
  options.num_markers = 4;
  std::set<std::vector<int>> choices;
  for (options.seed = 1; options.seed <= 10; ++options.seed) {
    const MotionTensors motion = Record(options);
    ASSERT_EQ(motion.node_index.size(), 4u);
    EXPECT_EQ(std::set<int>(motion.node_index.begin(), motion.node_index.end()).size(), 4u);
    EXPECT_EQ(motion.node_index, Record(options).node_index);
    for (int p = 0; p < 4; ++p) {
      EXPECT_GE(motion.node_index[p], 3);
      EXPECT_EQ(motion.positions.col(20).segment<3>(3 * p), PositionsAfter(20).segment<3>(3 * motion.node_index[p]));
    }
    choices.insert(motion.node_index);
  }
  EXPECT_GT(choices.size(), 1u);
}

// Noise of the same seed is the same whether points are dropped or not.
TEST_F(SyntheticTest, StreamsAreIndependent) {
  SyntheticOptions options;
  options.noise_sigma = 0.01;
  const MotionTensors whole = Record(options);
  options.drop_fraction = 0.5;
  const MotionTensors dropped = Record(options);
  const auto seen = !dropped.positions.array().isNaN();
  EXPECT_TRUE((seen.select(dropped.positions, whole.positions).array() == whole.positions.array()).all());
}

TEST_F(SyntheticTest, CloudsAreOnTheSurfaceAndTakeThePlaceOfTheNodes) {
  SyntheticOptions options;
  options.num_cloud_points = 200;
  const MotionTensors motion = Record(options);
  EXPECT_EQ(motion.positions.rows(), 0);
  EXPECT_EQ(motion.cloud_sigma, 0.0);
  ASSERT_EQ(motion.clouds.size(), 21U);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (int frame = 0; frame < 21; ++frame) {
    const Eigen::Matrix3Xd points = motion.clouds[frame].colwise() - Eigen::Vector3d(frame * frame, 0.0, 0.0);
    ASSERT_EQ(points.cols(), 200);
    EXPECT_LT(points.row(2).norm(), 1e-15);
    EXPECT_GE(points.minCoeff(), -1e-12);
    EXPECT_LE(points.maxCoeff(), 0.2 + 1e-12);
    mean += points.rowwise().mean() / 21.0;
  }
  EXPECT_NEAR(mean.x(), 0.1, 4.0 * 0.2 / std::sqrt(12.0 * 21.0 * 200.0));
  EXPECT_NEAR(mean.y(), 0.1, 4.0 * 0.2 / std::sqrt(12.0 * 21.0 * 200.0));
  options.seed = 2;
  EXPECT_NE(Record(options).clouds[0], motion.clouds[0]);
}

TEST_F(SyntheticTest, CloudsHaveNoiseAndGapsAndLeaveMarkersAsTheyAre) {
  SyntheticOptions options;
  options.noise_sigma = 0.01;
  options.num_markers = 3;
  options.drop_fraction = 0.25;
  const MotionTensors without = Record(options);
  options.num_cloud_points = 500;
  const MotionTensors motion = Record(options);
  EXPECT_EQ(motion.node_index, without.node_index);
  EXPECT_TRUE((motion.positions.array() == without.positions.array() || motion.positions.array().isNaN()).all());
  EXPECT_EQ(motion.cloud_sigma, 0.01);
  double num_points = 0.0, squares = 0.0;
  for (const Eigen::Matrix3Xd& cloud : motion.clouds) {
    num_points += static_cast<double>(cloud.cols());
    squares += cloud.row(2).squaredNorm();
  }
  EXPECT_NEAR(num_points, 0.75 * 21 * 500, 200.0);
  EXPECT_NEAR(std::sqrt(squares / num_points), 0.01, 5e-4);
  options.num_cloud_points = -1;
  ExpectError([&] { Record(options); }, ErrorKind::kUsage, {"cloud -1"});
}

TEST_F(SyntheticTest, MovingHandlesAreRecorded) {
  Eigen::MatrixXd path(9, 2);
  path.col(0) = scene_.initial_positions.head<9>();
  path.col(1) = path.col(0).array() + 0.1;
  scene_.handles.path = HandlePath(Eigen::Vector2d(0.0, 0.2), path);
  const MotionTensors motion = Record({});
  EXPECT_EQ(motion.handle_index, scene_.handles.nodes);
  ASSERT_EQ(motion.handle_positions.rows(), 9);
  ASSERT_EQ(motion.handle_positions.cols(), motion.times.size());
  EXPECT_LE((motion.handle_positions.col(10) - (path.col(0).array() + 0.05).matrix()).norm(), 1e-14);
}

TEST_F(SyntheticTest, TheTextOfARecordingNamesNoFiles) {
  const std::string text = R"({"clothid_scene": 1, "time_step": 0.01, "mesh": {"obj": "cloth.obj"}, "duration": 0.2,
                              "initial": {"positions": "start.npy", "velocity": [1, 0, 0]},
                              "handles": {"nodes": [0, 1, 2], "path": "handles.csv"}})";
  const auto recorded = nlohmann::json::parse(RecordRollout(rollout_, scene_, text, {}).scene_text);
  EXPECT_EQ(recorded, nlohmann::json::parse(R"({"clothid_scene": 1, "time_step": 0.01, "duration": 0.2,
                                                "initial": {"velocity": [1, 0, 0]}, "handles": [0, 1, 2]})"));
}

// An icosphere whose coordinates need every digit, as a file.
std::string WriteObj(const TemporaryFolder& folder, const TriangleMesh& mesh) {
  std::ostringstream obj;
  obj << std::setprecision(17);
  for (const auto& vertex : mesh.vertices.colwise()) obj << "v " << vertex.transpose() << "\n";
  for (const auto& face : mesh.faces.colwise()) obj << "f " << (face.array() + 1).transpose() << "\n";
  return folder.Write("ball.obj", obj.str());
}

TEST(SyntheticOnASurfaceTest, ARecordingSimulatesToTheSameBits) {
  const TemporaryFolder folder;
  const std::string obj = WriteObj(folder, IcosphereMesh(1, 0.1));
  const std::string text = R"({"clothid_scene": 1, "time_step": 0.01, "duration": 0.2,
      "mesh": {"grid": {"nodes": [5, 5], "size": [0.2, 0.2], "origin": [-0.1, -0.1, 0.11]}},
      "obstacles": [{"type": "plane", "point": [0, 0, -1], "normal": [0, 0, 1]},
                    {"name": "ball", "type": "mesh", "obj": "ball.obj", "mu": 0.4, "contact_distance": 1e-3}]})";
  const Scene scene = ParseScene(text, "scene.json", folder.path());
  Simulator simulator(scene);
  const Rollout rollout = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator);
  ASSERT_TRUE(rollout.ok());
  ASSERT_GT(rollout.counts.contacts, 0);
  const std::string path = folder.File("motion.bin");
  WriteMotion(RecordRollout(rollout, scene, text, {}), path);
  ReadMotionOptions with_scene;
  with_scene.scene_path = folder.Write("scene.json", text);
  EXPECT_EQ(ReadMotion(path, with_scene).scene_text.find("ball.obj"), std::string::npos);
  std::filesystem::remove(obj);
  const RecordedMotion motion = ReadMotion(path);
  EXPECT_EQ(motion.scene_text.find("ball.obj"), std::string::npos);
  EXPECT_EQ(motion.scene.obstacle_names(), scene.obstacle_names());
  Simulator again(motion.scene);
  const Rollout recorded = Simulate(motion.scene.nominal_parameters(), motion.scene.num_steps(), &again);
  ASSERT_EQ(recorded.num_steps(), rollout.num_steps());
  for (int step = 0; step <= rollout.num_steps(); ++step) {
    EXPECT_EQ(recorded.positions(step), rollout.positions(step)) << step;
  }
}

// The places of a body that deforms go along in tensors.
TEST(SyntheticWithASequenceTest, ARecordingSimulatesToTheSameBits) {
  const TemporaryFolder folder;
  const TriangleMesh cube = CubeMesh(0.06);
  NpyArray array{{3, 8, 3}, {}};
  for (const double growth : {1.0, 1.2, 1.5}) {
    for (const auto& vertex : cube.vertices.colwise()) {
      for (const double x : Eigen::Vector3d(growth * vertex + Eigen::Vector3d(0.1, 0.1, -0.07)))
        array.values.push_back(x);
    }
  }
  const std::string file = folder.Write("grow.npy", NpyBytes(array));
  nlohmann::json json = nlohmann::json::parse(kSceneText), body = {{"type", "mesh"}, {"contact_distance", 0.01}};
  for (const auto& vertex : cube.vertices.colwise()) body["vertices"].push_back({vertex[0], vertex[1], vertex[2]});
  for (const auto& face : cube.faces.colwise()) body["faces"].push_back({face[0], face[1], face[2]});
  body["sequence"] = {{"file", "grow.npy"}, {"frame_rate", 10}};
  json["obstacles"] = {body};
  const Scene scene = ParseScene(json.dump(), "scene.json", folder.path());
  Simulator simulator(scene);
  const Rollout rollout = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator);
  ASSERT_TRUE(rollout.ok());
  ASSERT_GT(rollout.counts.contacts, 0);
  const std::string path = folder.File("motion.bin");
  WriteMotion(RecordRollout(rollout, scene, json.dump(), {}), path);
  std::filesystem::remove(file);
  const RecordedMotion motion = ReadMotion(path);
  Simulator again(motion.scene);
  const Rollout recorded = Simulate(motion.scene.nominal_parameters(), motion.scene.num_steps(), &again);
  ASSERT_EQ(recorded.num_steps(), rollout.num_steps());
  EXPECT_EQ(recorded.positions(rollout.num_steps()), rollout.positions(rollout.num_steps()));
}

// The directions of u stand in the recording one by one, so that it needs no file.
TEST(SyntheticWithAUvMapTest, ARecordingSimulatesToTheSameBits) {
  const TemporaryFolder folder;
  const std::string obj =
      folder.Write("cloth.obj",
                   "v 0 0 0\nv .1 0 0\nv .2 0 0\nv 0 .1 0\nv .1 .13 0\nv .2 .1 0\nvt 0 0\nvt 1 .3\n"
                   "vt 2 .7\nvt -.2 1\nvt .9 1.1\nvt 1.7 2\nf 1/1 2/2 5/5 4/4\nf 2/2 3/3 6/6 5/5\n");
  const std::string text = R"({"clothid_scene": 2, "time_step": 0.01, "duration": 0.1, "mesh": {"obj": "cloth.obj"},
      "handles": [0], "materials": {"membrane": "orthotropic", "k_warp": 50, "k_weft": 10, "k_shear": 3,
      "warp_direction": "uv", "warp_angle": 5}})";
  const Scene scene = ParseScene(text, "scene.json", folder.path());
  Simulator simulator(scene);
  const Rollout rollout = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator);
  ASSERT_TRUE(rollout.ok());
  const std::string path = folder.File("motion.bin");
  WriteMotion(RecordRollout(rollout, scene, text, {}), path);
  ReadMotionOptions with_scene;
  with_scene.scene_path = folder.Write("scene.json", text);
  EXPECT_EQ(ReadMotion(path, with_scene).scene.warp.directions, scene.warp.directions);
  EXPECT_EQ(ReadMotion(path, with_scene).scene_text.find("\"uv\""), std::string::npos);
  std::filesystem::remove(obj);
  const RecordedMotion motion = ReadMotion(path);
  EXPECT_EQ(motion.scene.warp.directions, scene.warp.directions);
  Simulator again(motion.scene);
  const Rollout recorded = Simulate(motion.scene.nominal_parameters(), motion.scene.num_steps(), &again);
  ASSERT_EQ(recorded.num_steps(), rollout.num_steps());
  EXPECT_EQ(recorded.positions(10), rollout.positions(10));
}

TEST_F(SyntheticTest, SurfacesTooLargeForATextAreAnError) {
  const TriangleMesh mesh = IcosphereMesh(5, 0.1);
  const auto shape = std::make_shared<TriangulatedSurface>(mesh.vertices, mesh.faces);
  nlohmann::json text = nlohmann::json::parse(kSceneText);
  for (int i = 0; i < 9; ++i) {
    text["obstacles"].push_back({{"type", "mesh"}, {"obj", "ball.obj"}});
    scene_.obstacles.push_back({"ball" + std::to_string(i), shape});
  }
  ExpectError([&] { RecordRollout(rollout_, scene_, text.dump(), {}); }, ErrorKind::kBadData,
              {"surfaces of its obstacles", "more than 1000000 values"});
}

// Without a start of its own the text would leave it to the first frame, which may be noisy.
TEST_F(SyntheticTest, TheTextOfARecordingStatesAStartAtRest) {
  const auto recorded = nlohmann::json::parse(Record({}).scene_text);
  EXPECT_EQ(recorded["initial"]["positions"], "rest");
  EXPECT_EQ(recorded["mesh"]["grid"]["nodes"], nlohmann::json({3, 3}));
}

// A recording has no place for a start that is read from a file: whoever fits it states the scene, or estimates it.
TEST_F(SyntheticTest, AStartFromAFileIsNotInTheRecording) {
  const std::string text = R"({"clothid_scene": 1, "initial": {"positions": "start.npy"}})";
  SyntheticOptions noisy, sparse, dropped;
  noisy.noise_sigma = 1e-3;
  sparse.num_markers = 4;
  dropped.drop_fraction = 0.1;
  for (const SyntheticOptions& options : {sparse, dropped}) {
    EXPECT_THROW(RecordRollout(rollout_, scene_, text, options), Error);
  }
  for (const SyntheticOptions& options : {SyntheticOptions(), noisy}) {
    EXPECT_FALSE(nlohmann::json::parse(RecordRollout(rollout_, scene_, text, options).scene_text).contains("initial"));
  }
}

}  // namespace
}  // namespace clothid::synthetic_test
