// What the callers of CHOLMOD share.
#ifndef CLOTHID_SIM_MATRIX_CHOLMOD_CALLS_H_
#define CLOTHID_SIM_MATRIX_CHOLMOD_CALLS_H_

#include <cholmod.h>

namespace clothid {

// Throws `std::runtime_error`, which names `routine` and the reason, where the last call ended in an error: out of
// memory above all. A matrix that is not positive definite is none.
void RequireSuccess(const char* routine, const cholmod_common& common);

// cholmod_analyze without the loss of a SIGTERM. Throws as RequireSuccess does.
cholmod_factor* Analyze(cholmod_sparse* matrix, cholmod_common* common);

}  // namespace clothid

#endif  // CLOTHID_SIM_MATRIX_CHOLMOD_CALLS_H_
