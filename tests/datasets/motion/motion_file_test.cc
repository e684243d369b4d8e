// motion.bin: what is written is read, the same bytes every time, and nothing is left behind where that fails.
#include "datasets/motion/motion_file.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tests/datasets/motion/motion_file_fixture.h"

namespace clothid::motion_file_test {
namespace {

using namespace motion_file_fixture;

TEST_F(MotionFile, RoundTripsInBothPrecisions) {
  MotionTensors tensors = SmallMotion();
  Written(tensors);
  MotionTensors rounded = tensors;
  rounded.positions = tensors.positions.cast<float>().cast<double>();
  ExpectSame(ReadMotionTensors(Path()), rounded);
  tensors.single_precision = false;
  Written(tensors);
  ExpectSame(ReadMotionTensors(Path()), tensors);
}

TEST_F(MotionFile, RoundTripsPointsOnNodesAndTriangles) {
  MotionTensors tensors = SmallMotion();
  tensors.positions = tensors.positions.topRows(12).eval();
  tensors.sigma.resize(0);
  tensors.node_index = {8, 3, 1, 3};
  Written(tensors);
  MotionTensors rounded = tensors;
  rounded.positions = tensors.positions.cast<float>().cast<double>();
  ExpectSame(ReadMotionTensors(Path()), rounded);
  rounded.node_index.clear();
  rounded.face_index = {0, 1, 7, 7};
  rounded.barycentric = Eigen::Vector3d(0.5, 0.25, 0.25).replicate(1, 4);
  rounded.handle_index.clear();
  rounded.handle_positions.resize(0, 0);
  rounded.provenance.clear();
  Written(rounded);
  ExpectSame(ReadMotionTensors(Path()), rounded);
}

TEST_F(MotionFile, RoundTripsCloudsBesideTrackedPointsAndAlone) {
  MotionTensors tensors = SmallMotion();
  AddClouds(&tensors);
  const auto expect_clouds = [](const MotionTensors& read, const MotionTensors& written) {
    ASSERT_EQ(read.clouds.size(), written.clouds.size());
    for (std::size_t i = 0; i < read.clouds.size(); ++i) EXPECT_TRUE(SameNumbers(read.clouds[i], written.clouds[i]));
    EXPECT_EQ(read.cloud_sigma, written.cloud_sigma);
    EXPECT_EQ(read.single_precision_clouds, written.single_precision_clouds);
  };
  for (const bool single_precision : {true, false}) {
    tensors.single_precision_clouds = single_precision;
    MotionTensors rounded = tensors;
    for (Eigen::Matrix3Xd& cloud : rounded.clouds) {
      if (single_precision) cloud = cloud.cast<float>().cast<double>().eval();
    }
    Written(tensors);
    expect_clouds(ReadMotionTensors(Path()), rounded);
    EXPECT_EQ(ReadMotionTensors(Path()).positions.rows(), 27);

    MotionTensors alone = rounded;
    alone.positions.resize(0, 4);
    alone.sigma.resize(0);
    alone.cloud_sigma = 0.0;
    Written(alone);
    const MotionTensors read = ReadMotionTensors(Path());
    expect_clouds(read, alone);
    EXPECT_EQ(read.positions.rows(), 0);
    EXPECT_EQ(read.positions.cols(), 4);
  }
}

TEST_F(MotionFile, RefusesToWriteCloudsThatItWouldNotRead) {
  const auto refuses = [&](const std::function<void(MotionTensors*)>& spoil, const char* tensor) {
    MotionTensors tensors = SmallMotion();
    AddClouds(&tensors);
    spoil(&tensors);
    ExpectError([&] { WriteMotion(tensors, Path()); }, kBadData, {tensor});
    EXPECT_FALSE(std::filesystem::exists(Path()));
  };
  refuses([](MotionTensors* t) { t->clouds.pop_back(); }, "cloud_offsets");
  refuses([](MotionTensors* t) { t->clouds[2](0, 0) = kNaN; }, "cloud_positions");
  refuses([](MotionTensors* t) { t->clouds[2](0, 0) = 1e39; }, "cloud_positions");
  refuses([](MotionTensors* t) { t->cloud_sigma = -1.0; }, "cloud_sigma");
  refuses([](MotionTensors* t) { t->clouds.clear(); }, "cloud_positions");
  refuses(
      [](MotionTensors* t) {
        for (auto& cloud : t->clouds) cloud.resize(3, 0);
      },
      "cloud_positions");
}

TEST_F(MotionFile, HasTheSameBytesEveryTime) {
  MotionTensors tensors = SmallMotion();
  const std::string first = Written(tensors);
  tensors.positions(12, 1) = -kNaN;
  EXPECT_EQ(Written(tensors), first);
  std::uint64_t length = 0;
  std::memcpy(&length, first.data(), 8);
  EXPECT_EQ(length % 8, 0u);
}

TEST_F(MotionFile, RefusesToWriteWhatItWouldNotRead) {
  const auto expect = [&](const auto& damage, std::initializer_list<const char*> fragments) {
    MotionTensors tensors = SmallMotion();
    damage(&tensors);
    ExpectError([&] { WriteMotion(tensors, Path()); }, kBadData, fragments);
    EXPECT_FALSE(std::filesystem::exists(Path()));
  };
  expect([](MotionTensors* t) { t->times = Eigen::VectorXd::Ones(1); },
         {"tensor 'times': expected at least two frames"});
  expect([](MotionTensors* t) { t->positions.conservativeResize(24, 4); },
         {"tensor 'positions': expected the 9 nodes"});
  expect([](MotionTensors* t) { t->positions(0, 0) = 1e300; }, {"tensor 'positions': frame 0"});
  expect([](MotionTensors* t) { t->node_index = {1}; }, {"tensor 'node_index': expected 9 numbers, found 1"});
  expect([](MotionTensors* t) { t->node_index.assign(9, 9); }, {"tensor 'node_index': entry 0 is 9"});
  expect([](MotionTensors* t) { t->face_index.assign(9, 0); }, {"tensor 'barycentric': expected 27 numbers, found 0"});
  expect(
      [](MotionTensors* t) {
        t->face_index.assign(9, 0);
        t->barycentric = Eigen::Matrix3Xd::Constant(3, 9, 0.3);
      },
      {"tensor 'barycentric': row 0 does not sum to 1"});
  expect([](MotionTensors* t) { t->point_kind = {1, 1}; }, {"tensor 'point_kind': expected 9 numbers, found 2"});
  expect([](MotionTensors* t) { t->point_kind = {0, 0, 0, 0, 3, 0, 0, 0, 0}; },
         {"tensor 'point_kind': entry 4 is 3; expected 0 (material), 1 (surface) or 2 (border)"});
  expect([](MotionTensors* t) { t->handle_index.clear(); }, {"tensor 'handle_positions': expected 0 numbers"});
  expect([](MotionTensors* t) { t->sigma.resize(3); }, {"tensor 'sigma': expected 9 numbers"});
  expect([](MotionTensors* t) { t->handle_times = Eigen::Vector3d(0, 1, 2); },
         {"tensor 'handle_positions': expected 18 numbers, found 24"});
  expect([](MotionTensors* t) { t->handle_times = Eigen::Vector4d(0, 1, 1, 2); },
         {"tensor 'handle_times': entry 2 is not above"});
  expect([](MotionTensors* t) { t->handle_times = Eigen::Vector4d(0, 1, kNaN, 2); },
         {"tensor 'handle_times': entry 2 is not finite"});
  expect(
      [](MotionTensors* t) {
        t->handle_index.clear();
        t->handle_positions.resize(0, 0);
        t->handle_times = Eigen::Vector4d(0, 1, 2, 3);
      },
      {"tensor 'handle_times': expected 0 numbers, found 4"});
}

TEST_F(MotionFile, LeavesNothingBehindWhereItCannotWrite) {
  ExpectError([&] { WriteMotion(SmallMotion(), folder_.File("none/cloth.bin")); }, ErrorKind::kIo,
              {"none/cloth.bin: cannot be written: No such file"});
  std::filesystem::create_directory(folder_.File("taken.bin"));
  ExpectError([&] { WriteMotion(SmallMotion(), folder_.File("taken.bin")); }, ErrorKind::kIo,
              {"taken.bin: cannot be written"});
  int num_files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
    EXPECT_EQ(entry.path().filename(), "taken.bin");
    ++num_files;
  }
  EXPECT_EQ(num_files, 1);
}

TEST_F(MotionFile, ReportsFilesThatCannotBeRead) {
  ExpectError([&] { ReadMotionTensors(folder_.File("none.bin")); }, ErrorKind::kIo,
              {"none.bin: cannot be read: No such file"});
  ExpectError([&] { ReadMotionTensors(folder_.path()); }, ErrorKind::kIo, {"is not a regular file"});
}

}  // namespace
}  // namespace clothid::motion_file_test
