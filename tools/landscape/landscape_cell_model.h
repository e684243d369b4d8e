// The cells of one setting of a landscape: what the recording costs at values of both axes.
#ifndef CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_CELL_MODEL_H_
#define CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_CELL_MODEL_H_

#include <Eigen/Core>
#include <atomic>
#include <map>
#include <string>

#include "costs/prediction/recording_model.h"
#include "costs/prediction/rollout_cost_options.h"
#include "datasets/motion/recorded_motion.h"
#include "identify/landscape/landscape.h"

namespace clothid {

// For one thread at a time. Coordinates of a point: the values that are held, in the order of their names, then x, y.
class LandscapeCellModel {
 public:
  // `held`, `model_error`, `assimilation`: see LandscapeScanOptions. Throws `Error` where `RecordingModel` does, and
  // (kUsage), naming --assimilate, for a recording that cannot correct its rollouts.
  LandscapeCellModel(const RecordedMotion& motion, const LandscapePlan& plan, const std::map<std::string, double>& held,
                     const ModelError& model_error, const Assimilation& assimilation);

  // `predicted` [R x T] m, see Observation; valid where the rollout is ok(). `cancel` and `forces` may be null.
  Rollout Predict(double x, double y, const std::atomic<bool>* cancel, Eigen::MatrixXd* predicted,
                  ForceTrack* forces = nullptr);

  // Puts every point of the recording's clouds onto the predicted surface, where that is nearest.
  void MoveCloudsTo(const Eigen::MatrixXd& predicted, RecordedMotion* motion) const;

  // Fills `cell`; a rollout that fails and numbers that are not finite are its failure, and leave neither cost nor
  // gradient.
  void Evaluate(const LandscapeWindow& window, double x, double y, bool has_gradients, const std::atomic<bool>* cancel,
                LandscapeCell* cell);

 private:
  Eigen::VectorXd Coordinates(double x, double y) const;
  double StartPrior() const;  // what an unknown start, which is at its base here, adds to every cost
  void PullBackCost(const LandscapeWindow& window, const Rollout& rollout, const Eigen::MatrixXd& predicted,
                    const ForceTrack& forces, const Eigen::VectorXd& cost_gradient, const Eigen::VectorXd& coordinates,
                    LandscapeCell* cell);

  RecordingModel model_;
  // As of a fit, so that rollouts beyond it get checkpoints, and with them the same rounding, here too.
  RolloutStorage storage_{RolloutCostOptions().memory_limit, /*keep_factors=*/false};
};

}  // namespace clothid

#endif  // CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_CELL_MODEL_H_
