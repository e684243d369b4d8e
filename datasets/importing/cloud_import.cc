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
#include <sstream>
#include <system_error>
#include <utility>

#include "datasets/formats/ply_file.h"
#include "datasets/importing/handle_tracks.h"
#include "datasets/importing/path_times.h"
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

bool EndsIn(const std::string& path, const std::string& extension) {
  std::string own = fs::path(path).extension().string();
  for (char& c : own) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c | 0x20) : c;
  return own == extension;
}

// Beside clouds of the one kind may lie one file of the other: times, or a mesh.
std::vector<std::string> FilesOfFolder(const std::string& folder) {
  std::error_code error;
  std::vector<std::string> arrays, meshes;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (name.front() == '.') continue;
    if (EndsIn(name, ".npy")) arrays.push_back(name);
    if (EndsIn(name, ".ply")) meshes.push_back(name);
  }
  if (error) throw Error(ErrorKind::kIo, folder + ": cannot be read: " + error.message());
  if (arrays.size() > 1 && meshes.size() > 1) {
    FailOnData(folder, "holds " + std::to_string(arrays.size()) + " .npy and " + std::to_string(meshes.size()) +
                           " .ply files; expected frames of one kind, or a pattern such as '" +
                           (fs::path(folder) / "*.ply").string() + "'");
  }
  std::vector<std::string> files = arrays.size() < 2 && !meshes.empty() ? meshes : arrays;
  if (!files.empty()) ExpectOneSequence(folder, files);
  for (std::string& file : files) file = (fs::path(folder) / file).string();
  return files;
}

std::vector<std::string> FilesOfPattern(const std::string& pattern) {
  glob_t found = {};
  std::vector<std::string> files;
  if (glob(pattern.c_str(), 0, nullptr, &found) == 0) files.assign(found.gl_pathv, found.gl_pathv + found.gl_pathc);
  globfree(&found);
  return files.empty() && IsFramePattern(pattern) ? FramePaths(pattern, "") : files;
}

// The points of a file as they stand in it, frame by frame, as many in each.
struct FilePoints {
  Eigen::Matrix3Xd points;
  long long num_frames = 1;
};

// `is_alone`: the file has to hold all frames, so that the first of more than two axes counts them.
FilePoints ReadPoints(const std::string& path, bool is_alone) {
  if (EndsIn(path, ".ply")) return {ReadPlyPoints(path)};
  const NpyArray array = ReadNpy(path);
  const std::size_t num_axes = array.shape.size();
  const bool has_frames = is_alone && num_axes > 2, is_organised = num_axes == (has_frames ? 4 : 3);
  const long long num_columns = num_axes > 0 ? array.shape.back() : 0;
  const bool fits = is_organised || num_axes == (has_frames ? 3 : 2);
  if (!fits || num_columns < 3 || num_columns > kMaxCloudColumns) {
    std::string found;
    for (const long long size : array.shape) found += (found.empty() ? "" : ", ") + std::to_string(size);
    FailOnData(path, "expected an array of shape (M, 3) or (H, W, 3), or with more columns than x, y and z, found (" +
                         found + ")");
  }
  const Eigen::Map<const Eigen::MatrixXd> rows(array.values.data(), num_columns,
                                               static_cast<Eigen::Index>(array.values.size()) / num_columns);
  return {rows.topRows<3>(), has_frames ? array.shape[0] : 1};
}

// Those that were seen, in m.
Eigen::Matrix3Xd SeenPoints(const Eigen::Ref<const Eigen::Matrix3Xd>& points, double scale,
                            const MissingValues& missing) {
  Eigen::Matrix3Xd seen(3, points.cols());
  Eigen::Index num_seen = 0;
  for (const auto point : points.colwise()) {
    seen.col(num_seen) = scale * point;
    if (seen.col(num_seen).allFinite() && !missing.Contains(point)) ++num_seen;
  }
  return seen.leftCols(num_seen);
}

void CheckOptions(const CloudImportOptions& options) {
  ExpectUsage(!options.scene_path.empty(), "a scene is missing, which gives the mesh");
  ExpectUsage((options.times.size() > 0) != (options.frame_rate != 0.0), "expected either a frame rate or times");
  ExpectUsage(options.frame_rate >= 0.0 && std::isfinite(options.frame_rate), "frame_rate: expected a rate > 0 in Hz");
  ExpectUsage(options.scale > 0.0 && std::isfinite(options.scale), "scale: expected a number > 0");
  ExpectUsage(!options.box || !options.box->isEmpty(), "box: expected a corner and one above it");
  ExpectUsage(options.voxel >= 0.0 && std::isfinite(options.voxel), "voxel: expected a length >= 0 in m");
  ExpectUsage(options.max_points >= 0, "max_points: expected a number >= 0");
  ExpectUsage(options.sigma >= 0.0 && std::isfinite(options.sigma), "sigma: expected a standard deviation >= 0 in m");
}

// Of `num_frames`, each in a file of its own or all in one.
EditedTracks TimesOfClouds(const CloudImportOptions& options, const std::vector<std::string>& files,
                           std::size_t num_frames) {
  PointTracks frames;  // without points
  frames.name = options.input;
  frames.positions.resize(0, static_cast<Eigen::Index>(num_frames));
  frames.frame_numbers = FrameNumbers(files);
  TrackEdit edit;
  edit.times = options.times;
  edit.times_name = options.times_name;
  edit.times_since_first = options.times_since_first;
  edit.frame_rate = options.frame_rate;
  edit.time_scale = options.time_scale;
  edit.start_at = options.start_at;
  return EditTracks(frames, edit);
}

// Moves clouds into the axes of the scene and cuts them there.
class CloudCutter {
 public:
  explicit CloudCutter(const CloudImportOptions& options) : transform_(options.transform), box_(options.box) {}

  Eigen::Matrix3Xd Cut(const Eigen::Matrix3Xd& cloud) {
    if (!box_ && transform_.matrix().isIdentity(0.0)) return cloud;
    Eigen::Matrix3Xd kept(3, cloud.cols());
    Eigen::Index num_kept = 0;
    for (const auto point : cloud.colwise()) {
      const Eigen::Vector3d moved = transform_ * Eigen::Vector3d(point);
      all_.extend(moved);
      if (!box_ || box_->contains(moved)) kept.col(num_kept++) = moved;
    }
    num_kept_ += num_kept;
    return kept.leftCols(num_kept);
  }

  // Throws `Error` (kBadData), led by `source`, where points were cut, and all of them.
  void ExpectPoints(const std::string& source) const {
    if (!box_ || num_kept_ > 0 || all_.isEmpty()) return;
    FailOnData(source, "none of its points is in the box " + Corners(*box_) + "; they are in " + Corners(all_) + " m");
  }

 private:
  static std::string Corners(const Eigen::AlignedBox3d& box) {
    const Eigen::IOFormat commas(4, Eigen::DontAlignCols, ", ");
    std::ostringstream text;
    text << "(" << box.min().transpose().format(commas) << ") to (" << box.max().transpose().format(commas) << ")";
    return text.str();
  }

  const Eigen::Isometry3d transform_;
  const std::optional<Eigen::AlignedBox3d> box_;
  Eigen::AlignedBox3d all_;
  Eigen::Index num_kept_ = 0;
};

// As they are measured: what is no point of the cloth left out, then thinned out.
std::vector<Eigen::Matrix3Xd> ReadClouds(const CloudImportOptions& options, const std::vector<std::string>& files) {
  CloudCutter cutter(options);
  std::vector<Eigen::Matrix3Xd> clouds;
  for (const std::string& file : files) {
    const FilePoints read = ReadPoints(file, files.size() == 1);
    const Eigen::Index count = read.num_frames > 0 ? read.points.cols() / read.num_frames : 0;
    for (long long frame = 0; frame < read.num_frames; ++frame) {
      const Eigen::Matrix3Xd seen =
          SeenPoints(read.points.middleCols(frame * count, count), options.scale, options.missing);
      const Eigen::Matrix3Xd cloud = MeanPerVoxel(cutter.Cut(seen), options.voxel);
      clouds.push_back(
          ChoosePoints(cloud, options.max_points, options.seed, static_cast<std::uint32_t>(clouds.size())));
    }
  }
  cutter.ExpectPoints(options.input);
  return clouds;
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
  if (files.empty())
    throw Error(ErrorKind::kBadData, input + ": expected .npy or .ply files, one per frame, found none");
  if (files.size() > kMaxCloudFiles) {
    throw Error(ErrorKind::kBadData, input + ": expected at most " + std::to_string(kMaxCloudFiles) + " files");
  }
  std::sort(files.begin(), files.end(), &NaturalLess);
  return files;
}

Eigen::Matrix3Xd ReadCloud(const std::string& path, double scale, const MissingValues& missing) {
  return SeenPoints(ReadPoints(path, false).points, scale, missing);
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

MotionTensors ImportClouds(const CloudImportOptions& options, double* time_shift) {
  CheckOptions(options);
  const std::vector<std::string> files = ListCloudFiles(options.input);
  const std::string text = ReadText(options.scene_path, kMaxJsonBytes);
  const Scene scene = ParseScene(text, options.scene_path, fs::path(options.scene_path).parent_path().string());
  MotionTensors motion;
  motion.mesh = scene.mesh;
  EditedTracks clock;
  if (files.size() > 1) clock = TimesOfClouds(options, files, files.size());
  motion.clouds = ReadClouds(options, files);
  if (files.size() == 1) clock = TimesOfClouds(options, files, motion.clouds.size());
  motion.times = clock.tracks.times;
  if (options.frame_rate == 0.0) ExpectSeconds(motion.times, clock.tracks.times_name);
  if (time_shift != nullptr) *time_shift = clock.time_shift;
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
  motion.provenance = "point clouds: " + std::to_string(files.size()) + (files.size() == 1 ? " file" : " files");
  return motion;
}

}  // namespace clothid
