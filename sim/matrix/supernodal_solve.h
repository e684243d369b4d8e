// Triangular solves with a supernodal Cholesky factor: the inner loop of rollouts and their derivatives.
#ifndef CLOTHID_SIM_MATRIX_SUPERNODAL_SOLVE_H_
#define CLOTHID_SIM_MATRIX_SUPERNODAL_SOLVE_H_

#include <Eigen/Core>

#include "sim/base/thread_team.h"
#include "sim/matrix/lanes.h"
#include "sim/matrix/supernodes.h"

namespace clothid {

// Internal to sim/matrix, behind CholeskyFactor.
//
// L L^T x = `right` [n x s], for all columns of `right` at once. `factor`: as FactorSupernodes leaves it. Touches
// nothing shared, so any number of threads may solve with one factor. The numbers depend neither on the machine nor on
// the `team` that shares the work, which may be null, nor on how many columns beside it a column is solved with, but
// for one column alone, which differs in rounding. `solution` may be `right`.
//
// `Scalar`: double, or float for single precision, which has an error of 1e-7 times the condition of the matrix and
// takes half the time where the factor is large. Columns are scaled for it, so that none is too small or too large.
template <typename Scalar>
void SolveSupernodes(const Supernodes& supernodes, const Scalar* factor, const Eigen::MatrixXd& right,
                     Eigen::MatrixXd* solution, ThreadTeam* team = nullptr,
                     InstructionSet instructions = BestInstructionSet());

}  // namespace clothid

#endif  // CLOTHID_SIM_MATRIX_SUPERNODAL_SOLVE_H_
