// What the corrections of a rollout by its recording tell of the model.
//
// Innovations, what is measured less what is predicted since the last correction, are white where nothing is left but
// noise: those of consecutive frames do not resemble each other.
//
// The force that the model lacks, where and when: a correction changes velocities by dv in a frame interval dt
// (costs/assimilation/assimilation.h): as if a force per area
//   f = rho dv/dt   [N/m^2]
// had pushed the cloth meanwhile, rho its mass per area. Where the model lacks a force for longer than the memory, f is
// that force as far as the cloth is free to follow it: what stretch and handles take up within a frame moves it, but
// changes no velocity, and shows as less. Noise makes f, too, of another sign from frame to frame: what is lacking for
// longer is told by products of consecutive frames, whose mean is that of its square.
#ifndef CLOTHID_IDENTIFY_CHECKS_CORRECTION_CHECK_H_
#define CLOTHID_IDENTIFY_CHECKS_CORRECTION_CHECK_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "identify/checks/lasting_force.h"
#include "identify/estimate/fit_summary.h"
#include "identify/problem/problem.h"

namespace clothid {

struct MissingForce {
  Eigen::MatrixXd forces;  // [3N x T] N/m^2 in every frame, zero before the first correction and at handles
  double weight = 0.0;     // N/m^2, rho g, the mean over the cloth
  // Root mean squares of what lasts, N/m^2: over all; over the cloth at the frame where it is largest; over the frames
  // at the node where it is largest.
  double size = 0.0, largest_in_frame = 0.0, largest_at_node = 0.0;
  int frame = 0, node = 0;  // there
  double time = 0.0;        // s, of that frame after the first
  // As a random field; `ForceOfChanges` leaves it. Of rollouts with the memory that is nearest to 0.1 s of those that
  // were tried: corrections average away what lasts less than their memory, and so do predictions that look farther
  // ahead.
  LastingForce lasting;

  double share() const { return weight > 0.0 ? size / weight : 0.0; }
};

// f from the changes of velocities [3N x T] m/s in frames at `times` [T] s, mass [N] kg/m^2 of the nodes. Nodes of no
// mass count nothing. `gravity`: |g|, m/s^2.
MissingForce ForceOfChanges(const Eigen::MatrixXd& changes, const Eigen::VectorXd& times, const Eigen::VectorXd& mass,
                            double gravity);

struct CorrectionCheck {
  MissingForce missing_force;
  PredictionError innovations;
};

// Of the fitted recordings, at the estimate, with the memory of `LastAssimilation` (identify/checks/lead_time.h). Empty
// where there is none, or the rollout of a recording failed or is too large to be kept.
std::vector<CorrectionCheck> CheckCorrections(const std::vector<RecordedMotion>& motions, const FitProblem& problem,
                                              const FitSummary& summary, const RobustLoss& loss);

// What lasts of it over the recordings: the root of the mean square of its size, the means of time and length. None
// where nothing lasts in any of them.
std::optional<LastingForce> MeanForce(const std::vector<CorrectionCheck>& corrections);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_CHECKS_CORRECTION_CHECK_H_
