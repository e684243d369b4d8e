#include "sim/mesh/point_cache.h"

#include <cmath>
#include <string_view>

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

[[noreturn]] void FailOnCache(const std::string& path, const std::string& message) {
  throw Error(ErrorKind::kBadData, path + ": " + message);
}

std::uint64_t Count(const std::string& path, std::int32_t count, const std::string& what) {
  if (count < 1) FailOnCache(path, "expected at least one " + what + ", found " + std::to_string(count));
  return static_cast<std::uint64_t>(count);
}

}  // namespace

PointCache ReadPointCache(const std::string& path,
                          const std::function<void(std::uint64_t points, std::uint64_t samples)>& check_size) {
  const std::string bytes = ReadFile(path, kMaxPc2Bytes);
  if (bytes.compare(0, kMagic.size(), kMagic) != 0) FailOnCache(path, "is not a PC2 file: expected POINTCACHE2");
  if (bytes.size() < kHeaderSize) FailOnCache(path, "ends within its header");
  const auto integer = [&](Offset at) { return LoadNumber<std::int32_t>(bytes.data() + at, ByteOrder::kLittle); };
  const auto real = [&](Offset at) { return LoadNumber<float>(bytes.data() + at, ByteOrder::kLittle); };
  if (integer(kVersionAt) != kVersion) {
    FailOnCache(path, "expected PC2 version 1, found " + std::to_string(integer(kVersionAt)));
  }
  const std::uint64_t num_points = Count(path, integer(kPointsAt), "point");
  const std::uint64_t num_samples = Count(path, integer(kSamplesAt), "sample");
  PointCache cache;
  cache.first_frame = real(kStartAt);
  cache.frames_per_sample = real(kRateAt);
  if (!std::isfinite(cache.first_frame) || !std::isfinite(cache.frames_per_sample)) {
    FailOnCache(path, "expected a finite first frame and sample rate");
  }
  if (check_size) check_size(num_points, num_samples);
  const std::uint64_t found = bytes.size() - kHeaderSize, point_bytes = num_points * 3 * sizeof(float);
  if (found / point_bytes != num_samples || found % point_bytes != 0) {
    FailOnCache(path, "expected " + std::to_string(point_bytes) + " bytes of positions in each of " +
                          std::to_string(num_samples) + " samples, found " + std::to_string(found));
  }
  cache.positions.resize(3 * static_cast<Eigen::Index>(num_points), static_cast<Eigen::Index>(num_samples));
  const char* next = bytes.data() + kHeaderSize;
  for (double& value : cache.positions.reshaped()) {
    value = LoadNumber<float>(next, ByteOrder::kLittle);
    next += sizeof(float);
  }
  return cache;
}

}  // namespace clothid
