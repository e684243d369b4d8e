// What the callers of CHOLMOD share.
#ifndef CLOTHID_SIM_MATRIX_CHOLMOD_CALLS_H_
#define CLOTHID_SIM_MATRIX_CHOLMOD_CALLS_H_

#include <cholmod.h>

namespace clothid {

// cholmod_analyze without the loss of a SIGTERM; null where it fails.
cholmod_factor* Analyze(cholmod_sparse* matrix, cholmod_common* common);

}  // namespace clothid

#endif  // CLOTHID_SIM_MATRIX_CHOLMOD_CALLS_H_
