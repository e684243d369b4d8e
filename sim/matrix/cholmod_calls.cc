#include "sim/matrix/cholmod_calls.h"

#include <signal.h>

#include <stdexcept>
#include <string>

namespace clothid {
namespace {

std::string Describe(int status) {
  switch (status) {
    case CHOLMOD_OUT_OF_MEMORY:
      return "out of memory";
    case CHOLMOD_TOO_LARGE:
      return "the matrix is too large for its integers";
    default:
      return "status " + std::to_string(status);
  }
}

}  // namespace

void RequireSuccess(const char* routine, const cholmod_common& common) {
  // Errors are negative, warnings positive.
  if (common.status < CHOLMOD_OK) throw std::runtime_error(std::string(routine) + ": " + Describe(common.status));
}

// METIS takes SIGTERM and SIGABRT for its own while it orders a matrix, and a SIGTERM of anybody else is lost. Held
// back in this thread, it arrives when METIS is done.
cholmod_factor* Analyze(cholmod_sparse* matrix, cholmod_common* common) {
  sigset_t held, before;
  sigemptyset(&held);
  sigaddset(&held, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &held, &before);
  cholmod_factor* factor = cholmod_analyze(matrix, common);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  RequireSuccess("cholmod_analyze", *common);
  if (factor == nullptr) throw std::runtime_error("cholmod_analyze: no factor");
  return factor;
}

}  // namespace clothid
