// `motion` as a program: a good recording passes, and nothing that is wrong with a file goes unnoticed.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/tools/tool_test.h"

namespace clothid::motion_test {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kLengthBytes = 8;  // a motion file starts with the length of its header

std::uint64_t HeaderLength(const std::string& bytes) {
  std::uint64_t length = 0;
  std::memcpy(&length, bytes.data(), sizeof(length));
  return length;
}

std::string WithHeaderLength(std::string bytes, std::uint64_t length) {
  std::memcpy(bytes.data(), &length, sizeof(length));
  return bytes;
}

Json Header(const std::string& bytes) { return Json::parse(bytes.substr(kLengthBytes, HeaderLength(bytes))); }

// The file with another header, which carries no checksum of itself.
std::string WithHeader(const std::string& bytes, Json header) {
  header["__metadata__"].erase("header_sha256");
  std::string text = header.dump();
  text.resize((text.size() + 7) / 8 * 8, ' ');  // tensors stay aligned
  return WithHeaderLength(bytes.substr(0, kLengthBytes) + text + bytes.substr(kLengthBytes + HeaderLength(bytes)),
                          text.size());
}

class MotionTest : public ToolTest {
 protected:
  MotionTest() {
    ExpectSuccess("simulate --scene " + WriteScene(SphereJson()) + " --output good.bin --noise 0.001 --drop 0.1");
    good_ = ReadBytes(folder() / "good.bin");
  }

  void ExpectBad(const std::string& bytes, const std::string& culprit = "bad.bin") const {
    WriteBytes(folder() / "bad.bin", bytes);
    ExpectRefused("motion check bad.bin", 2, culprit);
  }

  std::string good_;
};

TEST_F(MotionTest, InfoNamesWhatIsInside) {
  const ToolResult result = Run("motion info good.bin");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  for (const char* part : {"positions F64 [6, 16, 3]", "faces I32 [18, 3]", "sigma F64 [16]", "frames 6", "100 Hz",
                           "points 16", "handles 4", "ball", "k_stretch 100", "synthetic: noise 0.001 m", "sha256"}) {
    EXPECT_NE(result.out.find(part), std::string::npos) << part << "\n" << result.out;
  }
}

TEST_F(MotionTest, ConvertMarksPointsThatAreNotMaterial) {
  ExpectSuccess("motion convert good.bin slid.bin --as_surface --borders --corners");
  const ToolResult info = Run("motion info slid.bin");
  EXPECT_EQ(info.exit_code, 0) << info.err;
  for (const char* part : {"point_kind I32 [16]", "--as_surface --borders --corners"}) {
    EXPECT_NE(info.out.find(part), std::string::npos) << part << "\n" << info.out;
  }
  ExpectRefused("motion convert good.bin slid.bin --borders", 1, "--borders: expected with --as_surface");
  ExpectRefused("motion convert good.bin slid.csv --as_surface", 1, "--as_surface: expected with a motion.bin");
}

TEST_F(MotionTest, CheckAcceptsAGoodFile) {
  const ToolResult result = Run("motion check good.bin");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("valid"), std::string::npos);
  EXPECT_NE(result.out.find("gaps 0"), std::string::npos) << result.out;
}

// A recording comes from anywhere, and its text is not to act on the terminal.
TEST_F(MotionTest, InfoEscapesControlCharacters) {
  Json header = Header(good_);
  header["__metadata__"]["provenance"] =
      "\x1b]0;title\x07\nred \xc2\x9b"
      "31m";
  WriteBytes(folder() / "bad.bin", WithHeader(good_, header));
  const ToolResult result = Run("motion info bad.bin");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("\nprovenance \\x1b]0;title\\x07\\nred \\x9b31m\n"), std::string::npos) << result.out;
}

TEST_F(MotionTest, NamesOtherKindsOfFiles) {
  ExpectBad("\x1f\x8b" + std::string(200, 'x'), "bad.bin: is packed with gzip; expected a recording, motion.bin");
  ExpectBad(std::string("\x1f\x8b\x08\0\0\0\0\0", 8) + std::string(600000, 'x'), "is packed with gzip");
  ExpectBad(SphereJson().dump(), "bad.bin: is JSON text");
  ExpectBad("t,id,x,y,z\n0,0,1,2,3\n", "bad.bin: is text");
}

TEST_F(MotionTest, RefusesWrongCommands) {
  ExpectRefused("motion", 1, "command");
  ExpectRefused("motion inspect good.bin", 1, "'inspect'");
  ExpectRefused("motion check", 1, "file");
  ExpectRefused("motion check good.bin good.bin", 1, "one file");
  ExpectRefused("motion check absent.bin", 1, "absent.bin");
  ExpectRefused("motion info .", 1, ".");
  ExpectRefused("motion check good.bin --bogus", 1, "bogus");
  ExpectRefused("motion info good.bin --json", 1, "--json: is a flag of check and friction, not of info");
  ExpectRefused("motion check good.bin --voxel 0.1", 1, "--voxel: is a flag of convert_clouds, not of check");
  ExpectRefused("motion check good.bin --scale 1", 1, "--scale: is a flag of convert and convert_clouds, not of check");
  ExpectRefused("motion convert good.bin out.bin --json", 1, "--json: is a flag of check and friction, not of convert");
  ExpectRefused("motion convert good.bin out.bin --fit_pose", 1, "--fit_pose: is a flag of convert_clouds");
  ExpectRefused("motion convert_clouds clouds out.bin --json", 1,
                "--json: is a flag of check and friction, not of convert_clouds");
  ExpectRefused("motion convert_clouds clouds out.bin --frames 0:2", 1, "--frames: is a flag of convert, not of");
}

TEST_F(MotionTest, RefusesTruncatedFiles) {
  const size_t header_end = kLengthBytes + HeaderLength(good_);
  for (const size_t length : {size_t{0}, size_t{3}, kLengthBytes, kLengthBytes + 20, header_end - 1, header_end,
                              (header_end + good_.size()) / 2, good_.size() - 1}) {
    SCOPED_TRACE(length);
    ExpectBad(good_.substr(0, length));
  }
  ExpectBad(good_ + '\0');
}

// A flipped bit anywhere is noticed: in the length, in the header, in a tensor.
TEST_F(MotionTest, RefusesFlippedBits) {
  constexpr size_t kNumPlaces = 40;
  const size_t header_end = kLengthBytes + HeaderLength(good_);
  for (size_t i = 0; i < kNumPlaces; ++i) {
    const size_t in_header = i * (header_end - 1) / (kNumPlaces - 1);
    const size_t in_tensors = header_end + i * (good_.size() - 1 - header_end) / (kNumPlaces - 1);
    for (const size_t place : {in_header, in_tensors}) {
      SCOPED_TRACE(place);
      std::string bytes = good_;
      bytes[place] = static_cast<char>(bytes[place] ^ (1 << i % 8));
      ExpectBad(bytes);
    }
  }
}

// Lengths that would overflow an addition, or ask for memory that the file does not have.
TEST_F(MotionTest, RefusesOversizedHeaders) {
  for (const std::uint64_t length : {~std::uint64_t{0}, ~std::uint64_t{0} - 7, std::uint64_t{1} << 63,
                                     std::uint64_t{1} << 40, std::uint64_t{good_.size()}}) {
    SCOPED_TRACE(length);
    ExpectBad(WithHeaderLength(good_, length), "header");
  }
}

TEST_F(MotionTest, RefusesOtherVersionsAndFormats) {
  WriteBytes(folder() / "same.bin", WithHeader(good_, Header(good_)));
  ExpectSuccess("motion check same.bin");
  Json header = Header(good_);
  header["__metadata__"]["version"] = "2";
  ExpectBad(WithHeader(good_, header), "version");
  header = Header(good_);
  header["__metadata__"]["format"] = "clothid.scene";
  ExpectBad(WithHeader(good_, header), "format");
}

TEST_F(MotionTest, RefusesHeadersThatDoNotFitTheirTensors) {
  Json header = Header(good_);
  header["positions"]["shape"][0] = 1000000000;
  ExpectBad(WithHeader(good_, header), "positions");
  header = Header(good_);
  header["positions"]["shape"] = {-6, 16, 3};
  ExpectBad(WithHeader(good_, header), "positions");
  header = Header(good_);
  header["faces"]["dtype"] = "F32";
  ExpectBad(WithHeader(good_, header), "faces");
  header = Header(good_);
  header["times"]["data_offsets"] = {0, 1000000};
  ExpectBad(WithHeader(good_, header), "times");
  header = Header(good_);
  header["rest_places"] = header["rest_positions"];
  header.erase("rest_positions");
  ExpectBad(WithHeader(good_, header), "rest_p");
}

TEST_F(MotionTest, RefusesUnusableScenesInside) {
  Json header = Header(good_);
  header["__metadata__"]["scene"] = R"({"clothid_scene": 1, "handles": [99]})";
  ExpectBad(WithHeader(good_, header), "handles");
  header["__metadata__"]["scene"] = R"({"clothid_scene": 1, "handels": [0]})";
  ExpectBad(WithHeader(good_, header), "handels");
  header["__metadata__"]["scene"] = "not json";
  ExpectBad(WithHeader(good_, header), "scene");
}

}  // namespace
}  // namespace clothid::motion_test
