// Rigid transforms between frames of reference, as files.
#ifndef CLOTHID_DATASETS_IMPORTING_TRANSFORM_FILE_H_
#define CLOTHID_DATASETS_IMPORTING_TRANSFORM_FILE_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>

namespace clothid {

// x -> R x + t. The file is one of
//   {"matrix": [[..], [..], [..], [0, 0, 0, 1]]}                        four rows, or the 16 numbers row by row
//   {"rotation": [qx, qy, qz, qw], "translation": [x, y, z]}            either may be absent
//   a ROS CSV of poses (datasets/formats/ros_csv.h), known by its "%time": the last row.
// Translations are in m. Rotations are taken to the nearest proper one. Throws `Error`: kIo where the file cannot be
// read, else kBadData naming file, line and key, also for a matrix that mirrors or scales, and a quaternion more than
// 1 % off its unit length.
Eigen::Isometry3d ReadTransform(const std::string& path);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_IMPORTING_TRANSFORM_FILE_H_
