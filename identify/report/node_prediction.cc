#include "identify/report/node_prediction.h"

#include <utility>

#include "costs/prediction/alignment.h"
#include "costs/prediction/recording_model.h"
#include "costs/prediction/rollout_cost_options.h"
#include "identify/report/report_replay.h"

namespace clothid {
namespace {

// The same frames, with all nodes in place of the observed points.
RecordedMotion WithAllNodes(RecordedMotion motion) {
  const int num_nodes = motion.scene.mesh.num_nodes();
  motion.centroid = TurnCenter(motion);
  motion.points.assign(static_cast<std::size_t>(num_nodes), ObservedPoint());
  for (int node = 0; node < num_nodes; ++node) motion.points[static_cast<std::size_t>(node)].nodes[0] = node;
  motion.positions = Eigen::MatrixXd::Zero(3 * num_nodes, motion.num_frames());
  motion.sigma.resize(0);
  return motion;
}

}  // namespace

std::vector<Eigen::MatrixXd> PredictNodes(const std::vector<RecordedMotion>& motions, const FitProblem& problem,
                                          const FitSummary& summary) {
  std::vector<Eigen::MatrixXd> predicted(motions.size());
  for (int r = 0; r < problem.num_recordings(); ++r) {
    const RecordedMotion& motion = motions[static_cast<std::size_t>(r)];
    if (PointsAreNodes(motion) || !motion.clouds.empty()) continue;
    const RecordingModel& fitted = problem.cost(r).model();
    RecordingModel model(WithAllNodes(motion), fitted.blocks(), {}, fitted.shared_start(), problem.fields());
    Eigen::MatrixXd nodes;
    const Rollout rollout = model.Simulate(problem.CoordinatesOf(r, summary.coordinates), {}, {}, &nodes);
    if (rollout.ok()) predicted[static_cast<std::size_t>(r)] = nodes;
  }
  return predicted;
}

namespace {

// Of every recording, as in a `FitPoint`.
struct UncorrectedPrediction {
  std::vector<Eigen::MatrixXd> points, forces;
  PredictionError error;
};

std::optional<UncorrectedPrediction> PredictUncorrectedAt(const std::vector<RecordedMotion>& motions,
                                                          const FitProblem& problem,
                                                          const Eigen::VectorXd& coordinates) {
  UncorrectedPrediction prediction;
  for (int r = 0; r < problem.num_recordings(); ++r) {
    const RecordingModel& fitted = problem.cost(r).model();
    RecordingModel model(motions[static_cast<std::size_t>(r)], fitted.blocks(), {}, fitted.shared_start(),
                         problem.fields());
    ForceTrack forces;
    const Rollout rollout = model.Simulate(problem.CoordinatesOf(r, coordinates), {}, {},
                                           &prediction.points.emplace_back(), /*velocities=*/nullptr, &forces);
    if (!rollout.ok()) return std::nullopt;
    prediction.error += model.observation().Compare(prediction.points.back(), forces.predicted);
    prediction.forces.push_back(std::move(forces.predicted));
  }
  return prediction;
}

}  // namespace

std::optional<PredictionError> PredictUncorrected(const std::vector<RecordedMotion>& motions, const FitProblem& problem,
                                                  FitSummary* summary) {
  if (!summary->assimilation.is_on()) return std::nullopt;
  std::optional<UncorrectedPrediction> end = PredictUncorrectedAt(motions, problem, summary->coordinates);
  std::optional<UncorrectedPrediction> start = PredictUncorrectedAt(motions, problem, problem.StartCoordinates());
  if (!end || !start) return std::nullopt;
  summary->predicted = std::move(end->points);
  summary->forces = std::move(end->forces);
  summary->start_predicted = std::move(start->points);
  return end->error;
}

}  // namespace clothid
