// What every call that ends in BLAS needs around it: those of UMFPACK, and CHOLMOD's analyses. Cholesky factors and
// solves call none.
#ifndef CLOTHID_SIM_MATRIX_BLAS_GUARD_H_
#define CLOTHID_SIM_MATRIX_BLAS_GUARD_H_

#include <mutex>

namespace clothid {

// Rollouts run side by side in threads, so nothing within one of them may be parallel: OpenMP regions of the calling
// thread stay on that thread (Debian's CHOLMOD asks for four threads whatever the machine has), and OpenBLAS with
// threads of its own is held to one of them, for the whole process and for good: its numbers are then those of the
// serial build. Where BLAS itself must not be called by two threads at once, they take turns.
class BlasGuard {
 public:
  BlasGuard();
  ~BlasGuard();
  BlasGuard(const BlasGuard&) = delete;
  BlasGuard& operator=(const BlasGuard&) = delete;

 private:
  int openmp_levels_;
  std::unique_lock<std::mutex> lock_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_MATRIX_BLAS_GUARD_H_
