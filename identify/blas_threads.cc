#include "identify/blas_threads.h"

#include <dlfcn.h>

namespace clothid {
namespace {

// A function of the BLAS in this process, or null. Looked up at run time because Debian's alternatives choose the BLAS
// then.
template <typename Function>
Function* FindFunction(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

}  // namespace

bool BlasMayRunInThreads() {
  int (*const get_parallel)() = FindFunction<int()>("openblas_get_parallel");
  constexpr int kSequential = 0;  // OPENBLAS_SEQUENTIAL of cblas.h
  return get_parallel == nullptr || get_parallel() != kSequential;
}

void UseOneThreadPerBlasCall() {
  void (*const set_num_threads)(int) = FindFunction<void(int)>("openblas_set_num_threads");
  if (set_num_threads != nullptr) set_num_threads(1);
}

}  // namespace clothid
