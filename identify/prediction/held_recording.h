// A recording that is looked at without a fit of it: its rollouts with parameters, forces and starts that are drawn, or
// of the estimates. Internal to identify/prediction.
#ifndef CLOTHID_IDENTIFY_PREDICTION_HELD_RECORDING_H_
#define CLOTHID_IDENTIFY_PREDICTION_HELD_RECORDING_H_

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "costs/prediction/recording_model.h"
#include "costs/start/start_spread.h"
#include "datasets/motion/recorded_motion.h"
#include "identify/checks/holdout.h"
#include "identify/prediction/held_bands.h"
#include "identify/prediction/posterior.h"
#include "identify/prediction/random_force.h"

namespace clothid {

// The rows of a residual that are judged, their standard deviations and their times after the start of the scene.
struct JudgedRows {
  std::vector<int> rows;
  Eigen::VectorXd sigma, leads;
  bool are_forces = false;  // no position was seen
};

class HeldRecording {
 public:
  // The recording number `number` of those that are looked at, number `recording` of the fit or -1. Keeps references.
  HeldRecording(const RecordedMotion& motion, int number, int recording, const HeldOutStart& start,
                const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& values, const FitPosterior& posterior,
                const HeldBandOptions& options);

  const JudgedRows& judged() const { return judged_; }
  bool has_force() const { return force_ != nullptr; }

  // Residuals [m] over sigma, with noise where the recording knows it, and so many times the force; empty: the rollout
  // failed.
  Eigen::VectorXd Roll(int draw, double force_factor) const;
  // Likewise of the estimates, without noise; `force`: what is added to them, draw `draw` of it, or null.
  Eigen::VectorXd RollEstimate(const ForceSource* force, int draw, Precision precision) const;
  // Of a cloth that stays where it starts, as it is predicted in the first frame.
  Eigen::VectorXd RollStill() const;
  // What half the step and a mesh of twice the density change of residuals [m x 2]; zero where that is not known.
  Eigen::MatrixXd RollFiner() const;

  // Forces of these `parts` on its cloth.
  ForceSource Lacking(const std::vector<LastingForce>& parts) const;
  // Of the recording that knows its noise the variance of a residual over sigma, 1; else 0.
  double noise_variance() const { return sigma_is_known_ ? 1.0 : 0.0; }

 private:
  Eigen::Index IndexOfBlock(const std::string& name) const;
  int StreamOf(int draw) const { return number_ * options_.num_draws + draw; }
  // The unknowns of the start: those that the fit has estimated, or draws about where it was taken to be, as far off as
  // fitted ones were and handles as far as they were measured.
  Eigen::VectorXd StartOf(int stream) const;
  // `is_still`: as of `RollStill`.
  Eigen::VectorXd ResidualsOf(const HeldOutBlocks& own, const HeldOutStart& start, RecordingModel* model,
                              bool is_still = false, Precision precision = Precision::kFull) const;
  Eigen::VectorXd RollWithout(const RecordedMotion& motion, const HeldOutStart& start,
                              const ForceSource* force = nullptr, int draw = 0,
                              Precision precision = Precision::kFull) const;
  Eigen::VectorXd RollRefined() const;

  const RecordedMotion& motion_;
  int number_, recording_;
  HeldOutStart start_;
  const std::vector<ParameterBlock>& blocks_;
  const Eigen::VectorXd& values_;
  const FitPosterior& posterior_;
  const HeldBandOptions& options_;
  Eigen::MatrixXd drawn_;  // [p' x D]
  JudgedRows judged_;
  bool sigma_is_known_ = false;
  int num_fitted_ = 0;                  // recordings with parameters of their own
  std::optional<StartSpread> spread_;   // none: the start is as certain as the fit has it
  std::unique_ptr<ForceSource> force_;  // null: none
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PREDICTION_HELD_RECORDING_H_
