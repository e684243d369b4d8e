#include "datasets/synthetic/sensor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "sim/base/error.h"
#include "sim/base/json_document.h"

namespace clothid {
namespace {

// Bounds against slips of the pen.
constexpr double kShortestInterval = 1e-5;  // s
constexpr std::size_t kMaxGaps = 1000;
// A rotation is given with the digits that its writer had.
constexpr double kUnitTolerance = 1e-3;

enum class SensorStream : std::uint32_t { kTimes, kNoise, kDrops, kOutliers, kFlips, kGripper };

std::mt19937_64 MakeSensorGenerator(std::uint64_t seed, SensorStream stream) {
  constexpr std::uint32_t kSensor = 0x5e50;  // apart from the streams of datasets/synthetic/synthetic.cc
  std::seed_seq sequence{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32), kSensor,
                         static_cast<std::uint32_t>(stream)};
  return std::mt19937_64(sequence);
}

double Fraction(const JsonNode& node) {
  const double value = node.NonNegativeNumber();
  if (!(value < 1.0)) node.Fail("expected a fraction in [0, 1)");
  return value;
}

Eigen::Isometry3d ParsePose(const JsonNode& node) {
  node.ExpectKeys({"rotation", "translation"});
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  if (const auto rotation = node.Find("rotation")) {
    const std::vector<JsonNode> items = rotation->items();
    if (items.size() != 4) rotation->Fail("expected a quaternion [x, y, z, w]");
    Eigen::Quaterniond quaternion(items[3].Number(), items[0].Number(), items[1].Number(), items[2].Number());
    if (!(std::abs(quaternion.norm() - 1.0) <= kUnitTolerance)) rotation->Fail("expected a quaternion of length 1");
    pose.linear() = quaternion.normalized().toRotationMatrix();
  }
  if (const auto translation = node.Find("translation")) pose.translation() = translation->Vector3();
  return pose;
}

std::array<double, 2> ParseInterval(const JsonNode& node) {
  const std::vector<JsonNode> items = node.items();
  if (items.size() != 2) node.Fail("expected [least, most] in s");
  const std::array<double, 2> interval = {items[0].PositiveNumber(), items[1].PositiveNumber()};
  if (interval[0] < kShortestInterval || interval[1] < interval[0]) {
    node.Fail("expected [least, most] in s, at least 1e-5 and in this order");
  }
  return interval;
}

std::vector<SensorGap> ParseGaps(const JsonNode& node) {
  std::vector<SensorGap> gaps;
  for (const JsonNode& item : node.items()) {
    item.ExpectKeys({"after", "length"});
    gaps.push_back(
        {item.Require("after", "a time in s").Number(), item.Require("length", "a time in s").NonNegativeNumber()});
  }
  if (gaps.size() > kMaxGaps) node.Fail("expected at most " + std::to_string(kMaxGaps) + " gaps");
  return gaps;
}

void ParseGripper(const JsonNode& node, Sensor* sensor) {
  node.ExpectKeys({"rate", "noise", "clock_offset"});
  if (const auto rate = node.Find("rate")) {
    sensor->gripper_rate = rate->PositiveNumber();
    if (sensor->gripper_rate > 1.0 / kShortestInterval) rate->Fail("expected a rate of at most 1e5 Hz");
  }
  if (const auto noise = node.Find("noise")) sensor->gripper_noise = noise->NonNegativeNumber();
  if (const auto offset = node.Find("clock_offset")) sensor->gripper_clock_offset = offset->Number();
}

void ParseForces(const JsonNode& node, Sensor* sensor) {
  node.ExpectKeys({"rate", "noise", "bias", "clock_offset"});
  ForceSensor& forces = sensor->force_sensor.emplace();
  const JsonNode rate = node.Require("rate", "readings per second, Hz");
  forces.rate = rate.PositiveNumber();
  if (forces.rate > 1.0 / kShortestInterval) rate.Fail("expected a rate of at most 1e5 Hz");
  if (const auto noise = node.Find("noise")) forces.sigma = noise->NonNegativeNumber();
  if (const auto bias = node.Find("bias")) forces.bias = bias->Vector3();
  if (const auto offset = node.Find("clock_offset")) sensor->force_clock_offset = offset->Number();
}

// Times on the scene's clock.
std::vector<double> FrameTimes(const Sensor& sensor, const SeenMotion& motion, std::uint64_t seed) {
  std::mt19937_64 generator = MakeSensorGenerator(seed, SensorStream::kTimes);
  std::uniform_real_distribution<double> interval(sensor.interval[0], sensor.interval[1]);
  std::vector<double> times;
  for (double time = motion.start; time <= motion.end; time += interval(generator)) {
    const bool in_gap = std::any_of(sensor.gaps.begin(), sensor.gaps.end(), [time](const SensorGap& gap) {
      return time > gap.after && time < gap.after + gap.length;
    });
    if (!in_gap) times.push_back(time);
  }
  if (times.size() < 2) throw Error(ErrorKind::kUsage, "the sensor sees less than two frames of the motion");
  return times;
}

// The rows of the grid in reverse order, in frames other than the first.
void FlipFrames(const Sensor& sensor, const std::array<int, 2>& grid, std::uint64_t seed, PointTracks* tracks) {
  if (sensor.num_flipped_frames == 0) return;
  if (sensor.num_flipped_frames >= tracks->num_frames()) {
    throw Error(ErrorKind::kUsage, "the sensor flips " + std::to_string(sensor.num_flipped_frames) +
                                       " frames but sees " + std::to_string(tracks->num_frames()));
  }
  std::vector<int> later(static_cast<std::size_t>(tracks->num_frames()) - 1), flipped;
  std::iota(later.begin(), later.end(), 1);
  std::mt19937_64 generator = MakeSensorGenerator(seed, SensorStream::kFlips);
  std::sample(later.begin(), later.end(), std::back_inserter(flipped), sensor.num_flipped_frames, generator);
  for (const int frame : flipped) {
    const Eigen::VectorXd points = tracks->positions.col(frame);
    for (int j = 0; j < grid[1]; ++j) {
      const Eigen::Index row = 3 * static_cast<Eigen::Index>(grid[0]);
      tracks->positions.col(frame).segment(j * row, row) = points.segment((grid[1] - 1 - j) * row, row);
    }
  }
}

void Disturb(const Sensor& sensor, std::uint64_t seed, PointTracks* tracks) {
  std::mt19937_64 noise_generator = MakeSensorGenerator(seed, SensorStream::kNoise);
  std::mt19937_64 outlier_generator = MakeSensorGenerator(seed, SensorStream::kOutliers);
  std::mt19937_64 drop_generator = MakeSensorGenerator(seed, SensorStream::kDrops);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> chance;
  const auto random_vector = [&normal](std::mt19937_64* generator) {
    Eigen::Vector3d vector;
    for (double& coordinate : vector) coordinate = normal(*generator);
    return vector;
  };
  for (Eigen::Index i = 0; i < tracks->positions.size() / 3; ++i) {
    auto point = tracks->positions.reshaped(3, tracks->positions.size() / 3).col(i);
    const Eigen::Vector3d noise = random_vector(&noise_generator), offset = random_vector(&outlier_generator);
    const bool is_outlier = chance(outlier_generator) < sensor.outlier_fraction;
    const bool is_dropped = chance(drop_generator) < sensor.drop_fraction;
    point += sensor.noise.cwiseProduct(noise);
    const bool in_first_frame = i < tracks->num_points();
    if (in_first_frame) continue;
    if (is_outlier) point += sensor.outlier_distance * offset;
    if (is_dropped) point.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
}

}  // namespace

Sensor ParseSensor(const std::string& text, const std::string& source) {
  const JsonValue value = ParseJson(text, source);
  const JsonNode root(value, source);
  root.ExpectKeys({"clothid_sensor", "pose", "clock_offset", "interval", "gaps", "noise", "drop_fraction",
                   "outlier_fraction", "outlier_distance", "flipped_frames", "gripper", "forces"});
  root.Require("clothid_sensor", "the version of the format, 1").Integer(1, 1);
  Sensor sensor;
  if (const auto node = root.Find("pose")) sensor.pose = ParsePose(*node);
  if (const auto node = root.Find("clock_offset")) sensor.clock_offset = node->Number();
  if (const auto node = root.Find("interval")) sensor.interval = ParseInterval(*node);
  if (const auto node = root.Find("gaps")) sensor.gaps = ParseGaps(*node);
  if (const auto node = root.Find("noise")) {
    sensor.noise = node->Vector3();
    if (!(sensor.noise.minCoeff() >= 0.0)) node->Fail("expected standard deviations >= 0 in m");
  }
  if (const auto node = root.Find("drop_fraction")) sensor.drop_fraction = Fraction(*node);
  if (const auto node = root.Find("outlier_fraction")) sensor.outlier_fraction = Fraction(*node);
  if (const auto node = root.Find("outlier_distance")) sensor.outlier_distance = node->NonNegativeNumber();
  if (const auto node = root.Find("flipped_frames")) {
    sensor.num_flipped_frames = node->Integer(0, std::numeric_limits<int>::max());
  }
  if (const auto node = root.Find("gripper")) ParseGripper(*node, &sensor);
  if (const auto node = root.Find("forces")) ParseForces(*node, &sensor);
  return sensor;
}

PointTracks SeePoints(const Sensor& sensor, const SeenMotion& motion, std::uint64_t seed) {
  const std::vector<double> times = FrameTimes(sensor, motion, seed);
  const Eigen::Isometry3d to_camera = sensor.pose.inverse();
  PointTracks tracks;
  tracks.name = "sensor";
  tracks.times.resize(static_cast<Eigen::Index>(times.size()));
  tracks.positions.resize(3 * static_cast<Eigen::Index>(motion.grid[0]) * motion.grid[1], tracks.times.size());
  for (std::size_t frame = 0; frame < times.size(); ++frame) {
    tracks.times[static_cast<Eigen::Index>(frame)] = times[frame] + sensor.clock_offset;
    const Eigen::VectorXd points = motion.points_at(times[frame]);
    const Eigen::Map<const Eigen::Matrix3Xd> in_scene(points.data(), 3, points.size() / 3);
    const Eigen::Matrix3Xd in_camera = (to_camera.linear() * in_scene).colwise() + to_camera.translation();
    tracks.positions.col(static_cast<Eigen::Index>(frame)) = in_camera.reshaped();
  }
  Disturb(sensor, seed, &tracks);
  FlipFrames(sensor, motion.grid, seed, &tracks);
  return tracks;
}

PointTracks SeeHandles(const Sensor& sensor, const HandlePath& path, double start, double end, std::uint64_t seed) {
  constexpr int kMarginSamples = 2;
  const int num_samples = static_cast<int>(std::ceil((end - start) * sensor.gripper_rate)) + 1 + 2 * kMarginSamples;
  std::mt19937_64 generator = MakeSensorGenerator(seed, SensorStream::kGripper);
  std::normal_distribution<double> noise(0.0, 1.0);
  PointTracks tracks;
  tracks.name = "gripper";
  tracks.times.resize(num_samples);
  tracks.positions.resize(3 * static_cast<Eigen::Index>(path.num_handles()), num_samples);
  for (int i = 0; i < num_samples; ++i) {
    const double time = start + (i - kMarginSamples) / sensor.gripper_rate;
    tracks.times[i] = time + sensor.gripper_clock_offset;
    tracks.positions.col(i) = path.At(time);
  }
  for (double& coordinate : tracks.positions.reshaped()) coordinate += sensor.gripper_noise * noise(generator);
  return tracks;
}

}  // namespace clothid
