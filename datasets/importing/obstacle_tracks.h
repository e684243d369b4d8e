// The paths of obstacles for a recording, from files at another rate and clock.
#ifndef CLOTHID_DATASETS_IMPORTING_OBSTACLE_TRACKS_H_
#define CLOTHID_DATASETS_IMPORTING_OBSTACLE_TRACKS_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "datasets/importing/track_edit.h"
#include "datasets/motion/motion_file.h"
#include "sim/path/rigid_path.h"

namespace clothid {

// How an obstacle moved, in m and s:
// - a file of poses, `time,x,y,z,qx,qy,qz,qw` (sim/path/pose_csv.h) or ROS poses (datasets/formats/ros_csv.h), where
// the
//   axes are that the scene gives its shape in;
// - a .trc file of markers on it: the scene gives its shape where it is at the first frame of the file;
// - of a mesh, which deforms, the places of its vertices: a .npy, .pc2, or .obj or .ply files (ReadTracks).
struct ObstacleFile {
  std::string name;  // of the obstacle in the scene
  std::string path;
  double time_offset = 0.0;  // s: its clock minus that of the recording
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
};

// The path on the clock of the recording, which has frames at `times` [T] s and was shifted by `time_shift` s; what is
// not needed between the first and the last of them is left out. Throws `Error`: kIo or kBadData for the file, and
// kBadData where a frame lies outside of its times by more than its longest interval: a wrong clock. The file holds
// poses or markers.
RigidPath ReadObstaclePath(const ObstacleFile& file, const Eigen::VectorXd& times, double time_shift);

// Gives the obstacles of the scene text of `motion`, which has to be complete, the motions of `files` in place of
// their own. Throws `Error`, led by the file's name: as above, and kUsage for a name that no obstacle has, or that
// stands twice, and for vertices of what is no mesh.
void SetObstaclePaths(const std::vector<ObstacleFile>& files, double time_shift, const std::string& source,
                      MotionTensors* motion);

// The paths and sequences of the obstacles of a recording go with the clock of its frames, which `edit` has moved
// and shifted by `time_shift` s; where they are stays, as all obstacles do. Throws `Error` (kUsage), led by `source`,
// for new times of the frames alone.
void EditObstacleClocks(const TrackEdit& edit, double time_shift, const std::string& source, MotionTensors* motion);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_IMPORTING_OBSTACLE_TRACKS_H_
