#include "datasets/formats/pc2_file.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>

#include "datasets/formats/track_checks.h"
#include "sim/base/byte_order.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr std::string_view kMagic("POINTCACHE2\0", 12);
constexpr std::size_t kHeaderSize = 32;  // bytes
constexpr std::int32_t kVersion = 1;

// Where the fields of the header stand.
enum Offset : std::size_t { kVersionAt = 12, kPointsAt = 16, kStartAt = 20, kRateAt = 24, kSamplesAt = 28 };

std::uint64_t Count(const std::string& path, std::int32_t count, const std::string& what) {
  if (count < 1) FailOnData(path, "expected at least one " + what + ", found " + std::to_string(count));
  return static_cast<std::uint64_t>(count);
}

}  // namespace

PointTracks ReadPc2(const std::string& path) {
  const std::string bytes = ReadFile(path, kMaxPc2Bytes);
  if (bytes.compare(0, kMagic.size(), kMagic) != 0) FailOnData(path, "is not a PC2 file: expected POINTCACHE2");
  if (bytes.size() < kHeaderSize) FailOnData(path, "ends within its header");
  const auto integer = [&](Offset at) { return LoadNumber<std::int32_t>(bytes.data() + at, ByteOrder::kLittle); };
  const auto real = [&](Offset at) { return LoadNumber<float>(bytes.data() + at, ByteOrder::kLittle); };
  if (integer(kVersionAt) != kVersion) {
    FailOnData(path, "expected PC2 version 1, found " + std::to_string(integer(kVersionAt)));
  }
  const std::uint64_t num_points = Count(path, integer(kPointsAt), "point");
  const std::uint64_t num_samples = Count(path, integer(kSamplesAt), "sample");
  if (!std::isfinite(real(kStartAt)) || !std::isfinite(real(kRateAt))) {
    FailOnData(path, "expected a finite first frame and sample rate");
  }
  CheckTrackSize(path, num_points, num_samples);
  const std::uint64_t expected = num_points * num_samples * 3 * sizeof(float);
  if (bytes.size() - kHeaderSize != expected) {
    FailOnData(path, "expected " + std::to_string(expected) + " bytes of positions, found " +
                         std::to_string(bytes.size() - kHeaderSize));
  }
  PointTracks tracks;
  tracks.name = path;
  tracks.positions.resize(3 * static_cast<Eigen::Index>(num_points), static_cast<Eigen::Index>(num_samples));
  const char* next = bytes.data() + kHeaderSize;
  for (double& value : tracks.positions.reshaped()) {
    value = LoadNumber<float>(next, ByteOrder::kLittle);
    next += sizeof(float);
  }
  CheckTracks(tracks);
  return tracks;
}

std::string Pc2Bytes(const PointTracks& tracks) {
  std::string bytes(kMagic);
  AppendLittleEndian(kVersion, &bytes);
  AppendLittleEndian(static_cast<std::int32_t>(tracks.num_points()), &bytes);
  AppendLittleEndian(0.0f, &bytes);  // first frame
  AppendLittleEndian(1.0f, &bytes);  // frames per sample
  AppendLittleEndian(static_cast<std::int32_t>(tracks.num_frames()), &bytes);
  for (const double value : tracks.positions.reshaped()) {
    if (std::abs(value) > std::numeric_limits<float>::max()) {
      throw Error(ErrorKind::kUsage, tracks.name + ": " + ShortestText(value) + " is too large for PC2");
    }
    AppendLittleEndian(static_cast<float>(value), &bytes);
  }
  return bytes;
}

}  // namespace clothid
