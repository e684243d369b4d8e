// Paths of rigid bodies as a table.
#ifndef CLOTHID_SIM_PATH_POSE_CSV_H_
#define CLOTHID_SIM_PATH_POSE_CSV_H_

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "sim/path/rigid_path.h"

namespace clothid {

inline constexpr std::uint64_t kMaxPoseCsvBytes = std::uint64_t{1} << 28;

// Reads a table (sim/base/table.h) with the columns "time,x,y,z,qx,qy,qz,qw" and one row per time (s, m, a unit
// quaternion). Throws `Error`: kIo where the file cannot be read, else kBadData naming file and line.
RigidPath ReadPoseCsv(const std::string& path);

// The path whose rows are the columns [8 x T]: time, position, rotation. Throws `Error` where `RigidPath` does.
RigidPath PathOfTable(const Eigen::MatrixXd& table);
// Its inverse.
Eigen::MatrixXd TableOfPath(const RigidPath& path);

}  // namespace clothid

#endif  // CLOTHID_SIM_PATH_POSE_CSV_H_
