// Point caches byte by byte.
#include "datasets/formats/pc2_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::pc2_file_test {
namespace {

// A cache of 1 point and 2 samples as Blender writes it: (1, 2, 3) and (-0.5, 0.1, 0), from frame 1, every frame.
const std::string kCache(
    "POINTCACHE2\0"
    "\x01\x00\x00\x00"
    "\x01\x00\x00\x00"
    "\x00\x00\x80\x3f"
    "\x00\x00\x80\x3f"
    "\x02\x00\x00\x00"
    "\x00\x00\x80\x3f\x00\x00\x00\x40\x00\x00\x40\x40"
    "\x00\x00\x00\xbf\xcd\xcc\xcc\x3d\x00\x00\x00\x00",
    32 + 24);

class Pc2FileTest : public testing::Test {
 protected:
  PointTracks Read(const std::string& bytes) const { return ReadPc2(folder_.Write("cache.pc2", bytes)); }
  // The cache with other bytes at `offset`.
  void ExpectRefused(std::size_t offset, const std::string& bytes, const char* reason) const {
    std::string cache = kCache;
    cache.replace(offset, bytes.size(), bytes);
    ExpectError([&] { Read(cache); }, ErrorKind::kBadData, {"cache.pc2: ", reason});
  }

  TemporaryFolder folder_;
};

TEST_F(Pc2FileTest, ReadsTheBytesOfBlender) {
  const PointTracks tracks = Read(kCache);
  EXPECT_EQ(tracks.positions.col(0), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(tracks.positions.col(1), Eigen::Vector3d(-0.5, 0.1f, 0));
  EXPECT_EQ(tracks.times.size(), 0);
  EXPECT_EQ(tracks.faces.cols(), 0);
  EXPECT_EQ(tracks.sample_rate, 1.0);
}

TEST_F(Pc2FileTest, WritesTheSameBytesFromFrameZero) {
  std::string expected = kCache;
  expected.replace(20, 4, std::string(4, '\0'));
  EXPECT_EQ(Pc2Bytes(Read(kCache)), expected);
}

TEST_F(Pc2FileTest, RefusesWhatIsNoCache) {
  ExpectError([&] { Read("PC2"); }, ErrorKind::kBadData, {"cache.pc2: is not a PC2 file"});
  ExpectRefused(10, "3", "is not a PC2 file");
  ExpectRefused(12, "\x02", "expected PC2 version 1, found 2");
  ExpectRefused(16, "\xff\xff\xff\xff", "at least one point, found -1");
  ExpectRefused(16, std::string(4, '\0'), "at least one point, found 0");
  ExpectRefused(16, "\xff\xff\xff\x7f", "more than 4000000 points");
  ExpectRefused(16, "\x02", "expected 24 bytes of positions in each of 2 samples, found 24");
  ExpectRefused(28, "\xff\xff\xff\x7f", "more than 10000000 frames");
  ExpectRefused(28, "\x01", "expected 12 bytes of positions in each of 1 samples, found 24");
  ExpectRefused(28, std::string(4, '\0'), "at least one sample");
  ExpectRefused(20, std::string("\x00\x00\xc0\x7f", 4), "finite first frame");
  ExpectRefused(24, std::string("\x00\x00\x80\x7f", 4), "finite first frame and sample rate");
  ExpectRefused(36, std::string("\x00\x00\x80\x7f", 4), "frame 0, point 0: expected finite numbers, or NaN");
  for (std::size_t length = 0; length < kCache.size(); ++length) {
    ExpectError([&] { Read(kCache.substr(0, length)); }, ErrorKind::kBadData, {"cache.pc2: "});
  }
}

TEST_F(Pc2FileTest, KeepsNanAndRefusesWhatSinglePrecisionCannotHold) {
  PointTracks tracks = Read(kCache);
  tracks.positions(2, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(Read(Pc2Bytes(tracks)).positions(2, 0)));
  tracks.positions(2, 0) = -1e39;
  ExpectError([&] { Pc2Bytes(tracks); }, ErrorKind::kUsage, {"cache.pc2: -1e+39 is too large for PC2"});
}

}  // namespace
}  // namespace clothid::pc2_file_test
