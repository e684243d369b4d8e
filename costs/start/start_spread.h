// Starts that a cloth may have about the one that is said, for draws.
//
//   x_0 = x_b + Phi A z,   v_0 = v_b + Phi_v B y,   z, y of independent normal numbers of variance one,
// Phi the smooth modes of an unknown start and P what is believed of strain and bending there
// (costs/start/unknown_start.h). A A^T = g (P + t M)^-1, with M = Phi^T Phi over the number of coordinates that move,
// has the root mean square deviation that is asked for: by t > 0 where P alone lets the cloth move farther, else by
// g > 1. B likewise. Handles do not move.
#ifndef CLOTHID_COSTS_START_START_SPREAD_H_
#define CLOTHID_COSTS_START_START_SPREAD_H_

#include <Eigen/Core>

#include "sim/scene/scene.h"

namespace clothid {

class StartSpread {
 public:
  // Deviations of a coordinate of a free node, m and m/s; 0: none. Keeps no reference to `scene`.
  StartSpread(const Scene& scene, double position, double velocity);

  const Eigen::MatrixXd& position_root() const { return position_root_; }  // A [n x n]
  const Eigen::MatrixXd& velocity_root() const { return velocity_root_; }  // B [m x m], of the first m of n modes
  // [3N] of coefficients [n] or [m].
  Eigen::VectorXd Displacement(const Eigen::VectorXd& coefficients) const {
    return along_.leftCols(coefficients.size()) * coefficients;
  }

 private:
  Eigen::MatrixXd along_;  // Phi [3N x n]
  Eigen::MatrixXd position_root_, velocity_root_;
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_START_START_SPREAD_H_
