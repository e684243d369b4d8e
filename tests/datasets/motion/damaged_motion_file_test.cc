// motion.bin: files that are damaged, cut off or made by something else are refused with what is wrong.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <utility>

#include "datasets/motion/motion_file.h"
#include "tests/datasets/motion/motion_file_fixture.h"

namespace clothid::damaged_motion_file_test {
namespace {

using namespace motion_file_fixture;
using DamagedMotionFileTest = MotionFile;

TEST_F(DamagedMotionFileTest, RejectsCloudsThatDoNotFitTogether) {
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

TEST_F(DamagedMotionFileTest, HeaderDigestIsOfTheHeaderWithBlanks) {
  const std::string bytes = Written(SmallMotion());
  std::uint64_t length = 0;
  std::memcpy(&length, bytes.data(), 8);
  std::string header = bytes.substr(8, length);
  const std::string digest = Json::parse(header)["__metadata__"]["header_sha256"];
  header.replace(header.find(digest), 64, std::string(64, ' '));
  EXPECT_EQ(Sha256Hex({header}), digest);
  EXPECT_EQ(Json::parse(header)["__metadata__"]["sha256"], Sha256Hex({bytes.substr(8 + length)}));
}

TEST_F(DamagedMotionFileTest, RejectsEveryTruncation) {
  const std::string bytes = Written(SmallMotion());
  for (std::size_t length = 0; length < bytes.size(); ++length) ExpectRejected(bytes.substr(0, length), {});
  ExpectRejected(bytes + '\0', {"bytes of tensors"});
}

TEST_F(DamagedMotionFileTest, RejectsEveryBitFlip) {
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

TEST_F(DamagedMotionFileTest, WithoutHeaderDigestABitFlipIsRejectedOrHarmless) {
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

TEST_F(DamagedMotionFileTest, RejectsOtherFormatsAndVersions) {
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

TEST_F(DamagedMotionFileTest, VerifiesItsChecksums) {
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

TEST_F(DamagedMotionFileTest, ReadsAHeaderDigestWrittenWithBlanksAroundIt) {
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

TEST_F(DamagedMotionFileTest, RejectsAnOversizedHeaderBeforeItAllocates) {
  std::string bytes = Raw().Bytes();
  for (const std::uint64_t length :
       {std::uint64_t{1} << 63, ~std::uint64_t{0}, std::uint64_t{1} << 40, bytes.size() - 7}) {
    std::memcpy(bytes.data(), &length, 8);
    ExpectRejected(bytes, {"its header claims", "expected at most"});
  }
  ExpectRejected("", {"shorter than the 8 bytes"});
  ExpectRejected(std::string(8, '\0'), {"not valid JSON"});
}

TEST_F(DamagedMotionFileTest, RejectsMoreThanItsLimits) {
  RawMotion raw = Raw();
  for (int i = 0; i < 1000; ++i) raw.header["__metadata__"][std::to_string(i)] = "";
  ExpectRejected(raw.Bytes(), {"key '__metadata__': expected at most 1000 keys"});
  const std::string sparse = folder_.Write("sparse.motion.bin", std::string(8, '\0'));
  std::filesystem::resize_file(sparse, (std::uint64_t{1} << 32) + 1);
  ExpectError([&] { ReadMotionTensors(sparse); }, ErrorKind::kBadData,
              {"sparse.motion.bin: is larger than 4294967296"});
}

TEST_F(DamagedMotionFileTest, RejectsWrongOffsets) {
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

TEST_F(DamagedMotionFileTest, RejectsWrongShapes) {
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

TEST_F(DamagedMotionFileTest, RejectsMissingUnknownAndMistypedTensors) {
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

TEST_F(DamagedMotionFileTest, RejectsUnusableNumbers) {
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

}  // namespace
}  // namespace clothid::damaged_motion_file_test
