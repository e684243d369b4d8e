#include "tools/motion_clouds.h"

#include <gflags/gflags.h>

#include <algorithm>
#include <iostream>

#include "datasets/atomic_file.h"
#include "datasets/cloud_import.h"
#include "datasets/motion_file.h"
#include "sim/error.h"
#include "sim/npy_file.h"

DEFINE_string(scene, "", "scene.json with mesh, start and obstacles");
DEFINE_double(frame_rate, 0.0, "frames per second");
DEFINE_string(times, "", ".npy file of shape (T,) with the time of every frame, s");
DEFINE_double(scale, 1.0, "m per unit of the files");
DEFINE_double(voxel, 0.0, "side of cubes that keep the mean of their points, m; 0: all points");
DEFINE_int32(max_points, 0, "points kept per frame, chosen by --seed; 0: all");
DEFINE_uint64(seed, 1, "seed of the choice of points");
DEFINE_double(sigma, 0.0, "standard deviation of a coordinate, m; 0: not known");
DEFINE_bool(fit_pose, false, "move the mesh as a rigid body onto the first cloud");
DEFINE_bool(float64, false, "store the clouds in double precision");

namespace clothid {
namespace {

Eigen::VectorXd ReadTimes(const std::string& path) {
  if (path.empty()) return {};
  const NpyArray array = ReadNpy(path);
  if (array.shape.size() != 1 || array.values.empty()) {
    throw Error(ErrorKind::kBadData, path + ": expected an array of shape (T,), a time per frame");
  }
  return Eigen::Map<const Eigen::VectorXd>(array.values.data(), static_cast<Eigen::Index>(array.values.size()));
}

CloudImportOptions OptionsFromFlags(const std::string& input) {
  CloudImportOptions options;
  options.input = input;
  options.scene_path = FLAGS_scene;
  options.frame_rate = FLAGS_frame_rate;
  options.times = ReadTimes(FLAGS_times);
  options.scale = FLAGS_scale;
  options.voxel = FLAGS_voxel;
  options.max_points = FLAGS_max_points;
  options.seed = FLAGS_seed;
  options.sigma = FLAGS_sigma;
  options.fit_pose = FLAGS_fit_pose;
  options.single_precision = !FLAGS_float64;
  return options;
}

}  // namespace

int ConvertClouds(const std::vector<std::string>& arguments) {
  if (arguments.size() != 2) {
    throw Error(ErrorKind::kUsage, "convert_clouds: expected a folder or pattern of .npy files, and a file to write");
  }
  CheckFileCanBeWritten(arguments[1]);
  WriteMotion(ImportClouds(OptionsFromFlags(arguments[0])), arguments[1]);
  const RecordedMotion motion = ReadMotion(arguments[1]);
  std::cout << arguments[1] << ": " << motion.num_frames() << " frames\n";
  PrintClouds(motion);
  return kExitSuccess;
}

void PrintClouds(const RecordedMotion& motion) {
  if (motion.clouds.empty()) return;
  const auto fewer = [](const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b) { return a.cols() < b.cols(); };
  const auto [least, most] = std::minmax_element(motion.clouds.begin(), motion.clouds.end(), fewer);
  Eigen::Index sum = 0;
  for (const Eigen::Matrix3Xd& cloud : motion.clouds) sum += cloud.cols();
  std::cout << "clouds " << motion.clouds.size() << ", of " << least->cols() << " to " << most->cols() << " points, "
            << sum << " in all";
  if (motion.cloud_sigma > 0.0) std::cout << ", sigma " << motion.cloud_sigma << " m";
  std::cout << "\n";
}

}  // namespace clothid
