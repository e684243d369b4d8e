#include "sim/matrix/blas_guard.h"

#include <dlfcn.h>
#include <omp.h>

namespace clothid {
namespace {

// Whether BLAS is OpenBLAS without threads. Debian builds it without USE_LOCKING: calls from two threads at once share
// work buffers and give wrong numbers.
bool BlasNeedsLock() {
  using GetParallel = int (*)();
  const auto get_parallel = reinterpret_cast<GetParallel>(dlsym(RTLD_DEFAULT, "openblas_get_parallel"));
  return get_parallel != nullptr && get_parallel() == 0;
}

}  // namespace

BlasGuard::BlasGuard() : openmp_levels_(omp_get_max_active_levels()) {
  static const bool needs_lock = BlasNeedsLock();
  static std::mutex blas_mutex;
  if (needs_lock) lock_ = std::unique_lock<std::mutex>(blas_mutex);
  omp_set_max_active_levels(0);
}

BlasGuard::~BlasGuard() { omp_set_max_active_levels(openmp_levels_); }

}  // namespace clothid
