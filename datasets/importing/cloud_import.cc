#include "datasets/importing/cloud_import.h"

#include <glob.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <system_error>
#include <utility>

#include "datasets/importing/handle_tracks.h"
#include "datasets/importing/track_edit.h"
#include "datasets/motion/motion_validation.h"
#include "datasets/motion/scene_text.h"
#include "datasets/observation/cloth_surface.h"
#include "sim/base/error.h"
#include "sim/base/frame_names.h"
#include "sim/base/json_document.h"
#include "sim/base/npy_file.h"
#include "sim/base/text_file.h"
#include "sim/matrix/dense.h"
#include "sim/scene/scene_json.h"

namespace clothid {
namespace {

namespace fs = std::filesystem;

// Iterated closest points: the most rounds, and the motion, relative to the cloth's size, that ends them.
constexpr int kMaxPoseRounds = 100;
constexpr double kPoseTolerance = 1e-7;
// Relative to the trace of the Gauss-Newton matrix: what is seen less than this is not moved.
constexpr double kPoseDamping = 1e-6;
// Points farther than this many medians are left out of a round.
constexpr double kOutlierMedians = 3.0;

// Beyond this many cubes along an axis their numbers are not exact.
constexpr double kMaxVoxels = 1e15;

std::vector<std::string> FilesOfFolder(const std::string& folder) {
  std::error_code error;
  std::vector<std::string> files;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (it->path().extension() == ".npy") files.push_back(it->path().filename().string());
  }
  if (error) throw Error(ErrorKind::kIo, folder + ": cannot be read: " + error.message());
  if (!files.empty()) ExpectOneSequence(folder, files);
  for (std::string& file : files) file = (fs::path(folder) / file).string();
  return files;
}

std::vector<std::string> FilesOfPattern(const std::string& pattern) {
  glob_t found = {};
  std::vector<std::string> files;
  if (glob(pattern.c_str(), 0, nullptr, &found) == 0) files.assign(found.gl_pathv, found.gl_pathv + found.gl_pathc);
  globfree(&found);
  return files;
}

void CheckOptions(const CloudImportOptions& options) {
  ExpectUsage(!options.scene_path.empty(), "a scene is missing, which gives the mesh");
  ExpectUsage((options.times.size() > 0) != (options.frame_rate != 0.0), "expected either a frame rate or times");
  ExpectUsage(options.frame_rate >= 0.0 && std::isfinite(options.frame_rate), "frame_rate: expected a rate > 0 in Hz");
  ExpectUsage(options.scale > 0.0 && std::isfinite(options.scale), "scale: expected a number > 0");
  ExpectUsage(options.voxel >= 0.0 && std::isfinite(options.voxel), "voxel: expected a length >= 0 in m");
  ExpectUsage(options.max_points >= 0, "max_points: expected a number >= 0");
  ExpectUsage(options.sigma >= 0.0 && std::isfinite(options.sigma), "sigma: expected a standard deviation >= 0 in m");
}

Eigen::VectorXd Times(const CloudImportOptions& options, const std::vector<std::string>& files) {
  const auto count = static_cast<Eigen::Index>(files.size());
  const std::vector<long long> numbers = FrameNumbers(files);
  if (options.times.size() == 0) return TimesAtRate(options.frame_rate, count, numbers, options.input);
  const Eigen::VectorXd times = TimesOfNumbers(options.times, numbers);
  if (times.size() == count) return times;
  throw Error(ErrorKind::kBadData, options.input + ": expected a file for each of the " + std::to_string(times.size()) +
                                       " times, found " + std::to_string(count));
}

// Every node at its start in the first frame, and not seen afterwards.
void TrackStart(const Scene& scene, MotionTensors* motion) {
  motion->positions.setConstant(scene.initial_positions.size(), motion->times.size(),
                                std::numeric_limits<double>::quiet_NaN());
  motion->positions.col(0) = scene.initial_positions;
  motion->single_precision = false;
  if (motion->cloud_sigma > 0.0) {
    motion->sigma = Eigen::VectorXd::Constant(scene.mesh.num_nodes(), motion->cloud_sigma);
  }
}

// The Gauss-Newton step of the distances, outliers left out, over the rigid motions of the nodes [3 x N] about their
// centre. A motion that no distance sees, as along a plane, is not made.
Eigen::Isometry3d NextPose(const ClothTopology& topology, const Eigen::Matrix3Xd& nodes, const Eigen::Matrix3Xd& cloud,
                           double size) {
  const ClothSurface surface(topology, nodes.reshaped());
  const Eigen::Vector3d center = nodes.rowwise().mean();
  std::vector<SurfaceDistance> rows;
  std::vector<double> distances;
  for (const auto point : cloud.colwise()) {
    rows.push_back(surface.Measure(point, 0.0));
    distances.push_back(std::abs(rows.back().distance));
  }
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  using Vector6d = Eigen::Matrix<double, 6, 1>;
  Eigen::Matrix<double, 6, 6> hessian = Eigen::Matrix<double, 6, 6>::Zero();
  Vector6d gradient = Vector6d::Zero();
  for (const SurfaceDistance& row : rows) {
    if (std::abs(row.distance) > kOutlierMedians * *middle) continue;
    Vector6d change = Vector6d::Zero();  // of the distance: by m of shift, by size/rad of turn
    for (int k = 0; k < row.num_nodes; ++k) {
      const Eigen::Vector3d arm = nodes.col(row.nodes[k]) - center, slope = row.gradient.col(k);
      change.head<3>() += slope;
      change.tail<3>() += arm.cross(slope) / size;
    }
    hessian += change * change.transpose();
    gradient += change * row.distance;
  }
  hessian.diagonal().array() += kPoseDamping * hessian.trace();
  const Vector6d step = -SymmetricFactor(hessian).SolveOne(gradient);
  const Eigen::Vector3d turn = step.tail<3>() / size;
  const double angle = turn.norm();
  Eigen::Isometry3d motion = Eigen::Isometry3d(Eigen::Translation3d(center + step.head<3>()));
  if (angle > 0.0) motion.rotate(Eigen::AngleAxisd(angle, turn / angle));
  return motion * Eigen::Translation3d(-center);
}

}  // namespace

std::vector<std::string> ListCloudFiles(const std::string& input) {
  std::error_code ignored;
  std::vector<std::string> files = fs::is_directory(input, ignored) ? FilesOfFolder(input) : FilesOfPattern(input);
  if (files.empty()) throw Error(ErrorKind::kBadData, input + ": expected .npy files, one per frame, found none");
  if (files.size() > kMaxCloudFiles) {
    throw Error(ErrorKind::kBadData, input + ": expected at most " + std::to_string(kMaxCloudFiles) + " files");
  }
  std::sort(files.begin(), files.end(), &NaturalLess);
  return files;
}

Eigen::Matrix3Xd ReadCloud(const std::string& path, double scale) {
  const NpyArray array = ReadNpy(path);
  if (array.shape.size() != 2 || array.shape[1] != 3) {
    throw Error(ErrorKind::kBadData, path + ": expected an array of shape (M, 3)");
  }
  Eigen::Matrix3Xd cloud(3, static_cast<Eigen::Index>(array.values.size() / 3));
  Eigen::Index num_seen = 0;
  for (Eigen::Index i = 0; i < cloud.cols(); ++i) {
    const Eigen::Vector3d point = scale * Eigen::Map<const Eigen::Vector3d>(array.values.data() + 3 * i);
    if (point.allFinite()) cloud.col(num_seen++) = point;
  }
  return cloud.leftCols(num_seen);
}

Eigen::Matrix3Xd MeanPerVoxel(const Eigen::Matrix3Xd& cloud, double voxel) {
  if (voxel == 0.0 || cloud.cols() == 0) return cloud;
  if (!(cloud.cwiseAbs().maxCoeff() / voxel < kMaxVoxels)) {
    throw Error(ErrorKind::kUsage,
                "voxel: is too small for coordinates of up to " + std::to_string(cloud.cwiseAbs().maxCoeff()) + " m");
  }
  std::map<std::array<long long, 3>, Eigen::Index> cubes;
  Eigen::Matrix3Xd sums = Eigen::Matrix3Xd::Zero(3, cloud.cols());
  Eigen::VectorXd counts = Eigen::VectorXd::Zero(cloud.cols());
  for (const auto point : cloud.colwise()) {
    std::array<long long, 3> cube;
    for (int k = 0; k < 3; ++k) cube[k] = static_cast<long long>(std::floor(point[k] / voxel));
    const Eigen::Index column = cubes.try_emplace(cube, static_cast<Eigen::Index>(cubes.size())).first->second;
    sums.col(column) += point;
    counts[column] += 1.0;
  }
  const Eigen::Index num_cubes = static_cast<Eigen::Index>(cubes.size());
  return sums.leftCols(num_cubes) * counts.head(num_cubes).cwiseInverse().asDiagonal();
}

Eigen::Matrix3Xd ChoosePoints(const Eigen::Matrix3Xd& cloud, int count, std::uint64_t seed, std::uint32_t stream) {
  if (count == 0 || cloud.cols() <= count) return cloud;
  std::seed_seq sequence{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32), stream};
  std::mt19937_64 generator(sequence);
  std::vector<Eigen::Index> all(static_cast<std::size_t>(cloud.cols())), chosen;
  std::iota(all.begin(), all.end(), 0);
  std::sample(all.begin(), all.end(), std::back_inserter(chosen), count, generator);
  return cloud(Eigen::all, chosen);
}

Eigen::Matrix3Xd FitPose(const Mesh& mesh, const Eigen::Matrix3Xd& cloud) {
  if (cloud.cols() < 3) throw Error(ErrorKind::kBadData, "the first cloud has less than three points");
  const ClothTopology topology(mesh.faces, mesh.num_nodes());
  const double size = ClothSize(mesh);
  Eigen::Matrix3Xd nodes = mesh.rest_positions;
  for (int round = 0; round < kMaxPoseRounds; ++round) {
    const Eigen::Matrix3Xd moved = NextPose(topology, nodes, cloud, size) * nodes;
    const double largest = (moved - nodes).colwise().norm().maxCoeff();
    nodes = moved;
    if (!(largest > kPoseTolerance * size)) break;
  }
  return nodes;
}

MotionTensors ImportClouds(const CloudImportOptions& options) {
  CheckOptions(options);
  const std::vector<std::string> files = ListCloudFiles(options.input);
  const std::string text = ReadText(options.scene_path, kMaxJsonBytes);
  const Scene scene = ParseScene(text, options.scene_path, fs::path(options.scene_path).parent_path().string());
  MotionTensors motion;
  motion.times = Times(options, files);
  motion.mesh = scene.mesh;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const Eigen::Matrix3Xd cloud = MeanPerVoxel(ReadCloud(files[i], options.scale), options.voxel);
    motion.clouds.push_back(ChoosePoints(cloud, options.max_points, options.seed, static_cast<std::uint32_t>(i)));
  }
  motion.cloud_sigma = options.sigma;
  motion.single_precision_clouds = options.single_precision;
  motion.positions.resize(0, motion.times.size());
  bool start_is_first_frame = false;
  motion.scene_text = SelfContainedText(scene, text, &start_is_first_frame);
  motion.sequences = SequencesOf(scene);
  if (options.fit_pose) {
    ExpectUsage(!start_is_first_frame && scene.handles.path.num_handles() == 0,
                "fit_pose: the start and the handle paths that the scene reads from files have a place of their own");
    motion.mesh.rest_positions = FitPose(scene.mesh, motion.clouds.front());
  }
  if (start_is_first_frame) TrackStart(scene, &motion);
  ExpectOneClock(scene.handles, motion.times, options.scene_path);
  SetHandlePaths(scene.handles, &motion);
  ValidateMotionTensors(motion, options.input);
  motion.provenance = "point clouds: " + std::to_string(files.size()) + " files";
  return motion;
}

}  // namespace clothid
