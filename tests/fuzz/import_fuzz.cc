// The small files that an import is told about: the first byte chooses a transform, times of frames, a map of points or
// paths of handles with the places where a tool holds them; an F, forces at handles.
#include "datasets/importing/clock_times.h"
#include "datasets/importing/force_file.h"
#include "datasets/importing/handle_tracks.h"
#include "datasets/importing/point_map.h"
#include "datasets/importing/transform_file.h"
#include "tests/fuzz/fuzz_target.h"

namespace clothid {
namespace {

constexpr int kNumKinds = 5;

void FuzzTransform(const std::string& path) {
  Eigen::Isometry3d transform;
  if (!Accepts([&] { transform = ReadTransform(path); }, path)) return;
  Check(transform.linear().isUnitary(1e-9), "a rigid transform");
}

void FuzzTimes(const std::string& path) {
  Eigen::VectorXd times;
  if (Accepts([&] { times = ReadTimes(path); }, path)) Check(times.allFinite(), "finite times");
}

void FuzzMap(const std::string& path, bool labelled) {
  static const Mesh mesh = MakePointGrid({3, 3}, {1.0, 1.0}, false);
  PointTracks tracks;
  tracks.name = "tracks";
  tracks.positions.resize(12, 1);
  if (labelled) tracks.labels = {"a", "b", "c", "d"};
  PointMap map;
  if (!Accepts([&] { map = ReadPointMap(path, tracks, mesh); }, path)) return;
  Check(map.node_index.size() + map.face_index.size() == map.points.size(), "a place for every point");
  for (const int point : map.points) Check(point >= 0 && point < 4, "points of the tracks");
}

void FuzzOffsets(const std::string& path) {
  static const MemoryFile poses;
  poses.Write(
      "%time,position.x,position.y,position.z,orientation.x,orientation.y,orientation.z,orientation.w\n"
      "0,0,0,0,0,0,0,1\n1000000000,1,1,1,0,0,1,0\n");
  HandleFile file;
  file.path = poses.path();
  file.offsets_path = path;
  const auto read = [&] { ReadHandlePath(file, {0, 7}, Eigen::Vector2d(0.1, 0.9), 0.0); };
  Accepts(read, "/proc/self/fd/");  // numbers beyond all bounds overflow in the path, which is the other file's
}

void FuzzForces(const std::string& path) {
  ForceFile file;
  file.path = path;
  file.groups = {{0, 1}, {7}};
  file.sigma = 0.1;
  ForceReadings forces;
  const Eigen::Vector3d frames(0.0, 1.0, 2.0);
  if (!Accepts([&] { forces = ReadForces(file, frames, 0.0); }, path)) return;
  Check(forces.values.rows() == 6 && forces.values.cols() == forces.times.size(), "forces of two groups");
  Check(!forces.values.array().isInf().any(), "forces that are finite or not there");
  Check(forces.times.minCoeff() >= 0.0 && forces.times.maxCoeff() <= 2.0, "readings between the frames");
}

}  // namespace
}  // namespace clothid

int clothid::FuzzImport(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  static const MemoryFile file;
  file.Write(AsText(data + 1, size - 1));
  if (data[0] == 'F') {
    FuzzForces(file.path());
    return 0;
  }
  const int kind = data[0] % kNumKinds;
  if (kind == 0) FuzzTransform(file.path());
  if (kind == 1) FuzzTimes(file.path());
  if (kind == 2 || kind == 3) FuzzMap(file.path(), kind == 3);
  if (kind == 4) FuzzOffsets(file.path());
  return 0;
}
