// Sequences of obstacles that deform, as scenes name them.
#include "sim/scene/sequence_json.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "sim/base/npy_file.h"
#include "sim/scene/obstacle_json.h"
#include "tests/expect_error.h"
#include "tests/sim/scene/triangle_meshes.h"
#include "tests/temporary_folder.h"

namespace clothid::sequence_json_test {
namespace {

// A cube that grows from frame to frame.
class SequenceJsonTest : public testing::Test {
 protected:
  static constexpr int kFrames = 3;

  SequenceJsonTest() : cube_(CubeMesh(0.1)), positions_(24, kFrames) {
    for (int frame = 0; frame < kFrames; ++frame)
      positions_.col(frame) = (1.0 + 0.1 * frame) * cube_.vertices.reshaped();
    WriteObj("cube.obj", 0);
    for (int frame = 0; frame < kFrames; ++frame) WriteObj("f_" + std::to_string(frame + 1) + ".obj", frame);
    WriteNpy("grow.npy", positions_);
    folder_.Write("times.npy", NpyBytes(NpyArray{{kFrames}, {0.5, 0.7, 1.0}}));
  }

  void WriteObj(const std::string& name, int frame, int fewer_faces = 0, double last_x = 0.0) {
    std::string text;
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3d p = positions_.col(frame).segment<3>(3 * i);
      text += "v " + std::to_string(p.x() + (i == 7 ? last_x : 0.0)) + " " + std::to_string(p.y()) + " " +
              std::to_string(p.z()) + "\n";
    }
    for (int f = 0; f < 12 - fewer_faces; ++f) {
      text += "f";
      for (const int vertex : cube_.faces.col(f)) text += " " + std::to_string(vertex + 1);
      text += "\n";
    }
    folder_.Write(name, text);
  }
  void WriteNpy(const std::string& name, const Eigen::MatrixXd& positions) {
    NpyArray array;
    array.shape = {positions.cols(), positions.rows() / 3, 3};
    array.values.assign(positions.data(), positions.data() + positions.size());
    folder_.Write(name, NpyBytes(array));
  }
  // Samples at the frames 2, 4, 6, ..
  void WriteCache(const std::string& name) {
    std::string bytes("POINTCACHE2\0", 12);
    const auto append = [&](auto value) {
      char raw[4];
      std::memcpy(raw, &value, 4);
      bytes.append(raw, 4);
    };
    append(1), append(8), append(2.0f), append(2.0f), append(kFrames);
    for (const double value : positions_.reshaped()) append(static_cast<float>(value));
    folder_.Write(name, bytes);
  }

  SceneObstacle Read(const std::string& sequence, const std::string& more = "") const {
    const std::string text =
        R"([{"type": "mesh", "name": "body", "obj": "cube.obj", "sequence": )" + sequence + more + "}]";
    const JsonValue value = ParseJson(text, "scene.json");
    return ReadObstacles(JsonNode(value, "scene.json"), {}, folder_.path()).front();
  }
  void ExpectRefused(const std::string& sequence, std::initializer_list<const char*> fragments) const {
    ExpectError([&] { Read(sequence); }, ErrorKind::kBadData, fragments);
  }
  void ExpectFrames(const SceneObstacle& obstacle, const Eigen::Vector3d& times, double tolerance) const {
    ASSERT_NE(obstacle.sequence, nullptr);
    EXPECT_LE((obstacle.sequence->times() - times).norm(), 1e-14);
    EXPECT_LE((obstacle.sequence->positions() - positions_).cwiseAbs().maxCoeff(), tolerance);
    EXPECT_TRUE(obstacle.moves());
  }

  TemporaryFolder folder_;
  TriangleMesh cube_;
  Eigen::MatrixXd positions_;
};

TEST_F(SequenceJsonTest, ReadsEveryForm) {
  WriteCache("grow.pc2");
  const Eigen::Vector3d times(0.5, 0.7, 1.0), at_ten_hertz(2.0, 2.1, 2.2);
  ExpectFrames(Read(R"({"file": "grow.npy", "times": [0.5, 0.7, 1]})"), times, 0.0);
  ExpectFrames(Read(R"({"file": "grow.npy", "times": "times.npy"})"), times, 0.0);
  ExpectFrames(Read(R"({"file": "grow.npy", "frame_rate": 10, "start_time": 2})"), at_ten_hertz, 0.0);
  ExpectFrames(Read(R"({"file": "f_#.obj", "frame_rate": 10, "start_time": 2})"), at_ten_hertz, 1e-6);
  ExpectFrames(Read(R"({"file": ["f_1.obj", "f_2.obj", "f_3.obj"], "times": [0.5, 0.7, 1]})"), times, 1e-6);
  // A cache counts frames of an animation.
  ExpectFrames(Read(R"({"file": "grow.pc2", "frame_rate": 20, "start_time": 1.9})"), at_ten_hertz, 1e-7);
  ExpectFrames(Read(R"({"file": "grow.pc2", "times": [0.5, 0.7, 1]})"), times, 1e-7);
}

TEST_F(SequenceJsonTest, NamesWhatIsWrong) {
  ExpectRefused(R"({"file": "grow.npy"})", {"scene.json:1: key '[0].sequence'", "\"times\"", "\"frame_rate\""});
  ExpectRefused(R"({"file": "grow.npy", "times": [0, 1, 2], "frame_rate": 1})", {"either"});
  ExpectRefused(R"({"frame_rate": 10})", {"sequence.file", "OBJ files"});
  ExpectRefused(R"({"file": "grow.npy", "times": [0, 1]})", {"grow.npy: ", "3 frames and 2 times"});
  ExpectRefused(R"({"file": "grow.npy", "times": [0, 1, 1]})", {"grow.npy: frame 2: expected a finite time above"});
  ExpectRefused(R"({"file": "grow.npy", "frame_rate": 10000})",
                {"grow.npy: frame 1: the sequence jumps: vertex 0", "50"});
  positions_.resize(27, kFrames);
  positions_.setOnes();
  WriteNpy("other.npy", positions_);
  ExpectRefused(R"({"file": "other.npy", "frame_rate": 10})", {"other.npy: frames of 9 vertices; expected the 8"});
  ExpectError([&] { Read(R"({"file": "grow.npy", "frame_rate": 10})", R"(, "path": [[0, 0, 0, 0, 0, 0, 0, 1]])"); },
              ErrorKind::kBadData, {"sequence", "none beside \"path\""});
}

TEST_F(SequenceJsonTest, NamesFileFrameAndFace) {
  const std::string pattern = R"({"file": "f_#.obj", "frame_rate": 10})";
  WriteObj("f_2.obj", 1, 1);
  ExpectRefused(pattern, {"f_2.obj: has 11 triangles; expected the 12 of the mesh"});
  cube_.faces.col(5).swap(cube_.faces.col(6));
  WriteObj("f_2.obj", 1);
  ExpectRefused(pattern, {"f_2.obj:14: triangle 5 has other vertices"});
  cube_.faces.col(5).swap(cube_.faces.col(6));
  positions_.col(1).segment<3>(21) = positions_.col(1).segment<3>(18);  // vertex 7 on vertex 6
  WriteObj("f_2.obj", 1);
  ExpectRefused(pattern, {"f_2.obj:12: frame 1: triangle 3 has no area"});
  positions_.col(1) *= -1.0;
  WriteNpy("grow.npy", positions_);
  WriteObj("cube.obj", 0, 1);
  ExpectRefused(pattern,
                {"cube.obj:", ": triangulated surface: edge ", "belongs to one triangle only", "closed surface"});
}

TEST_F(SequenceJsonTest, OnlyMeshesDeform) {
  const std::string text =
      R"([{"type": "sphere", "center": [0, 0, 0], "radius": 1, "sequence": {"file": "grow.npy"}}])";
  const JsonValue value = ParseJson(text, "scene.json");
  ExpectError([&] { ReadObstacles(JsonNode(value, "scene.json"), {}, ""); }, ErrorKind::kBadData, {"sequence"});
}

}  // namespace
}  // namespace clothid::sequence_json_test
