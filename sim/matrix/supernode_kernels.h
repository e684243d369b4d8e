// The dense arithmetic of a supernodal factorisation: what one supernode takes from another, and its Cholesky factor.
//
// Without BLAS: the supernodes of a cloth are small matrices, for which the calls cost more than the arithmetic, and
// OpenBLAS takes a lock of the whole process in each of them. Every entry is a sum in the order of the columns,
// whatever the instruction set, and whether or not what is multiplied was copied.
#ifndef CLOTHID_SIM_MATRIX_SUPERNODE_KERNELS_H_
#define CLOTHID_SIM_MATRIX_SUPERNODE_KERNELS_H_

#include <cstddef>

#include "sim/matrix/lanes.h"

namespace clothid {

// Internal to sim/matrix. A supernode that is being made, or that is done: `num_rows` x `num_columns` scalars by
// columns, and kSpareValues behind them (sim/matrix/supernodes.h).
struct SupernodePanel {
  double* values;
  int num_rows, num_columns;
};

// Rows of a supernode `source` that is done, from one that is a column of another supernode on: of `num_rows` the first
// `num_columns` are, and all are there at the rows `targets`.
struct SupernodeUpdate {
  const double* source;
  std::ptrdiff_t stride;  // of its columns
  int depth;              // their number
  int num_columns, num_rows;
  const int* targets;
};

// How many numbers of scratch memory an update takes; 0: none, which then may be null.
std::size_t ScratchSize(const SupernodeUpdate& update);

// What an instruction set has.
struct SupernodeKernels {
  // Takes the products of the first columns' rows with all rows off `panel`. What it leaves above the diagonal is
  // finite and means nothing.
  void (*subtract)(const SupernodeUpdate& update, const SupernodePanel& panel, double* scratch);
  // Makes `panel` its factor, with reciprocals on the diagonal; false: it is not positive definite.
  bool (*factor)(const SupernodePanel& panel);
};
SupernodeKernels KernelsOf(InstructionSet instructions);

}  // namespace clothid

#endif  // CLOTHID_SIM_MATRIX_SUPERNODE_KERNELS_H_
