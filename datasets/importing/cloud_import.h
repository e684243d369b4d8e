// Recordings from point clouds of another program: a .npy or .ply file per frame, and a scene.
#ifndef CLOTHID_DATASETS_IMPORTING_CLOUD_IMPORT_H_
#define CLOTHID_DATASETS_IMPORTING_CLOUD_IMPORT_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "datasets/importing/missing_value.h"
#include "datasets/motion/motion_file.h"

namespace clothid {

inline constexpr int kMaxCloudFiles = 100000;
// An array with more columns than this beside x, y and z holds no points in rows.
inline constexpr int kMaxCloudColumns = 32;

struct CloudImportOptions {
  // A folder, every .npy file of which is a frame, or every .ply file where there are not two .npy (several of both are
  // refused); a pattern of file names with *, ? or #; or one .npy file with all frames. Frames are in the order of the
  // names, numbers in them by their value.
  std::string input;
  std::string scene_path;             // scene.json
  double frame_rate = 0.0;            // Hz, from time 0 on, gaps where the names leave numbers out; or
  Eigen::VectorXd times;              // [T] of the files or of all numbers
  std::string times_name;             // for messages: the file of `times`
  Eigen::VectorXd times_since_first;  // [T] see FrameTimes (datasets/importing/clock_times.h); empty: not known
  double time_scale = 1.0;            // s per unit of the times
  std::optional<double> start_at;     // s: where the first frame is put; empty: where it is
  MissingValues missing;              // positions in the numbers of the files that are no points
  double scale = 1.0;                 // m per unit of the files
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();  // then of points in m, to the axes of the scene
  std::optional<Eigen::AlignedBox3d> box;                       // m, in those axes: points outside of it are left out
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

// One frame, in m after `scale`; points with a NaN or an infinity, and those in `missing`, are left out. The vertices
// of a .ply file, or an array of float32 or float64 of shape (M, C) or (H, W, C), as of an image: the first three of
// the C columns, 3 to kMaxCloudColumns, are x, y and z. Throws `Error` as ReadPlyPoints and ReadNpy do, and kBadData
// for any other shape.
Eigen::Matrix3Xd ReadCloud(const std::string& path, double scale, const MissingValues& missing = {});

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
// readers do, where the box holds no point of any frame, and where ValidateMotionTensors does. `time_shift` (may be
// null) gets what `start_at` added to all times, s.
MotionTensors ImportClouds(const CloudImportOptions& options, double* time_shift = nullptr);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_IMPORTING_CLOUD_IMPORT_H_
