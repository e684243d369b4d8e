// Recordings from point clouds of another program: a .npy file per frame, and a scene.
#ifndef CLOTHID_DATASETS_IMPORTING_CLOUD_IMPORT_H_
#define CLOTHID_DATASETS_IMPORTING_CLOUD_IMPORT_H_

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "datasets/motion/motion_file.h"

namespace clothid {

inline constexpr int kMaxCloudFiles = 100000;

struct CloudImportOptions {
  // A folder, every *.npy file of which is a frame, or a pattern of file names with * and ?. Frames are in the order of
  // the names, numbers in them by their value.
  std::string input;
  std::string scene_path;        // scene.json
  double frame_rate = 0.0;       // Hz, from time 0 on, gaps where the names leave numbers out; or
  Eigen::VectorXd times;         // [T] s, of the files or of all numbers
  double scale = 1.0;            // m per unit of the files
  double voxel = 0.0;            // m, the side of cubes, each of which keeps the mean of its points; 0: keep all
  int max_points = 0;            // per frame, chosen at random by `seed`, after the cubes; 0: all
  std::uint64_t seed = 1;        // every frame has a stream of its own
  double sigma = 0.0;            // m, standard deviation of a coordinate; 0: not known
  bool fit_pose = false;         // moves the mesh as a rigid body onto the first cloud, see FitPose
  bool single_precision = true;  // clouds are stored as F32
};

// The files of `input` in order. Throws `Error`: kIo where the folder cannot be read, kBadData where there are none or
// more than kMaxCloudFiles, kUsage where ExpectOneSequence does (sim/base/frame_names.h).
std::vector<std::string> ListCloudFiles(const std::string& input);

// One frame: shape (M, 3), float32 or float64, in m after `scale`; rows with a NaN or an infinity are left out. Throws
// `Error` as ReadNpy does, and kBadData for any other shape.
Eigen::Matrix3Xd ReadCloud(const std::string& path, double scale);

// One mean per occupied cube of side `voxel` m, in the order of the first points in them; all points for 0.
Eigen::Matrix3Xd MeanPerVoxel(const Eigen::Matrix3Xd& cloud, double voxel);

// `count` of the points, or all where there are no more, in their order; the same for the same seed and stream.
Eigen::Matrix3Xd ChoosePoints(const Eigen::Matrix3Xd& cloud, int count, std::uint64_t seed, std::uint32_t stream);

// The mesh at rest, moved as a rigid body to where it is nearest to the cloud, by iterated closest points from where it
// stands: Gauss-Newton steps of the distances to the surface, those beyond three times the median left out, until it
// moves no further. A minimum near by, not the best of all: the scene has to say roughly where the cloth is and which
// way it lies. Throws `Error` (kBadData) for less than three points.
Eigen::Matrix3Xd FitPose(const Mesh& mesh, const Eigen::Matrix3Xd& cloud);

// A recording of clouds alone, self-contained as one of `RecordRollout` is. The scene has to give the mesh; a start
// that it reads from a file becomes the first frame of tracked nodes, which are not seen afterwards. Paths of handles
// are sampled at the times. Throws `Error`: kUsage for options that contradict each other, kBadData and kIo as the
// readers do, and where ValidateMotionTensors does.
MotionTensors ImportClouds(const CloudImportOptions& options);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_IMPORTING_CLOUD_IMPORT_H_
