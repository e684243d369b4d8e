// The numeric half of a supernodal Cholesky factorisation A = L L^T.
#ifndef CLOTHID_SIM_MATRIX_SUPERNODAL_FACTOR_H_
#define CLOTHID_SIM_MATRIX_SUPERNODAL_FACTOR_H_

#include <cstddef>

#include "sim/base/thread_team.h"
#include "sim/matrix/block_matrix.h"
#include "sim/matrix/lanes.h"
#include "sim/matrix/supernodes.h"

namespace clothid {

// Internal to sim/matrix, behind CholeskySolver.
//
// How many numbers `FactorSupernodes` needs: those of L and the spare ones of `Supernodes`.
std::size_t NumFactorValues(const Supernodes& supernodes);

// `values` [pattern.num_values()]: A, of which the lower triangle is read. `factor` [NumFactorValues]: becomes L as
// `Supernodes` has it, with the reciprocals of its diagonal in place of it; what stands above it is finite and means
// nothing, as do the spare numbers, which must be finite before. False where A is not positive definite; then nothing
// in `factor` means anything. Left-looking (Ng and Peyton 1993): for every supernode in turn the columns of A, minus
// the products of the rows of earlier supernodes, then a dense factorisation. The numbers depend neither on the machine
// nor on the `team` that shares the work, which may be null.
bool FactorSupernodes(const Supernodes& supernodes, const BlockPattern& pattern, const double* values, double* factor,
                      ThreadTeam* team = nullptr, InstructionSet instructions = BestInstructionSet());

}  // namespace clothid

#endif  // CLOTHID_SIM_MATRIX_SUPERNODAL_FACTOR_H_
