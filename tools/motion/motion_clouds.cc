#include <gflags/gflags.h>

#include <algorithm>
#include <iostream>
#include <limits>
#include <optional>

#include "datasets/files/atomic_file.h"
#include "datasets/files/overwrite.h"
#include "datasets/importing/cloud_import.h"
#include "datasets/motion/motion_file.h"
#include "datasets/motion/motion_name.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/scene/scene_json.h"
#include "tools/motion/motion_commands.h"
#include "tools/motion/obstacle_flags.h"
#include "tools/motion/track_flags.h"

DECLARE_string(scene);
DECLARE_double(frame_rate);
DECLARE_string(times);
DECLARE_double(time_scale);
DECLARE_string(missing);
DECLARE_double(scale);
DECLARE_string(transform);
DECLARE_double(sigma);
DEFINE_string(box, "", "x0,y0,z0,x1,y1,z1: points outside are left out, m");
DEFINE_double(voxel, 0.0, "side of cubes that keep the mean of their points, m; 0: all points");
DEFINE_int32(max_points, 0, "points kept per frame, chosen by --seed; 0: all");
DEFINE_uint64(seed, 1, "seed of the choice of points");
DEFINE_bool(fit_pose, false, "move the mesh as a rigid body onto the first cloud");
DEFINE_bool(float64, false, "store the clouds in double precision");

namespace clothid {
namespace {

// A number, or inf or -inf for no bound.
std::optional<double> ParseBound(const std::string& word) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (word == "inf" || word == "-inf") return word == "inf" ? kInfinity : -kInfinity;
  return ParseNumber(word);
}

std::optional<Eigen::AlignedBox3d> BoxFromFlags() {
  if (FLAGS_box.empty()) return std::nullopt;
  const std::vector<std::string> words = Split(FLAGS_box, ',');
  Eigen::AlignedBox3d box;
  bool fits = words.size() == 6;
  for (std::size_t i = 0; fits && i < 6; ++i) {
    const std::optional<double> bound = ParseBound(words[i]);
    fits = bound.has_value();
    if (fits) (i < 3 ? box.min() : box.max())[static_cast<Eigen::Index>(i % 3)] = *bound;
  }
  if (fits && (box.min().array() < box.max().array()).all()) return box;
  throw Error(
      ErrorKind::kUsage,
      "--box: expected x0,y0,z0,x1,y1,z1 with x0 < x1, y0 < y1 and z0 < z1 (m), inf or -inf for no bound, got '" +
          Printable(FLAGS_box) + "'");
}

CloudImportOptions OptionsFromFlags(const std::string& input) {
  CloudImportOptions options;
  options.input = input;
  options.scene_path = FLAGS_scene;
  options.frame_rate = FLAGS_frame_rate;
  if (!FLAGS_times.empty()) {
    const FrameTimes times = FrameTimesFromFlags(ListCloudFiles(input));
    options.times = times.times;
    options.times_since_first = times.since_first;
  }
  options.times_name = TimesNameFromFlags();
  options.time_scale = FLAGS_time_scale;
  options.start_at = StartFromFlags();
  options.missing = MissingValues::Parse(FLAGS_missing, "--missing");
  options.scale = FLAGS_scale;
  options.transform = TransformFromFlags();
  options.box = BoxFromFlags();
  options.voxel = FLAGS_voxel;
  options.max_points = FLAGS_max_points;
  options.seed = FLAGS_seed;
  options.sigma = FLAGS_sigma;
  options.fit_pose = FLAGS_fit_pose;
  options.single_precision = !FLAGS_float64;
  return options;
}

std::vector<std::string> InputFiles(const std::string& clouds) {
  std::vector<std::string> files = ListCloudFiles(clouds);
  files.insert(files.end(), {FLAGS_times, FLAGS_transform});
  for (const std::string& file : ObstacleInputs()) files.push_back(file);
  if (FLAGS_scene.empty()) return files;
  for (const std::string& file : FilesOfScene(FLAGS_scene)) files.push_back(file);
  return files;
}

}  // namespace

int MotionConvertClouds(const std::vector<std::string>& arguments) {
  ExpectMotionName(arguments[1]);
  RefuseOverwrite(arguments[1], InputFiles(arguments[0]));
  CheckFileCanBeWritten(arguments[1]);
  double time_shift = 0.0;
  MotionTensors tensors = ImportClouds(OptionsFromFlags(arguments[0]), &time_shift);
  SetObstaclePaths(ObstacleFilesFromFlags(), time_shift, arguments[0], &tensors);
  const RecordedMotion motion = InterpretMotion(tensors, arguments[0]);
  WriteMotion(tensors, arguments[1]);
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
