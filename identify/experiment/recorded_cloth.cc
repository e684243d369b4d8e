#include "identify/experiment/recorded_cloth.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include "datasets/motion/motion_file.h"
#include "datasets/synthetic/synthetic.h"
#include "datasets/synthetic/true_parameters.h"
#include "sim/base/error.h"
#include "sim/rollout/simulator.h"

namespace clothid {
namespace {

// How much longer a recording might be.
constexpr double kLonger = 1.5;
// A fraction of a step by which times of frames may differ from those of steps.
constexpr double kSameStep = 1e-6;

double FrameRate(const PlanOptions& options, const Scene& scene) {
  return options.frame_rate > 0.0 ? options.frame_rate : 1.0 / scene.time_step;
}

// All nodes at twice the frame rate, and the forces on handles at the frames.
MotionTensors SeeEverything(const PlanOptions& options, const Candidate& candidate, const Scene& scene,
                            const Rollout& rollout) {
  SyntheticOptions sensor;
  sensor.frame_rate = 2.0 * FrameRate(options, scene);
  sensor.single_precision = false;
  if (!scene.handles.nodes.empty()) sensor.force_sensor.emplace().rate = FrameRate(options, scene);
  return RecordRollout(rollout, scene, candidate.text, sensor);
}

Eigen::MatrixXd RowsOfNodes(const Eigen::MatrixXd& positions, const std::vector<int>& nodes) {
  Eigen::MatrixXd rows(3 * static_cast<Eigen::Index>(nodes.size()), positions.cols());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    rows.middleRows<3>(3 * static_cast<Eigen::Index>(i)) = positions.middleRows<3>(3 * nodes[i]);
  }
  return rows;
}

// The nodes that are seen: first those of the plan, in ascending order, then as many others.
struct SeenNodes {
  std::vector<int> planned, all;
};

SeenNodes ChooseNodes(const PlanOptions& options, const Scene& scene) {
  SeenNodes seen;
  if (options.num_markers == 0) {
    seen.planned.resize(static_cast<std::size_t>(scene.mesh.num_nodes()));
    std::iota(seen.planned.begin(), seen.planned.end(), 0);
    seen.all = seen.planned;
    return seen;
  }
  seen.planned = ChooseMarkers(scene, options.num_markers, options.seed);
  seen.all = seen.planned;
  const int num_free = scene.mesh.num_nodes() - static_cast<int>(scene.handles.nodes.size());
  const std::vector<int> free = ChooseMarkers(scene, num_free, options.seed);
  std::vector<int> others;
  std::set_difference(free.begin(), free.end(), seen.planned.begin(), seen.planned.end(), std::back_inserter(others));
  std::mt19937_64 generator(options.seed);
  std::sample(others.begin(), others.end(), std::back_inserter(seen.all), options.num_markers, generator);
  return seen;
}

// The scene of a recording whose start a fit has to estimate.
std::string WithoutStart(const std::string& scene_text) {
  nlohmann::ordered_json scene = nlohmann::ordered_json::parse(scene_text);
  scene.erase("initial");
  return scene.dump();
}

// What a fit reads of the frames of the plan. `num_frames`: of them.
RecordedMotion ReadPlanned(const PlanOptions& options, const Candidate& candidate, const std::vector<int>& nodes,
                           Eigen::Index num_frames, MotionTensors tensors) {
  const Eigen::VectorXi every_second = Eigen::VectorXi::LinSpaced(num_frames, 0, 2 * static_cast<int>(num_frames) - 2);
  tensors.times = tensors.times(every_second).eval();
  tensors.positions = RowsOfNodes(tensors.positions(Eigen::all, every_second), nodes);
  tensors.node_index = nodes;
  if (!tensors.handle_index.empty()) {
    tensors.handle_positions = tensors.handle_positions(Eigen::all, every_second).eval();
  }
  tensors.forces = ForceReadings();
  ReadMotionOptions reading;
  reading.sigma_source = SigmaSource::kGiven;
  reading.sigma = options.sigma;
  reading.smooth_handles = false;
  if (IsUnknown(options.start)) {
    reading.start = options.start;
    reading.change_scene = WithoutStart;
  }
  RecordedMotion planned = InterpretMotion(std::move(tensors), candidate.path, reading);
  planned.name = candidate.name;
  return planned;
}

// Handles where they are, measured as well as they would be.
void SetHandles(const PlanOptions& options, const Scene& scene, const Eigen::VectorXd& positions,
                RecordedMotion* planned) {
  HandleMeasurements& measured = planned->handle_measurements;
  planned->scene.handles = scene.handles;
  if (!IsUnknown(planned->start_source) || scene.handles.nodes.empty()) return;
  if (scene.handles.path.num_handles() == 0) {
    if (measured.is_empty()) return;
    Eigen::VectorXd places(3 * static_cast<Eigen::Index>(scene.handles.nodes.size()));
    for (std::size_t i = 0; i < scene.handles.nodes.size(); ++i) {
      places.segment<3>(3 * static_cast<Eigen::Index>(i)) = positions.segment<3>(3 * scene.handles.nodes[i]);
    }
    planned->scene.handles.path = HandlePath(Eigen::VectorXd::Constant(1, planned->scene.start_time), places);
    measured.deviations = measured.deviations.array().isNaN().select(measured.deviations, 0.0);
    return;
  }
  measured = HandleMeasurements();
  if (options.handle_sigma == 0.0) return;
  const auto num_handles = static_cast<Eigen::Index>(scene.handles.nodes.size());
  measured.times = planned->times;
  measured.deviations = Eigen::MatrixXd::Zero(3 * num_handles, planned->times.size());
  measured.sigma = Eigen::VectorXd::Constant(num_handles, options.handle_sigma);
}

// The first `num_readings` of all readings.
ForceReadings FirstReadings(const ForceReadings& all, Eigen::Index num_readings) {
  ForceReadings first = all;
  first.times = all.times.head(num_readings);
  first.values = all.values.leftCols(num_readings);
  return first;
}

// The rollout, longer than the scene where it is to be and can be.
Rollout RunCloth(const Candidate& candidate, const Parameters& truth, const Scene& scene, bool looks_longer) {
  Simulator simulator(scene);
  const int num_steps = scene.num_steps();
  const std::atomic<bool>* const cancel = candidate.fit.cancel;
  if (looks_longer) {
    Rollout rollout = Simulate(truth, static_cast<int>(std::ceil(kLonger * num_steps)), &simulator, cancel);
    if (rollout.ok()) return rollout;
  }
  return Simulate(truth, num_steps, &simulator, cancel);
}

}  // namespace

RecordedCloth RecordCloth(const PlanOptions& options, const Candidate& candidate,
                          const std::map<std::string, double>& truth, bool looks_longer) {
  Scene scene = candidate.scene;
  const Parameters parameters = SetTrueParameters(truth, "--start", candidate.path, &scene);
  RecordedCloth cloth;
  cloth.rollout = RunCloth(candidate, parameters, scene, looks_longer);
  const Rollout& rollout = cloth.rollout;
  if (!rollout.ok()) {
    cloth.failure = rollout.failure->ToString();
    return cloth;
  }
  const double rate = FrameRate(options, scene);
  const Eigen::Index num_frames = FrameSteps(rate, scene.time_step, scene.num_steps()).size();
  const SeenNodes nodes = ChooseNodes(options, scene);
  const MotionTensors everything = SeeEverything(options, candidate, scene, rollout);
  cloth.is_longer = rollout.num_steps() > scene.num_steps();
  RecordedMotion& planned = cloth.planned;
  planned = ReadPlanned(options, candidate, nodes.planned, num_frames, everything);
  cloth.nodes = everything.positions(Eigen::all, Eigen::seqN(0, num_frames, 2)).cast<float>();
  planned.scene.initial_positions = rollout.initial_positions;
  planned.scene.initial_velocities = rollout.initial_velocities;
  SetHandles(options, scene, rollout.initial_positions, &planned);
  cloth.all = planned;
  RecordedMotion& all = cloth.all;
  const double end = scene.start_time + scene.num_steps() * scene.time_step * (1.0 + kSameStep);
  const Eigen::Index num_all = cloth.is_longer ? everything.times.size() : (everything.times.array() <= end).count();
  all.times = everything.times.head(num_all);
  all.positions = RowsOfNodes(everything.positions.leftCols(num_all), nodes.all);
  all.points.resize(nodes.all.size());
  for (std::size_t i = 0; i < nodes.all.size(); ++i) all.points[i].nodes[0] = nodes.all[i];
  all.sigma = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(nodes.all.size()), options.sigma);
  all.forces = everything.forces;
  all.forces.sigma.setConstant(options.force_sigma);
  if (options.has_forces && !all.forces.is_empty()) planned.forces = FirstReadings(all.forces, num_frames);
  return cloth;
}

}  // namespace clothid
