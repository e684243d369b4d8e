// In which order to eliminate the unknowns of a sparse symmetric matrix.
#ifndef CLOTHID_SIM_MATRIX_FILL_REDUCING_ORDER_H_
#define CLOTHID_SIM_MATRIX_FILL_REDUCING_ORDER_H_

#include <vector>

namespace clothid {

// The order in which to number the nodes of a graph so that a Cholesky factor of a matrix on it fills in little: nested
// dissection (METIS), postordered. Element k is the node that comes k-th. `neighbours`: as of BlockPattern. Throws
// `std::runtime_error` where CHOLMOD fails, as for a lack of memory.
std::vector<int> FillReducingOrder(const std::vector<std::vector<int>>& neighbours);

}  // namespace clothid

#endif  // CLOTHID_SIM_MATRIX_FILL_REDUCING_ORDER_H_
