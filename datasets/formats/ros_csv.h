// Tables (sim/base/table.h) of ROS recordings, as `rostopic echo -p` prints them: a header that starts with "%time",
// then one row per message. Times are integers in ns; a message's own stamp (`field.header.stamp`) is taken before the
// time at which it was printed (`%time`). In seconds since 1970 a double resolves 0.24 us.
#ifndef CLOTHID_DATASETS_FORMATS_ROS_CSV_H_
#define CLOTHID_DATASETS_FORMATS_ROS_CSV_H_

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "datasets/formats/point_tracks.h"

namespace clothid {

inline constexpr std::uint64_t kMaxRosCsvBytes = std::uint64_t{1} << 30;
inline constexpr long long kMaxRosGridSide = 2000;  // points

// Poses of a rigid body over time.
struct PoseTrack {
  std::string name;            // for messages: the file that it came from
  std::vector<int> lines;      // [T] of the file
  Eigen::VectorXd times;       // [T] s
  Eigen::Matrix3Xd positions;  // [3 x T] in the file's own unit
  Eigen::Matrix4Xd rotations;  // [4 x T] unit quaternions x, y, z, w: from the body's axes to those of the file
};

// Whether `path` starts with "%time". Throws `Error`: kIo where it cannot be read, kBadData where it is in UTF-16.
bool IsRosCsv(const std::string& path);

// A grid of n x n points per row: the column `field.size` holds n, from `field.x0` on stand all x, all y, all z.
// Coordinates that are nan or infinite make a point unseen. Throws `Error`: kIo where the file cannot be read, else
// kBadData naming file, line and column, also for more than kMaxRosCsvBytes, n above kMaxRosGridSide, rows of another n
// than the first, and times that do not increase.
PointTracks ReadRosGrid(const std::string& path);

// A pose per row: columns whose names end in `position.x` .. `position.z` and `orientation.x` .. `orientation.w`.
// Quaternions are normalised. Throws `Error` as above, also where a number is not finite, or a quaternion is more than
// 1 % off its unit length. Times may repeat.
PoseTrack ReadRosPoses(const std::string& path);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FORMATS_ROS_CSV_H_
