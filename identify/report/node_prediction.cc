#include "identify/report/node_prediction.h"

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

}  // namespace clothid
