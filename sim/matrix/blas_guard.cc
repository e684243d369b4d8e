#include "sim/matrix/blas_guard.h"

#include <dlfcn.h>
#include <omp.h>

namespace clothid {
namespace {

// What OpenBLAS was built with, as openblas_get_parallel says.
enum class OpenBlasThreads { kNotOpenBlas = -1, kNone = 0, kPthreads = 1, kOpenMp = 2 };

OpenBlasThreads BlasThreads() {
  using GetParallel = int (*)();
  const auto get_parallel = reinterpret_cast<GetParallel>(dlsym(RTLD_DEFAULT, "openblas_get_parallel"));
  return get_parallel == nullptr ? OpenBlasThreads::kNotOpenBlas : static_cast<OpenBlasThreads>(get_parallel());
}

void HoldToOneThread() {
  using SetNumThreads = void (*)(int);
  const auto set_num_threads = reinterpret_cast<SetNumThreads>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
  if (set_num_threads != nullptr) set_num_threads(1);
}

// Debian builds OpenBLAS without threads also without USE_LOCKING: calls from two threads at once share work buffers
// and give wrong numbers. That of OpenMP locks its buffers only among threads of OpenMP.
bool PrepareBlas() {
  const OpenBlasThreads threads = BlasThreads();
  if (threads == OpenBlasThreads::kPthreads || threads == OpenBlasThreads::kOpenMp) HoldToOneThread();
  return threads == OpenBlasThreads::kNone || threads == OpenBlasThreads::kOpenMp;
}

bool ThreadsTakeTurns() {
  static const bool take_turns = PrepareBlas();
  return take_turns;
}

}  // namespace

BlasGuard::BlasGuard() : openmp_levels_(omp_get_max_active_levels()) {
  static std::mutex blas_mutex;
  if (ThreadsTakeTurns()) lock_ = std::unique_lock<std::mutex>(blas_mutex);
  omp_set_max_active_levels(0);
}

BlasGuard::~BlasGuard() { omp_set_max_active_levels(openmp_levels_); }

}  // namespace clothid
