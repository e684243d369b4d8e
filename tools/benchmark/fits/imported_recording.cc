#include "tools/benchmark/fits/imported_recording.h"

#include <Eigen/Core>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <random>
#include <utility>

#include "datasets/motion/motion_file.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/scene/refinement.h"

namespace clothid {
namespace {

// A frame this little before the cut, in steps, is at the cut: both are rounded numbers.
constexpr double kSameStep = 1e-6;

// Of the first frame at the cut or after it; the number of frames where there is none. `times` [T] ascend.
Eigen::Index FirstFrame(const Eigen::VectorXd& times, const ImportOfRollout& import, const Scene& scene) {
  const double begin = scene.start_time + import.cut - kSameStep * scene.time_step;
  return (times.array() < begin).count();
}

void DropFrames(Eigen::Index num_dropped, MotionTensors* tensors) {
  const Eigen::Index num_frames = tensors->times.size() - num_dropped;
  tensors->times = tensors->times.tail(num_frames).eval();
  tensors->positions = tensors->positions.rightCols(num_frames).eval();
  // `RecordRollout` samples the path of handles at the frames.
  if (!tensors->handle_index.empty()) {
    tensors->handle_positions = tensors->handle_positions.rightCols(num_frames).eval();
  }
  ForceReadings& forces = tensors->forces;
  const Eigen::Index num_readings = (forces.times.array() >= tensors->times[0]).count();
  forces.times = forces.times.tail(num_readings).eval();
  forces.values = forces.values.rightCols(num_readings).eval();
}

// Not the noise of the points, whose generator starts from the seed itself.
constexpr std::uint64_t kHandleStream = 0x68616e64;

void AddHandleNoise(double sigma, std::uint64_t seed, MotionTensors* tensors) {
  if (sigma == 0.0) return;
  std::mt19937_64 generator(seed ^ kHandleStream);
  std::normal_distribution<double> noise(0.0, sigma);
  for (double& coordinate : tensors->handle_positions.reshaped()) coordinate += noise(generator);
}

// The text of a scene that says nothing of what the recording has to tell.
std::string OpenText(const std::string& scene_text, const ImportOfRollout& import) {
  nlohmann::ordered_json scene = nlohmann::ordered_json::parse(scene_text);
  if (import.start != StartSource::kScene) scene.erase("initial");
  if (import.cut > 0.0) scene.erase("duration");
  return scene.dump();
}

}  // namespace

void CheckImport(const ImportOfRollout& import, const SyntheticOptions& options, const Scene& scene,
                 const std::string& scene_text) {
  CheckSyntheticOptions(options, scene, scene_text);
  if (import.handle_sigma > 0.0 && scene.handles.path.times().size() < 2) {
    throw Error(ErrorKind::kUsage, "--handle_sigma: expected a scene whose handles have a path");
  }
  const Eigen::VectorXd steps = FrameSteps(options.frame_rate, scene.time_step, scene.num_steps());
  const Eigen::VectorXd times = scene.start_time + scene.time_step * steps.array();
  if (times.size() - FirstFrame(times, import, scene) >= 2) return;
  throw Error(ErrorKind::kUsage, "--cut: " + ShortestText(import.cut) +
                                     " s: expected at least two frames after it, of " + std::to_string(times.size()) +
                                     " in " + ShortestText(times[times.size() - 1] - times[0]) + " s");
}

RecordedMotion ImportRollout(const ImportOfRollout& import, const Rollout& rollout, const Scene& scene,
                             const std::string& scene_text, const SyntheticOptions& options) {
  MotionTensors tensors = RecordRollout(rollout, scene, scene_text, options);
  DropFrames(FirstFrame(tensors.times, import, scene), &tensors);
  AddHandleNoise(import.handle_sigma, options.seed, &tensors);
  ReadMotionOptions reading;
  // `kScene`: nothing is left open, as the text in a recording has its start.
  if (import.start != StartSource::kScene) reading.start = import.start;
  reading.change_scene = [&](const std::string& text) { return OpenText(text, import); };
  return InterpretMotion(std::move(tensors), "recording", reading);
}

Rollout SampleTruth(const std::vector<TrueParameter>& truth, const std::string& source, const Scene& scene,
                    const TruthResolution& resolution) {
  constexpr int kFewSteps = 20;  // kept at a time, for memory's sake
  Scene fine = scene;
  for (int level = 0; level < resolution.levels; ++level) {
    ExpectRefinable(fine, source);
    fine = RefineScene(fine, RefineMesh(fine.mesh));
  }
  fine.time_step /= resolution.steps;
  const Eigen::Index size = 3 * static_cast<Eigen::Index>(scene.mesh.num_nodes());
  Rollout sampled;
  RolloutOptions options;
  options.checkpoint_interval = kFewSteps;
  options.visitor = [&](int step, const Eigen::VectorXd& positions) {
    if (step == 0 || step % resolution.steps != 0) return;
    StepRecord record;
    record.time_step = scene.time_step;
    record.time = scene.start_time + step * fine.time_step;
    record.positions = positions.head(size);
    sampled.last_record.push_back(static_cast<int>(sampled.records.size()));
    sampled.records.push_back(std::move(record));
  };
  const Rollout rollout = SimulateTruth(truth, source, fine, options);
  sampled.parameters = rollout.parameters;
  sampled.start_time = rollout.start_time;
  sampled.time_step = scene.time_step;
  sampled.initial_positions = rollout.initial_positions.head(size);
  sampled.initial_velocities = rollout.initial_velocities.head(size);
  return sampled;
}

}  // namespace clothid
