#include "identify/checks/holdout.h"

#include <charconv>
#include <map>

#include "costs/prediction/recording_model.h"
#include "costs/prediction/rollout_cost_options.h"
#include "datasets/observation/observation.h"
#include "identify/problem/problem_blocks.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr double kUnseen = std::numeric_limits<double>::quiet_NaN();

// Of all rollouts at the estimates, or at the nominal values.
struct PredictionSum {
  PredictionError error;
  double cost = 0.0;
  std::string failure;  // of the first that failed
};

// Adds the error of one rollout, or tells why there is none.
void AddError(const Eigen::VectorXd& coordinates, const RobustLoss& loss, RecordingModel* model, PredictionSum* sum) {
  Eigen::MatrixXd predicted;
  ForceTrack forces;
  const Rollout rollout = model->Simulate(coordinates, {}, {}, &predicted, /*velocities=*/nullptr, &forces);
  if (rollout.ok()) {
    sum->error += model->observation().Compare(predicted, forces.predicted);
    Eigen::VectorXd weights;
    const Eigen::VectorXd residuals = model->observation().Residuals(predicted, forces.predicted);
    sum->cost += LossWeights(loss, model->observation(), 0, residuals, &weights);
  } else if (sum->failure.empty()) {
    sum->failure = model->name() + ": " + rollout.failure->ToString();
  }
}

// Leaves the forces of the frames for which `keeps` is true.
template <typename Keeps>
void KeepForces(const Keeps& keeps, RecordedMotion* motion) {
  if (motion->forces.is_empty()) return;
  const ForceObservation observation(*motion);
  for (int i = 0; i < observation.num_readings(); ++i) {
    if (!keeps(observation.nearest_frame(i))) motion->forces.values.col(i).setConstant(kUnseen);
  }
  if (motion->forces.values.array().isNaN().all()) motion->forces = ForceReadings();
}

// Adds the block of recording `block.recording` as one of `held`, which all recordings have in common.
void AddLikeFitted(ParameterBlock block, double coordinate, std::map<std::string, int>* counts, HeldOutBlocks* held) {
  block.name = BaseName(block.name);
  block.recording = kEveryRecording;
  int& count = (*counts)[block.name];
  if (++count == 1) {
    held->blocks.push_back(block);
    held->coordinates.conservativeResize(held->coordinates.size() + 1);
    held->coordinates.tail(1)[0] = coordinate;
    return;
  }
  for (std::size_t i = 0; i < held->blocks.size(); ++i) {
    if (held->blocks[i].name != block.name) continue;
    double& mean = held->coordinates[static_cast<Eigen::Index>(i)];
    mean += (coordinate - mean) / count;
  }
}

std::optional<int> ParseFrame(std::string_view text) {
  int frame = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), frame);
  if (error != std::errc() || end != text.data() + text.size() || frame < 0) return std::nullopt;
  return frame;
}

}  // namespace

HeldOutBlocks BlocksFor(const RecordedMotion& motion, int recording, const std::vector<ParameterBlock>& blocks,
                        const Eigen::VectorXd& values, std::optional<int> like) {
  HeldOutBlocks held;
  std::map<std::string, int> counts;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const ParameterBlock& block = blocks[i];
    const double coordinate = block.ToCoordinate(values[static_cast<Eigen::Index>(i)]);
    const bool is_like = recording < 0 && block.recording != kEveryRecording;
    if (!Concerns(block, motion, is_like ? block.recording : recording)) continue;
    if (is_like) {
      if (!like || *like == block.recording) AddLikeFitted(block, coordinate, &counts, &held);
      continue;
    }
    held.blocks.push_back(block);
    held.coordinates.conservativeResize(held.coordinates.size() + 1);
    held.coordinates.tail(1)[0] = coordinate;
  }
  return held;
}

Eigen::VectorXd WithStart(const Eigen::VectorXd& coordinates, const HeldOutStart& start) {
  Eigen::VectorXd all(coordinates.size() + start.unknowns.size());
  all << coordinates, start.unknowns;
  return all;
}

Holdout EvaluateHoldout(const std::vector<RecordedMotion>& motions, const std::vector<ParameterBlock>& blocks,
                        const Eigen::VectorXd& values, HeldOut held_out, const std::vector<HeldOutStart>& starts,
                        const RobustLoss& loss, LeadTimes* ahead) {
  PredictionSum at_nominal, at_estimate;
  for (std::size_t r = 0; r < motions.size(); ++r) {
    const RecordedMotion& motion = motions[r];
    const HeldOutStart start = starts.empty() ? HeldOutStart() : starts[r];
    RecordingModel nominal(motion, {}, {}, start.start);
    AddError(WithStart(Eigen::VectorXd(), start), loss, &nominal, &at_nominal);
    const int recording = held_out == HeldOut::kFrames ? static_cast<int>(r) : -1;
    const HeldOutBlocks own = BlocksFor(motion, recording, blocks, values);
    RecordingModel model(motion, own.blocks, {}, start.start);
    AddError(WithStart(own.coordinates, start), loss, &model, &at_estimate);
    if (ahead != nullptr) ahead->Add(motion, WithStart(own.coordinates, start), &model);
  }
  Holdout holdout;
  if (at_nominal.failure.empty()) {
    holdout.nominal_rmse = at_nominal.error.rmse();
    holdout.nominal_force_rms = at_nominal.error.force.rms();
    if (loss.is_robust()) holdout.nominal_cost = at_nominal.cost;
  }
  if (at_estimate.failure.empty()) {
    holdout.rmse = at_estimate.error.rmse();
    holdout.nodes_rmse = at_estimate.error.cloud.node_rmse();
    holdout.force_rms = at_estimate.error.force.rms();
    if (loss.is_robust()) holdout.cost = at_estimate.cost;
  }
  const PredictionError& seen = at_nominal.failure.empty() ? at_nominal.error : at_estimate.error;
  holdout.has_only_forces = seen.num_coordinates + seen.cloud.num_points == 0.0 && seen.force.num_components > 0.0;
  if (ahead != nullptr) holdout.lead_times = ahead->Errors();
  holdout.failure = at_estimate.failure.empty() ? at_nominal.failure : at_estimate.failure;
  return holdout;
}

FrameRange ParseFrameRange(const std::string& text, const std::string& flag) {
  const std::size_t colon = text.find(':');
  if (colon != std::string::npos) {
    const std::optional<int> begin = ParseFrame(std::string_view(text).substr(0, colon));
    const std::optional<int> end = ParseFrame(std::string_view(text).substr(colon + 1));
    if (begin && end && *begin < *end) return {*begin, *end};
  }
  throw Error(ErrorKind::kUsage,
              flag + ": expected A:B, frames A to B - 1 with 0 <= A < B, got '" + Printable(text) + "'");
}

std::vector<RecordedMotion> HoldOutFrames(const FrameRange& range, std::vector<RecordedMotion>* motions) {
  std::vector<RecordedMotion> held;
  for (RecordedMotion& motion : *motions) {
    if (range.end > motion.num_frames()) {
      throw Error(ErrorKind::kUsage, "--holdout_frames: " + motion.name + " has the frames 0 to " +
                                         std::to_string(motion.num_frames() - 1));
    }
    const int count = range.end - range.begin;
    motion.centroid = TurnCenter(motion);
    held.push_back(motion);
    held.back().positions.leftCols(range.begin).setConstant(kUnseen);
    held.back().positions.rightCols(motion.num_frames() - range.end).setConstant(kUnseen);
    motion.positions.middleCols(range.begin, count).setConstant(kUnseen);
    for (int i = 0; i < static_cast<int>(motion.clouds.size()); ++i) {
      const bool is_held = i >= range.begin && i < range.end;
      (is_held ? motion : held.back()).clouds[i].resize(3, 0);
    }
    const auto is_held = [&range](int frame) { return frame >= range.begin && frame < range.end; };
    KeepForces(is_held, &held.back());
    KeepForces([&](int frame) { return !is_held(frame); }, &motion);
  }
  return held;
}

}  // namespace clothid
