// One cloth of a candidate, simulated and seen without noise.
#ifndef CLOTHID_IDENTIFY_EXPERIMENT_RECORDED_CLOTH_H_
#define CLOTHID_IDENTIFY_EXPERIMENT_RECORDED_CLOTH_H_

#include <Eigen/Core>
#include <map>
#include <string>

#include "datasets/motion/recorded_motion.h"
#include "identify/experiment/candidate.h"
#include "sim/rollout/rollout.h"

namespace clothid {

struct RecordedCloth {
  std::string failure;     // one line; empty: it could be simulated
  RecordedMotion planned;  // what would be recorded, with the true start for where a fit of it begins
  // The same cloth with all that might help: every second frame is one of `planned`, the first points are its points.
  // Further frames, points and forces on all handles, which are later than the last of `planned` where `is_longer`.
  RecordedMotion all;
  bool is_longer = false;
  Rollout rollout;        // that they show
  Eigen::MatrixXf nodes;  // [3N x T] m, all of the cloth at the times of `planned`
};

// `truth`: true values by name. Where `looks_longer` the motion goes on, unless it fails there.
RecordedCloth RecordCloth(const PlanOptions& options, const Candidate& candidate,
                          const std::map<std::string, double>& truth, bool looks_longer);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_EXPERIMENT_RECORDED_CLOTH_H_
