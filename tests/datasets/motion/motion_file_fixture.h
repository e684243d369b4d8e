// A small motion file: written, taken apart, damaged and read again.
#ifndef CLOTHID_TESTS_DATASETS_MOTION_MOTION_FILE_FIXTURE_H_
#define CLOTHID_TESTS_DATASETS_MOTION_MOTION_FILE_FIXTURE_H_

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "datasets/files/sha256.h"
#include "datasets/motion/motion_file.h"
#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::motion_file_fixture {

using Json = nlohmann::ordered_json;

inline constexpr ErrorKind kBadData = ErrorKind::kBadData;
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Four frames of a cloth of 3 x 3 nodes that drifts, held at two nodes, with one point missing in the second frame.
inline MotionTensors SmallMotion() {
  MotionTensors tensors;
  GridOptions grid;
  grid.nodes = {3, 3};
  tensors.mesh = MakeGrid(grid);
  tensors.times = Eigen::Vector4d(1.0, 1.1, 1.25, 1.4);
  tensors.positions = tensors.mesh.rest_positions.reshaped().replicate(1, 4);
  for (int t = 0; t < 4; ++t) tensors.positions.col(t).array() += 0.125 * t;
  tensors.positions.col(1).segment<3>(12).setConstant(kNaN);
  tensors.handle_index = {0, 6};
  tensors.handle_positions.resize(6, 4);
  tensors.handle_positions << tensors.positions.topRows(3), tensors.positions.middleRows(18, 3);
  tensors.sigma = Eigen::VectorXd::Constant(9, 0.004);
  tensors.scene_text = "{\"clothid_scene\": 1,\n \"handles\": [0, 6]}";
  tensors.provenance = "a \"test\" of \"header_sha256\"";
  return tensors;
}

// Beside the tracked points; the second frame has no cloud.
inline void AddClouds(MotionTensors* tensors) {
  std::srand(3);
  for (const int count : {5, 0, 3, 7}) tensors->clouds.push_back(Eigen::Matrix3Xd::Random(3, count));
  tensors->cloud_sigma = 0.002;
}

inline bool SameNumbers(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         ((a.array() == b.array()) || (a.array().isNaN() && b.array().isNaN())).all();
}

inline void ExpectSame(const MotionTensors& a, const MotionTensors& b) {
  EXPECT_TRUE(SameNumbers(a.times, b.times));
  EXPECT_TRUE(SameNumbers(a.positions, b.positions));
  EXPECT_EQ(a.single_precision, b.single_precision);
  EXPECT_TRUE(SameNumbers(a.mesh.rest_positions, b.mesh.rest_positions));
  EXPECT_EQ(a.mesh.faces, b.mesh.faces);
  EXPECT_EQ(a.node_index, b.node_index);
  EXPECT_EQ(a.face_index, b.face_index);
  EXPECT_TRUE(SameNumbers(a.barycentric, b.barycentric));
  EXPECT_EQ(a.point_kind, b.point_kind);
  EXPECT_EQ(a.handle_index, b.handle_index);
  EXPECT_TRUE(SameNumbers(a.handle_positions, b.handle_positions));
  EXPECT_TRUE(SameNumbers(a.handle_times, b.handle_times));
  EXPECT_TRUE(SameNumbers(a.sigma, b.sigma));
  EXPECT_EQ(a.scene_text, b.scene_text);
  EXPECT_EQ(a.provenance, b.provenance);
}

inline std::string ReadAll(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// A motion file taken apart, to be damaged and put together again with matching checksums.
struct RawMotion {
  Json header;
  std::string data;

  explicit RawMotion(const std::string& bytes) {
    std::uint64_t length = 0;
    std::memcpy(&length, bytes.data(), 8);
    header = Json::parse(bytes.substr(8, length));
    header["__metadata__"].erase("header_sha256");
    data = bytes.substr(8 + length);
  }

  template <typename T>
  void Set(const std::string& tensor, std::size_t index, T value) {
    const std::size_t begin = header[tensor]["data_offsets"][0];
    std::memcpy(data.data() + begin + index * sizeof(T), &value, sizeof(T));
  }

  std::string Bytes(bool update_digest = true) {
    if (update_digest) header["__metadata__"]["sha256"] = Sha256Hex({data});
    const std::string text = header.dump();
    const std::uint64_t length = text.size();
    std::string bytes(8, '\0');
    std::memcpy(bytes.data(), &length, 8);
    return bytes + text + data;
  }
};

class MotionFile : public ::testing::Test {
 protected:
  std::string Path() const { return folder_.File("cloth.motion.bin"); }

  std::string Written(const MotionTensors& tensors) const {
    WriteMotion(tensors, Path());
    return ReadAll(Path());
  }

  RawMotion Raw() const { return RawMotion(Written(SmallMotion())); }

  void ExpectRejected(const std::string& bytes, std::initializer_list<const char*> fragments) const {
    folder_.Write("cloth.motion.bin", bytes);
    ExpectError(
        [&] {
          try {
            ReadMotionTensors(Path());
          } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find("cloth.motion.bin: "), std::string::npos) << error.what();
            throw;
          }
        },
        kBadData, fragments);
  }

  // Of the whole interpretation, not of the container alone.
  RecordedMotion Read(const MotionTensors& tensors, const ReadMotionOptions& options = {}) const {
    WriteMotion(tensors, Path());
    return ReadMotion(Path(), options);
  }

  TemporaryFolder folder_;
};

}  // namespace clothid::motion_file_fixture

#endif  // CLOTHID_TESTS_DATASETS_MOTION_MOTION_FILE_FIXTURE_H_
