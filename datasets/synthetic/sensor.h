// What a camera and a gripper make of a motion, as a laboratory brings it: frames at irregular times with gaps, noise
// that differs between directions, points that are missing, in another order or far off, frames of reference and clocks
// of their own. The opposite of `ImportMotion`.
#ifndef CLOTHID_DATASETS_SYNTHETIC_SENSOR_H_
#define CLOTHID_DATASETS_SYNTHETIC_SENSOR_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "datasets/formats/point_tracks.h"
#include "datasets/synthetic/force_sensor.h"
#include "sim/path/handle_path.h"

namespace clothid {

// No frame between `after` and `after + length`.
struct SensorGap {
  double after = 0.0;   // s, on the scene's clock
  double length = 0.0;  // s
};

struct Sensor {
  // The camera's.
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  // a point in the scene = pose * the point as it is seen
  double clock_offset = 0.0;                               // s, the camera's clock minus the scene's
  std::array<double, 2> interval = {0.1, 0.1};             // s, the least and the most between two frames; uniform
  std::vector<SensorGap> gaps;
  Eigen::Vector3d noise = Eigen::Vector3d::Zero();  // m, standard deviations along the camera's axes
  double drop_fraction = 0.0;                       // in [0, 1): the chance of a point to be missing in a frame
  double outlier_fraction = 0.0;                    // in [0, 1): the chance of a point to be far off
  double outlier_distance = 0.1;                    // m, the standard deviation of its coordinates then
  int num_flipped_frames = 0;                       // in which the rows of the grid come in reverse order
  // The gripper's, which knows the scene's frame of reference.
  double gripper_rate = 20.0;         // Hz
  double gripper_noise = 0.0;         // m, standard deviation of a coordinate
  double gripper_clock_offset = 0.0;  // s, its clock minus the scene's
  // That of the forces with which the gripper holds all handles. Absent: none.
  std::optional<ForceSensor> force_sensor;
  double force_clock_offset = 0.0;  // s, its clock minus the scene's
};

// The keys of a sensor.json are the members of `Sensor` (datasets/synthetic/README.md). Throws `Error` (kBadData),
// naming `source`, line and key.
Sensor ParseSensor(const std::string& text, const std::string& source);

// What moves: the points [3P] in the scene at a time (s, on its clock) from `start` to `end`. `grid` counts their rows
// and columns, point (i, j) being i + grid[0] j.
struct SeenMotion {
  double start = 0.0, end = 0.0;
  std::array<int, 2> grid{};
  std::function<Eigen::VectorXd(double time)> points_at;
};

// The points as the camera sees them, on its clock and in its frame of reference. The first frame is taken at the start
// and is whole. Times, noise, drops, outliers and flips have streams of random numbers of their own: the same seed with
// another fraction changes nothing else. Throws `Error` (kUsage) where there would be less than two frames, or no more
// frames than flipped ones.
PointTracks SeePoints(const Sensor& sensor, const SeenMotion& motion, std::uint64_t seed);

// The path of the handles as the gripper tells it, on its clock, from before `start` to after `end`.
PointTracks SeeHandles(const Sensor& sensor, const HandlePath& path, double start, double end, std::uint64_t seed);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_SYNTHETIC_SENSOR_H_
