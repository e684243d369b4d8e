#include "datasets/formats/pc2_file.h"

#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "datasets/formats/track_checks.h"
#include "sim/base/byte_order.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr std::string_view kMagic("POINTCACHE2\0", 12);
constexpr std::int32_t kVersion = 1;

}  // namespace

PointTracks ReadPc2(const std::string& path) {
  PointTracks tracks;
  tracks.name = path;
  PointCache cache =
      ReadPointCache(path, [&](std::uint64_t points, std::uint64_t samples) { CheckTrackSize(path, points, samples); });
  tracks.positions = std::move(cache.positions);
  tracks.sample_rate = cache.frames_per_sample;
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
