// The paths of handles for a recording: those of a scene, from a second file at another rate and clock, or from the
// measured points.
#ifndef CLOTHID_DATASETS_IMPORTING_HANDLE_TRACKS_H_
#define CLOTHID_DATASETS_IMPORTING_HANDLE_TRACKS_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "datasets/motion/motion_file.h"
#include "sim/path/handle_path.h"
#include "sim/scene/scene.h"

namespace clothid {

// Throws `Error` (kBadData), led by `source`, the name of a scene, where no frame lies within the times of the path of
// its handles, if it has one: they would stand still at an end of it, which is that of another clock.
void ExpectOneClock(const Handles& handles, const Eigen::VectorXd& times, const std::string& source);

// Gives `motion` the handles of a scene with their path at its times; none where they do not move.
void SetHandlePaths(const Handles& handles, MotionTensors* motion);

// The same, with the path as it is known, at times of its own: nothing is lost where frames are missing. What is not
// needed between the first and the last frame is left out.
void KeepHandlePaths(const Handles& handles, MotionTensors* motion);

// A file of handle paths: `time,x0,y0,z0,..` (sim/path/handle_csv.h), or ROS poses of a tool that holds the nodes
// (datasets/formats/ros_csv.h). In m and s.
struct HandleFile {
  std::string path;
  double time_offset = 0.0;  // s: its clock minus that of the recording
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  // Poses alone: JSON {"0": [x, y, z], "56": [..]} by node: where the tool holds it, m, in the tool's axes. Empty: one
  // node, at the tool's origin.
  std::string offsets_path;
};

// The path of `nodes` on the clock of the recording, which has frames at `times` [T] s and was shifted by `time_shift`
// s. Throws `Error`: kIo or kBadData for the files, and kBadData where a frame lies outside of the file's times by more
// than its longest interval: a wrong clock.
HandlePath ReadHandlePath(const HandleFile& file, const std::vector<int>& nodes, const Eigen::VectorXd& times,
                          double time_shift);

// The measured positions [3H x T] of the points `points` [H] out of `positions` [3P x T] m. Frames in which a point is
// not seen are filled by the same cubics, before its first and after its last by standing still. Throws `Error`
// (kBadData), prefixed by `source`, for a point that is never seen.
Eigen::MatrixXd MeasuredHandlePositions(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions,
                                        const std::vector<int>& points, const std::string& source);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_IMPORTING_HANDLE_TRACKS_H_
