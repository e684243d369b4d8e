#include "sim/matrix/cholmod_calls.h"

#include <signal.h>

namespace clothid {

// METIS takes SIGTERM and SIGABRT for its own while it orders a matrix, and a SIGTERM of anybody else is lost. Held
// back in this thread, it arrives when METIS is done.
cholmod_factor* Analyze(cholmod_sparse* matrix, cholmod_common* common) {
  sigset_t held, before;
  sigemptyset(&held);
  sigaddset(&held, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &held, &before);
  cholmod_factor* factor = cholmod_analyze(matrix, common);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return factor;
}

}  // namespace clothid
