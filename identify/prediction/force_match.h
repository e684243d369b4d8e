// The forces that make rollouts of a fit miss its own recordings as they do.
//
// What corrections tell (identify/checks/lasting_force.h) is what a cloth is free to follow within their memory. What
// lasts longer its elasticity takes up, and corrections hardly see it; but a rollout that nothing corrects goes astray
// by it. So beside the force that they tell there are slower ones, with memories t_j of .1, .3 and 1 s, as smooth,
// whose sizes are found by moments. In lead times l (up to .1, .3, 1 s, and from there on)
//   E_l   the mean square of what the rollout of the estimates misses of its recordings, less that of the noise
//   D_l   the standard deviation that noise leaves E_l
//   F_l   by how much draws of the force that corrections tell move that rollout, mean square
//   V_lj  likewise of a force of the memory t_j and the size g_j
// and with x_j >= 0 the least of
//   sum_l ((F_l + sum_j V_lj x_j - E_l)/(F_l + max(E_l, 0) + D_l))^2
// the sizes are sqrt(x_j) g_j. As V is not linear in x far from 1, it is found twice, the second time at the sizes of
// the first, and less than a thousandth of the weight is left out. Where no E_l is beyond 3 D_l, none is looked for.
// The draws are those of predictions: they begin with the motion (identify/prediction/random_force.h). F and V are of
// rollouts that are as loose as those far from the minimum of a fit, E is not. One motion tells what its model lacks in
// this motion: of another it may lack more, or less.
#ifndef CLOTHID_IDENTIFY_PREDICTION_FORCE_MATCH_H_
#define CLOTHID_IDENTIFY_PREDICTION_FORCE_MATCH_H_

#include <Eigen/Core>
#include <atomic>
#include <cstdint>
#include <optional>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "datasets/motion/recorded_motion.h"
#include "identify/checks/holdout.h"
#include "identify/checks/lasting_force.h"

namespace clothid {

// The x >= 0 [J], J <= 10, of the least |A x - b|^2, by trying which of them are zero. A: [R x J].
Eigen::VectorXd NonNegativeLeastSquares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

struct ForceMatchOptions {
  int num_draws = 6;  // of all recordings together, of every force
  std::uint64_t seed = 1;
  int num_threads = 1;
  const std::atomic<bool>* cancel = nullptr;
};

// The forces of all fitted recordings `motions` together, those of no size left out: `told` by corrections first, where
// there is one. Other arguments as of `JudgeByBands`. Empty where no rollout works, or nothing but forces at handles
// was measured.
std::vector<LastingForce> MatchForces(const std::vector<RecordedMotion>& motions,
                                      const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& values,
                                      const std::vector<HeldOutStart>& starts, const std::optional<LastingForce>& told,
                                      const ForceMatchOptions& options);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PREDICTION_FORCE_MATCH_H_
