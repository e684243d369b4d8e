// The Jacobian of a recorded cloth by one forward sweep, in parts that may be weighed against each other.
#ifndef CLOTHID_IDENTIFY_EXPERIMENT_INFORMATION_SWEEP_H_
#define CLOTHID_IDENTIFY_EXPERIMENT_INFORMATION_SWEEP_H_

#include <Eigen/Core>
#include <array>
#include <atomic>
#include <vector>

#include "identify/experiment/planned_experiment.h"
#include "identify/experiment/recorded_cloth.h"
#include "identify/problem/problem.h"

namespace clothid {

// Rows of `RecordedCloth::all`.
enum class RowPart {
  kPlanned,      // frames and points of the plan
  kBetween,      // its points, at the frames between
  kFurther,      // further points at its frames
  kLater,        // its points, at its frame rate, after its end
  kForces,       // forces at its frames
  kLaterForces,  // forces after its end
  kWeighed,      // what is planned, forces as well, times the weights that are asked for
};
inline constexpr int kNumRowParts = 7;

struct InformationSweep {
  // Rows [r x (p + c)] with the J^T J of each part: of the p blocks, then of the start along c directions.
  std::array<Eigen::MatrixXd, kNumRowParts> parts;
  bool has_forces = false, has_further = false;

  const Eigen::MatrixXd& part(RowPart which) const { return parts[static_cast<std::size_t>(which)]; }
};

// Along the rollout of `cloth`, at the truth, where `problem` of `cloth.planned` starts, with its weights where a model
// errs (datasets/observation/model_error.h) for those of RowPart::kWeighed, which is empty without them. `directions`
// [n x c]: of its unknown start; without one 0 x 0. Throws std::runtime_error where a system is singular, or `cancel`
// turned true.
InformationSweep SweepCloth(const RecordedCloth& cloth, const FitProblem& problem, const Eigen::MatrixXd& directions,
                            const std::atomic<bool>* cancel);

// As InformationMap of the planned recording, with a column for each block. `follow` [n x p]: how the start follows;
// `influence` [p x p]: column i moves parameter i by 1 and all others so as to undo the most.
InformationMap MapInformation(const RecordedCloth& cloth, const FitProblem& problem, const Eigen::MatrixXd& follow,
                              const Eigen::MatrixXd& influence, const std::atomic<bool>* cancel);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_EXPERIMENT_INFORMATION_SWEEP_H_
