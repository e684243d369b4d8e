#include "datasets/motion/motion_file.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <random>
#include <utility>

#include "datasets/files/sha256.h"
#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::motion_file_test {
namespace {

using Json = nlohmann::ordered_json;

constexpr ErrorKind kBadData = ErrorKind::kBadData;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Four frames of a cloth of 3 x 3 nodes that drifts, held at two nodes, with one point missing in the second frame.
MotionTensors SmallMotion() {
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

bool SameNumbers(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         ((a.array() == b.array()) || (a.array().isNaN() && b.array().isNaN())).all();
}

void ExpectSame(const MotionTensors& a, const MotionTensors& b) {
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

std::string ReadAll(const std::string& path) {
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

TEST_F(MotionFile, KindsOfPointsBecomePartOfARecording) {
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

// Beside the tracked points; the second frame has no cloud.
void AddClouds(MotionTensors* tensors) {
  std::srand(3);
  for (const int count : {5, 0, 3, 7}) tensors->clouds.push_back(Eigen::Matrix3Xd::Random(3, count));
  tensors->cloud_sigma = 0.002;
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

TEST_F(MotionFile, CloudsBecomePartOfARecording) {
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

TEST_F(MotionFile, RejectsCloudsThatDoNotFitTogether) {
  MotionTensors tensors = SmallMotion();
  AddClouds(&tensors);
  const RawMotion good(Written(tensors));
  for (const auto& [index, value] : {std::pair<std::size_t, int>{0, 1}, {2, 4}, {4, 14}, {4, 16}, {1, -1}}) {
    RawMotion raw = good;
    raw.Set<std::int32_t>("cloud_offsets", index, value);
    ExpectRejected(raw.Bytes(), {"cloud_offsets", "15 points"});
  }
  RawMotion raw = good;
  raw.Set<float>("cloud_positions", 4, std::numeric_limits<float>::quiet_NaN());
  ExpectRejected(raw.Bytes(), {"cloud_positions", "frame 0"});
  for (const double sigma : {0.0, -1.0, kNaN}) {
    raw = good;
    raw.Set<double>("cloud_sigma", 0, sigma);
    ExpectRejected(raw.Bytes(), {"cloud_sigma"});
  }
  raw = good;
  raw.header["cloud_offsets"]["shape"] = {5, 1};
  ExpectRejected(raw.Bytes(), {"cloud_offsets", "expected shape [5]"});
  raw = good;
  raw.header["cloud_positions"]["shape"] = {3, 15};
  ExpectRejected(raw.Bytes(), {"cloud_positions", "expected shape [any, 3]"});
  raw = good;
  raw.header["cloud_positions"]["dtype"] = "I32";
  ExpectRejected(raw.Bytes(), {"cloud_positions", "expected dtype F32"});
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

TEST_F(MotionFile, HeaderDigestIsOfTheHeaderWithBlanks) {
  const std::string bytes = Written(SmallMotion());
  std::uint64_t length = 0;
  std::memcpy(&length, bytes.data(), 8);
  std::string header = bytes.substr(8, length);
  const std::string digest = Json::parse(header)["__metadata__"]["header_sha256"];
  header.replace(header.find(digest), 64, std::string(64, ' '));
  EXPECT_EQ(Sha256Hex({header}), digest);
  EXPECT_EQ(Json::parse(header)["__metadata__"]["sha256"], Sha256Hex({bytes.substr(8 + length)}));
}

TEST_F(MotionFile, RejectsEveryTruncation) {
  const std::string bytes = Written(SmallMotion());
  for (std::size_t length = 0; length < bytes.size(); ++length) ExpectRejected(bytes.substr(0, length), {});
  ExpectRejected(bytes + '\0', {"bytes of tensors"});
}

TEST_F(MotionFile, RejectsEveryBitFlip) {
  const std::string bytes = Written(SmallMotion());
  std::uint64_t header_length = 0;
  std::memcpy(&header_length, bytes.data(), 8);
  for (std::size_t i = 0; i < bytes.size(); i += i < 8 + header_length ? 1 : 7) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string flipped = bytes;
      flipped[i] = static_cast<char>(flipped[i] ^ (1 << bit));
      ExpectRejected(flipped, {});
    }
  }
}

TEST_F(MotionFile, WithoutHeaderDigestABitFlipIsRejectedOrHarmless) {
  RawMotion raw = Raw();
  raw.header["__metadata__"].erase("scene");
  raw.header["__metadata__"].erase("provenance");
  raw.header["__metadata__"]["scene"] = "";
  const std::string bytes = raw.Bytes();
  folder_.Write("cloth.motion.bin", bytes);
  const MotionTensors original = ReadMotionTensors(Path());
  int num_read = 0;
  for (std::size_t i = 0; i < bytes.size() - raw.data.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string flipped = bytes;
      flipped[i] = static_cast<char>(flipped[i] ^ (1 << bit));
      folder_.Write("cloth.motion.bin", flipped);
      try {
        ExpectSame(ReadMotionTensors(Path()), original);
        ++num_read;
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), kBadData) << error.what();
        EXPECT_NE(std::string(error.what()).find("cloth.motion.bin: "), std::string::npos) << error.what();
      }
    }
  }
  EXPECT_EQ(num_read, 0);
}

TEST_F(MotionFile, RejectsOtherFormatsAndVersions) {
  RawMotion raw = Raw();
  raw.header["__metadata__"]["version"] = "2";
  ExpectRejected(raw.Bytes(), {"version': expected '1', found '2'"});
  raw.header["__metadata__"]["version"] = 1;
  ExpectRejected(raw.Bytes(), {"key '__metadata__.version': expected a string"});
  raw.header["__metadata__"].erase("version");
  ExpectRejected(raw.Bytes(), {"version': is missing"});
  raw = Raw();
  raw.header["__metadata__"]["format"] = "pt";
  ExpectRejected(raw.Bytes(), {"format': expected 'clothid.motion', found 'pt'"});
  raw.header.erase("__metadata__");
  ExpectRejected(raw.Bytes(false), {"format': is missing"});
  raw = Raw();
  raw.header["__metadata__"].erase("scene");
  ExpectRejected(raw.Bytes(), {"scene': is missing"});
  raw = Raw();
  raw.header["__metadata__"]["author"] = "x";
  ExpectRejected(raw.Bytes(), {"unknown key '__metadata__.author'"});
}

TEST_F(MotionFile, VerifiesItsChecksums) {
  RawMotion raw = Raw();
  raw.data.back() = static_cast<char>(raw.data.back() ^ 1);
  ExpectRejected(raw.Bytes(false), {"sha256': does not match the tensors"});
  raw.header["__metadata__"].erase("sha256");
  ExpectRejected(raw.Bytes(false), {"sha256': is missing"});
  raw = Raw();
  folder_.Write("cloth.motion.bin", raw.Bytes());
  EXPECT_NO_THROW(ReadMotionTensors(Path()));
  raw.header["__metadata__"]["header_sha256"] = std::string(64, '0');
  ExpectRejected(raw.Bytes(), {"header_sha256': does not match the header"});
}

TEST_F(MotionFile, ReadsAHeaderDigestWrittenWithBlanksAroundIt) {
  RawMotion raw = Raw();
  raw.header["__metadata__"]["sha256"] = Sha256Hex({raw.data});
  raw.header["__metadata__"]["header_sha256"] = std::string(64, ' ');
  std::string text = raw.header.dump(2);
  text.replace(text.find(std::string(64, ' ')), 64, Sha256Hex({text}));
  const std::uint64_t length = text.size();
  std::string bytes(8, '\0');
  std::memcpy(bytes.data(), &length, 8);
  folder_.Write("cloth.motion.bin", bytes + text + raw.data);
  EXPECT_NO_THROW(ReadMotionTensors(Path()));
}

TEST_F(MotionFile, RejectsAnOversizedHeaderBeforeItAllocates) {
  std::string bytes = Raw().Bytes();
  for (const std::uint64_t length :
       {std::uint64_t{1} << 63, ~std::uint64_t{0}, std::uint64_t{1} << 40, bytes.size() - 7}) {
    std::memcpy(bytes.data(), &length, 8);
    ExpectRejected(bytes, {"its header claims", "expected at most"});
  }
  ExpectRejected("", {"shorter than the 8 bytes"});
  ExpectRejected(std::string(8, '\0'), {"not valid JSON"});
}

TEST_F(MotionFile, RejectsMoreThanItsLimits) {
  RawMotion raw = Raw();
  for (int i = 0; i < 1000; ++i) raw.header["__metadata__"][std::to_string(i)] = "";
  ExpectRejected(raw.Bytes(), {"key '__metadata__': expected at most 1000 keys"});
  const std::string sparse = folder_.Write("sparse.motion.bin", std::string(8, '\0'));
  std::filesystem::resize_file(sparse, (std::uint64_t{1} << 32) + 1);
  ExpectError([&] { ReadMotionTensors(sparse); }, ErrorKind::kBadData,
              {"sparse.motion.bin: is larger than 4294967296"});
}

TEST_F(MotionFile, RejectsWrongOffsets) {
  const RawMotion raw = Raw();
  const auto expect = [&](const Json& offsets, std::initializer_list<const char*> fragments) {
    RawMotion wrong = raw;
    wrong.header["faces"]["data_offsets"] = offsets;
    ExpectRejected(wrong.Bytes(), fragments);
  };
  const std::size_t begin = raw.header["faces"]["data_offsets"][0], end = raw.header["faces"]["data_offsets"][1];
  expect({begin - 4, end - 4}, {"tensor 'faces'", "expected its data to begin"});
  expect({begin + 4, end + 4}, {"expected its data to begin"});
  expect({0, end - begin}, {"expected its data to begin"});
  expect({begin, end - 4}, {"key 'faces.data_offsets': expected a range of the 96 bytes"});
  expect({end, begin}, {"key 'faces.data_offsets': expected a range"});
  expect({begin, 1000000000}, {"key 'faces.data_offsets[1]': expected an integer from 0"});
  expect({-4, begin}, {"key 'faces.data_offsets[0]': expected an integer from 0"});
  expect({begin}, {"key 'faces.data_offsets': expected [begin, end]"});
  expect("x", {"key 'faces.data_offsets': expected an array"});
}

TEST_F(MotionFile, RejectsWrongShapes) {
  const RawMotion raw = Raw();
  const auto expect = [&](const char* tensor, const Json& shape, std::initializer_list<const char*> fragments) {
    RawMotion wrong = raw;
    wrong.header[tensor]["shape"] = shape;
    ExpectRejected(wrong.Bytes(), fragments);
  };
  const long long huge = 1LL << 62;
  expect("positions", {huge, huge, huge}, {"key 'positions.shape': its elements take more than"});
  expect("positions", {huge, 4, 3}, {"key 'positions.shape': its elements take more than"});
  expect("positions", {-4, -9, 3}, {"key 'positions.shape[0]': expected an integer from 0"});
  expect("positions", {4.5, 9, 3}, {"key 'positions.shape[0]': expected an integer"});
  expect("positions", {9, 4, 3}, {"tensor 'positions': expected shape [4, any, 3], found [9, 4, 3]"});
  expect("positions", {4, 27}, {"tensor 'positions': expected shape"});
  expect("faces", {8, 4}, {"key 'faces.data_offsets': expected a range of the 128 bytes"});
  expect("faces", {0, huge, 3}, {"key 'faces.data_offsets'"});
}

TEST_F(MotionFile, RejectsMissingUnknownAndMistypedTensors) {
  RawMotion raw = Raw();
  raw.header["velocities"] = {{"dtype", "F64"}, {"shape", {0}}, {"data_offsets", {raw.data.size(), raw.data.size()}}};
  ExpectRejected(raw.Bytes(), {"unknown tensor 'velocities'"});
  raw = Raw();
  raw.header["times"]["dtype"] = "F16";
  ExpectRejected(raw.Bytes(), {"key 'times.dtype': expected F32, F64 or I32, found F16"});
  raw = Raw();
  raw.header["faces"]["dtype"] = "F32";
  ExpectRejected(raw.Bytes(), {"tensor 'faces': expected dtype I32, found F32"});
  raw = Raw();
  const Json sigma = raw.header["sigma"];
  raw.header.erase("sigma");
  raw.header["node_index"] = sigma;
  ExpectRejected(raw.Bytes(), {"tensor 'node_index': expected dtype I32, found F64"});
  raw.header.erase("node_index");
  raw.header["barycentric"] = sigma;
  ExpectRejected(raw.Bytes(), {"tensor 'barycentric': expected shape [9, 3], found [9]"});
  raw = Raw();
  raw.header["times"]["extra"] = 1;
  ExpectRejected(raw.Bytes(), {"key 'times.extra': unknown key"});
}

TEST_F(MotionFile, RejectsUnusableNumbers) {
  const RawMotion raw = Raw();
  const auto expect = [&](const char* tensor, std::size_t index, auto value,
                          std::initializer_list<const char*> fragments) {
    RawMotion wrong = raw;
    wrong.Set(tensor, index, value);
    ExpectRejected(wrong.Bytes(), fragments);
  };
  expect("times", 1, kNaN, {"tensor 'times': entry 1 is not finite"});
  expect("times", 2, 1.1, {"tensor 'times': entry 2 is not above"});
  expect("faces", 4, std::int32_t{9}, {"triangle 1 refers to node 9; expected 0 to 8"});
  expect("faces", 4, std::int32_t{-1}, {"triangle 1 refers to node -1"});
  expect("rest_positions", 7, kNaN, {"rest position of node 2 is not finite"});
  expect("positions", 30, HUGE_VALF, {"tensor 'positions': frame 1 holds an infinite"});
  expect("handle_positions", 8, kNaN, {"tensor 'handle_positions': frame 1 is not finite"});
  expect("handle_index", 1, std::int32_t{9}, {"tensor 'handle_index': entry 1 is 9; expected 0 to 8"});
  expect("handle_index", 1, std::int32_t{0}, {"tensor 'handle_index': node 0 is listed twice"});
  expect("sigma", 3, 0.0, {"tensor 'sigma': entry 3 is not a number > 0"});
  expect("sigma", 3, kNaN, {"tensor 'sigma': entry 3 is not a number > 0"});
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

// ---- ReadMotion

TEST_F(MotionFile, BecomesARecording) {
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

TEST_F(MotionFile, CompletesAGapInTheFirstFrame) {
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

TEST_F(MotionFile, PlacesTheRestShapeUnderMarkers) {
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
TEST_F(MotionFile, HandlesMayHaveTimesOfTheirOwn) {
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

TEST_F(MotionFile, SmoothsHandlePathsOnRequest) {
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
TEST_F(MotionFile, EstimatesSigmaAndSmoothsTheStartOnRequest) {
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

TEST_F(MotionFile, TakesAnotherSceneOnRequest) {
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

TEST_F(MotionFile, NamesTheLineOfItsScene) {
  MotionTensors tensors = SmallMotion();
  tensors.scene_text = "{\"clothid_scene\": 1,\n\n \"gravty\": 0}";
  ExpectError([&] { Read(tensors); }, kBadData, {"cloth.motion.bin: scene:3: key 'gravty': unknown key"});
}

}  // namespace
}  // namespace clothid::motion_file_test
