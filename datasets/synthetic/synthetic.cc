#include "datasets/synthetic/synthetic.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <random>
#include <sstream>
#include <vector>

#include "datasets/formats/track_checks.h"
#include "datasets/importing/handle_tracks.h"
#include "datasets/motion/scene_text.h"
#include "sim/base/error.h"

namespace clothid {
namespace {

// A frame whose time is this close to a step's, in steps, is taken at the step: 1/rate and h are both rounded numbers.
constexpr double kSameStep = 1e-6;

enum class Stream : std::uint32_t { kMarkers, kNoise, kDrops, kCloud };

std::mt19937_64 MakeGenerator(std::uint64_t seed, Stream stream) {
  std::seed_seq sequence{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32),
                         static_cast<std::uint32_t>(stream)};
  return std::mt19937_64(sequence);
}

std::string ToString(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

std::vector<int> FreeNodes(const Scene& scene) {
  std::vector<int> handles = scene.handles.nodes;
  std::sort(handles.begin(), handles.end());
  std::vector<int> all(scene.mesh.num_nodes()), free;
  std::iota(all.begin(), all.end(), 0);
  std::set_difference(all.begin(), all.end(), handles.begin(), handles.end(), std::back_inserter(free));
  return free;
}

bool HasCloud(const SyntheticOptions& options) { return options.num_cloud_points > 0; }

// Clouds take the place of the nodes, not of markers.
bool SeesNoNodes(const SyntheticOptions& options) { return options.num_markers == 0 && HasCloud(options); }

void CheckRanges(const SyntheticOptions& options, const Scene& scene) {
  ExpectUsage(std::isfinite(options.noise_sigma) && options.noise_sigma >= 0.0,
              "noise " + ToString(options.noise_sigma) + ": expected a standard deviation >= 0 in m");
  ExpectUsage(options.drop_fraction >= 0.0 && options.drop_fraction < 1.0,
              "drop " + ToString(options.drop_fraction) + ": expected a fraction in [0, 1)");
  const int num_free = scene.mesh.num_nodes() - static_cast<int>(scene.handles.nodes.size());
  ExpectUsage(options.num_markers >= 0 && options.num_markers <= num_free,
              "markers " + std::to_string(options.num_markers) + ": expected 0 to " + std::to_string(num_free) +
                  ", the number of free nodes");
  ExpectUsage(options.num_cloud_points >= 0 && options.num_cloud_points <= kMaxCloudPointsPerFrame,
              "cloud " + std::to_string(options.num_cloud_points) + ": expected 0 to " +
                  std::to_string(kMaxCloudPointsPerFrame) + " points per frame");
}

// Points are counted as they are in memory, in double precision.
void CheckSize(const SyntheticOptions& options, const Scene& scene, Eigen::Index num_frames) {
  const double nodes = SeesNoNodes(options)      ? 0
                       : options.num_markers > 0 ? options.num_markers
                                                 : scene.mesh.num_nodes();
  const double points = nodes + options.num_cloud_points + scene.handles.path.num_handles();
  const double bytes = points * 3.0 * sizeof(double) * static_cast<double>(num_frames);
  constexpr double kMegabyte = 1 << 20;
  ExpectUsage(bytes <= static_cast<double>(kMaxTrackBytes),
              "frame_rate " + ToString(options.frame_rate) + ": " + std::to_string(num_frames) + " frames of " +
                  ToString(points) + " points take " + std::to_string(std::llround(bytes / kMegabyte)) +
                  " MB; expected at most " + std::to_string(kMaxTrackBytes >> 20) + " MB");
}

// [3N]: the positions `steps` steps after the start, linear between steps.
Eigen::VectorXd PositionsAt(const Rollout& rollout, double steps) {
  const int before = static_cast<int>(std::floor(steps));
  const double fraction = steps - before;
  if (fraction == 0.0) return rollout.positions(before);
  return (1.0 - fraction) * rollout.positions(before) + fraction * rollout.positions(before + 1);
}

void SamplePositions(const Rollout& rollout, const Eigen::VectorXd& frame_steps, const SyntheticOptions& options,
                     MotionTensors* motion) {
  if (SeesNoNodes(options)) {
    motion->positions.resize(0, frame_steps.size());
    return;
  }
  const std::vector<int>& markers = motion->node_index;
  const Eigen::Index num_coordinates =
      markers.empty() ? rollout.initial_positions.size() : 3 * static_cast<Eigen::Index>(markers.size());
  motion->positions.resize(num_coordinates, frame_steps.size());
  for (Eigen::Index frame = 0; frame < frame_steps.size(); ++frame) {
    const Eigen::VectorXd positions = PositionsAt(rollout, frame_steps[frame]);
    if (markers.empty()) {
      motion->positions.col(frame) = positions;
      continue;
    }
    for (size_t p = 0; p < markers.size(); ++p) {
      motion->positions.col(frame).segment<3>(3 * p) = positions.segment<3>(3 * markers[p]);
    }
  }
}

// Points anywhere on the surface, as many per rest area everywhere; with noise, some left out.
Eigen::Matrix3Xd SeeCloud(const Scene& scene, const Eigen::VectorXd& nodes, const SyntheticOptions& options,
                          std::discrete_distribution<int>* faces, std::mt19937_64* generator) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::bernoulli_distribution drop(options.drop_fraction);
  Eigen::Matrix3Xd cloud(3, options.num_cloud_points);
  Eigen::Index num_seen = 0;
  for (int i = 0; i < options.num_cloud_points; ++i) {
    const Eigen::Vector3i corners = scene.mesh.faces.col((*faces)(*generator));
    const double root = std::sqrt(uniform(*generator)), along = uniform(*generator);
    const Eigen::Vector3d weights(1.0 - root, root * (1.0 - along), root * along);
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) point += weights[k] * nodes.segment<3>(3 * corners[k]);
    for (double& coordinate : point) coordinate += options.noise_sigma * noise(*generator);
    if (!drop(*generator)) cloud.col(num_seen++) = point;
  }
  return cloud.leftCols(num_seen);
}

void AddClouds(const Rollout& rollout, const Scene& scene, const Eigen::VectorXd& frame_steps,
               const SyntheticOptions& options, MotionTensors* motion) {
  if (!HasCloud(options)) return;
  const Eigen::VectorXd areas = TriangleAreas(scene.mesh);
  std::discrete_distribution<int> faces(areas.begin(), areas.end());
  std::mt19937_64 generator = MakeGenerator(options.seed, Stream::kCloud);
  for (const double steps : frame_steps) {
    motion->clouds.push_back(SeeCloud(scene, PositionsAt(rollout, steps), options, &faces, &generator));
  }
  motion->cloud_sigma = options.noise_sigma;
  motion->single_precision_clouds = options.single_precision;
}

void AddNoise(const SyntheticOptions& options, MotionTensors* motion) {
  if (options.noise_sigma == 0.0 || motion->positions.size() == 0) return;
  std::mt19937_64 generator = MakeGenerator(options.seed, Stream::kNoise);
  std::normal_distribution<double> noise(0.0, options.noise_sigma);
  for (double& coordinate : motion->positions.reshaped()) coordinate += noise(generator);
  motion->sigma = Eigen::VectorXd::Constant(motion->positions.rows() / 3, options.noise_sigma);
}

void DropPoints(const SyntheticOptions& options, MotionTensors* motion) {
  if (options.drop_fraction == 0.0) return;
  std::mt19937_64 generator = MakeGenerator(options.seed, Stream::kDrops);
  std::bernoulli_distribution drop(options.drop_fraction);
  for (auto point : motion->positions.reshaped(3, motion->positions.size() / 3).colwise()) {
    if (drop(generator)) point.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
}

std::string RecordingText(const Scene& scene, const std::string& scene_text, const SyntheticOptions& options) {
  bool start_is_first_frame = false;
  const std::string text = SelfContainedText(scene, scene_text, &start_is_first_frame);
  ExpectUsage(
      !start_is_first_frame || (options.num_markers == 0 && !HasCloud(options) && options.drop_fraction == 0.0),
      "scene: key 'initial.positions': a recording has no start that is read from a file; its first frame, with "
      "every point, takes its place, so neither markers, clouds nor drops");
  return text;
}

std::string Provenance(const SyntheticOptions& options) {
  std::ostringstream text;
  text << "synthetic: noise " << options.noise_sigma << " m, frame rate ";
  if (options.frame_rate > 0.0) {
    text << options.frame_rate << " Hz";
  } else {
    text << "of the steps";
  }
  text << ", drop fraction " << options.drop_fraction << ", markers ";
  if (options.num_markers > 0) {
    text << options.num_markers;
  } else {
    text << (SeesNoNodes(options) ? "none" : "at all nodes");
  }
  if (HasCloud(options)) text << ", clouds of " << options.num_cloud_points << " points";
  if (options.force_sensor) text << ", forces with noise " << options.force_sensor->sigma << " N";
  text << ", seed " << options.seed;
  return text.str();
}

}  // namespace

Eigen::VectorXd FrameSteps(double frame_rate, double time_step, int num_steps) {
  ExpectUsage(std::isfinite(frame_rate) && frame_rate >= 0.0,
              "frame_rate " + ToString(frame_rate) + ": expected a rate >= 0 in Hz");
  const double stride = frame_rate > 0.0 ? 1.0 / (frame_rate * time_step) : 1.0;
  ExpectUsage(stride <= num_steps, "frame_rate " + ToString(frame_rate) + ": expected at least two frames in " +
                                       ToString(num_steps * time_step) + " s");
  ExpectUsage(num_steps / stride < kMaxFrames,
              "frame_rate " + ToString(frame_rate) + ": expected at most " + std::to_string(kMaxFrames) + " frames");
  const auto num_frames = static_cast<Eigen::Index>(std::floor(num_steps / stride + kSameStep)) + 1;
  Eigen::VectorXd steps(num_frames);
  for (Eigen::Index frame = 0; frame < num_frames; ++frame) {
    const double exact = static_cast<double>(frame) * stride;
    const double whole = std::round(exact);
    steps[frame] = std::abs(exact - whole) <= kSameStep ? whole : exact;
  }
  return steps;
}

std::vector<int> ChooseMarkers(const Scene& scene, int num_markers, std::uint64_t seed) {
  std::vector<int> markers;
  if (num_markers == 0) return markers;
  const std::vector<int> free = FreeNodes(scene);
  std::mt19937_64 generator = MakeGenerator(seed, Stream::kMarkers);
  std::sample(free.begin(), free.end(), std::back_inserter(markers), num_markers, generator);
  return markers;
}

void CheckSyntheticOptions(const SyntheticOptions& options, const Scene& scene, const std::string& scene_text) {
  CheckRanges(options, scene);
  CheckSize(options, scene, FrameSteps(options.frame_rate, scene.time_step, scene.num_steps()).size());
  RecordingText(scene, scene_text, options);
}

MotionTensors RecordRollout(const Rollout& rollout, const Scene& scene, const std::string& scene_text,
                            const SyntheticOptions& options) {
  CheckRanges(options, scene);
  const Eigen::VectorXd frame_steps = FrameSteps(options.frame_rate, scene.time_step, rollout.num_steps());
  CheckSize(options, scene, frame_steps.size());
  MotionTensors motion;
  motion.times = scene.start_time + (scene.time_step * frame_steps.array());
  motion.single_precision = options.single_precision;
  motion.mesh = scene.mesh;
  motion.node_index = ChooseMarkers(scene, options.num_markers, options.seed);
  motion.scene_text = RecordingText(scene, scene_text, options);
  motion.provenance = Provenance(options);
  SamplePositions(rollout, frame_steps, options, &motion);
  AddClouds(rollout, scene, frame_steps, options, &motion);
  SetHandlePaths(scene.handles, &motion);
  motion.sequences = SequencesOf(scene);
  if (options.force_sensor) {
    const double rate = options.force_sensor->rate;
    const Eigen::VectorXd steps = rate == 0.0 ? frame_steps : FrameSteps(rate, scene.time_step, rollout.num_steps());
    motion.forces = ReadForceSensor(*options.force_sensor, rollout, scene, steps, options.seed);
  }
  AddNoise(options, &motion);
  DropPoints(options, &motion);
  return motion;
}

MotionTensors RecordFrames(const Eigen::MatrixXd& positions, const Eigen::VectorXd& times, const Scene& scene,
                           const std::string& scene_text, const std::string& provenance) {
  MotionTensors motion;
  motion.times = times;
  motion.positions = positions;
  motion.single_precision = false;
  motion.mesh = scene.mesh;
  motion.scene_text = RecordingText(scene, scene_text, {});
  motion.provenance = provenance;
  SetHandlePaths(scene.handles, &motion);
  motion.sequences = SequencesOf(scene);
  return motion;
}

}  // namespace clothid
