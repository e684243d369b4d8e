#include "datasets/formats/npy_tracks.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <vector>

#include "datasets/files/file_group.h"
#include "datasets/formats/track_checks.h"
#include "sim/base/error.h"
#include "sim/base/npy_file.h"
#include "sim/mesh/mesh.h"

namespace clothid {
namespace {

namespace fs = std::filesystem;

fs::path Beside(const fs::path& path, const std::string& extension) {
  return fs::path(path).replace_extension(extension);
}

bool Exists(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

[[noreturn]] void FailOfShape(const fs::path& path, const std::string& expected, const std::vector<long long>& shape) {
  std::string found;
  for (const long long size : shape) found += (found.empty() ? "" : ", ") + std::to_string(size);
  throw Error(ErrorKind::kBadData,
              path.string() + ": expected an array of shape " + expected + ", found (" + found + ")");
}

Eigen::Matrix3Xi ReadFaces(const fs::path& path, int num_points) {
  const NpyIntegers array = ReadNpyIntegers(path.string());
  if (array.shape.size() != 2 || array.shape[1] != 3 || array.shape[0] > kMaxFaces) {
    FailOfShape(path, "(F, 3), F at most " + std::to_string(kMaxFaces), array.shape);
  }
  for (const long long index : array.values) {
    if (index >= 0 && index < num_points) continue;
    throw Error(ErrorKind::kBadData, path.string() + ": refers to point " + std::to_string(index) + "; expected 0 to " +
                                         std::to_string(num_points - 1));
  }
  Eigen::Matrix3Xi faces(3, array.shape[0]);
  std::copy(array.values.begin(), array.values.end(), faces.data());
  return faces;
}

}  // namespace

std::vector<std::string> NpyPaths(const std::string& path) {
  return {path, Beside(path, ".times.npy").string(), Beside(path, ".faces.npy").string()};
}

PointTracks ReadNpyTracks(const std::string& path) {
  const NpyArray array = ReadNpy(path);
  if (array.shape.size() != 3 || array.shape[2] != 3) FailOfShape(path, "(frames, points, 3)", array.shape);
  CheckTrackSize(path, static_cast<std::uint64_t>(array.shape[1]), static_cast<std::uint64_t>(array.shape[0]));
  PointTracks tracks;
  tracks.name = path;
  tracks.positions = Eigen::Map<const Eigen::MatrixXd>(array.values.data(), 3 * array.shape[1], array.shape[0]);
  const fs::path times = Beside(path, ".times.npy"), faces = Beside(path, ".faces.npy");
  if (Exists(times)) {
    tracks.times_name = times.string();
    tracks.times = ReadNpyTimes(tracks.times_name);
    if (tracks.times.size() != tracks.num_frames()) {
      FailOfShape(times, "(" + std::to_string(tracks.num_frames()) + "), a time per frame", {tracks.times.size()});
    }
  }
  if (Exists(faces)) tracks.faces = ReadFaces(faces, tracks.num_points());
  CheckTracks(tracks);
  return tracks;
}

Eigen::VectorXd ReadNpyTimes(const std::string& path) {
  const NpyArray array = ReadNpy(path);
  if (array.shape.size() != 1 || array.shape[0] < 1) FailOfShape(path, "(T), times", array.shape);
  const Eigen::Map<const Eigen::VectorXd> times(array.values.data(), static_cast<Eigen::Index>(array.shape[0]));
  CheckIncreasing(path, times);
  return times;
}

void WriteNpyTracks(const PointTracks& tracks, const std::string& path) {
  FileGroup group(path);
  const auto add_beside = [&](const std::string& extension, bool is_there, const auto& array) {
    const std::string name = Beside(path, extension).filename().string();
    if (is_there) {
      group.Write(name, NpyBytes(array));
    } else {
      group.Remove(name);
    }
  };
  const auto indices = tracks.faces.reshaped();
  const auto coordinates = tracks.positions.reshaped();
  add_beside(".times.npy", tracks.times.size() > 0,
             NpyArray{{tracks.times.size()}, {tracks.times.begin(), tracks.times.end()}});
  add_beside(".faces.npy", tracks.faces.cols() > 0,
             NpyIntegers{{tracks.faces.cols(), 3}, {indices.begin(), indices.end()}});
  group.Write(fs::path(path).filename().string(), NpyBytes(NpyArray{{tracks.num_frames(), tracks.num_points(), 3},
                                                                    {coordinates.begin(), coordinates.end()}}));
  group.Commit();
}

}  // namespace clothid
