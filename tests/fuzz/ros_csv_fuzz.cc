// CSV files of ROS recordings: grids of points, and poses.
#include "datasets/formats/ros_csv.h"
#include "tests/fuzz/fuzz_target.h"

int clothid::FuzzRosCsv(const std::uint8_t* data, std::size_t size) {
  static const MemoryFile file;
  file.Write(AsText(data, size));
  Accepts([&] { IsRosCsv(file.path()); }, file.path());
  PointTracks tracks;
  if (Accepts([&] { tracks = ReadRosGrid(file.path()); }, file.path())) {
    Check(tracks.times.size() == tracks.positions.cols() && tracks.num_points() > 0, "positions at every time");
    Check(!tracks.positions.array().isInf().any(), "no infinite coordinate");
  }
  PoseTrack poses;
  if (Accepts([&] { poses = ReadRosPoses(file.path()); }, file.path())) {
    Check(poses.positions.allFinite() && poses.rotations.allFinite(), "poses of finite numbers");
  }
  return 0;
}
