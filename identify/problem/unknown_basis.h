// The directions along which a stage of a fit moves the unknowns.
#ifndef CLOTHID_IDENTIFY_PROBLEM_UNKNOWN_BASIS_H_
#define CLOTHID_IDENTIFY_PROBLEM_UNKNOWN_BASIS_H_

#include <Eigen/Core>

#include "identify/base/fit_stage.h"
#include "identify/problem/problem.h"
#include "identify/uncertainty/uncertainty.h"

namespace clothid {

// V = diag(1 [p x p], combinations): the parameters themselves, and orthonormal combinations of the other unknowns.
// With starts: all of their unknowns. With fields: their smoothest modes, products of cosines with fewer than
// `field_modes` half waves along either side of the control grid (costs/field/field_prior.h), but for the constant one,
// which changes nothing. What recordings tell of fields they tell of these first.
struct UnknownBasis {
  bool with_starts = false;
  int field_modes = 0;
  Eigen::MatrixXd combinations;     // [(n + f) x c]
  bool has_all_field_modes = true;  // there are no others

  Eigen::Index size() const { return num_blocks + combinations.cols(); }  // p + c
  // V^T z [p + c] of z [p + n + f], also of a gradient; and V x.
  Eigen::VectorXd Restrict(const Eigen::VectorXd& unknowns) const;
  Eigen::VectorXd Extend(const Eigen::VectorXd& coordinates) const;

  int num_blocks = 0;  // p
};

// What was measured, and what is believed of starts, along a basis.
struct BasisLinearization {
  UnknownBasis basis;
  Linearization linearization;  // columns of the basis; empty: none was made
  Eigen::VectorXd made_at;      // [p + n + f] where its Jacobian was made
};

UnknownBasis MakeBasis(const FitProblem& problem, bool with_starts, int field_modes);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PROBLEM_UNKNOWN_BASIS_H_
