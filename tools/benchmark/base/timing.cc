#include "tools/benchmark/base/timing.h"

#include <dlfcn.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <ctime>

#include "sim/matrix/blas_guard.h"

extern "C" void dgemm_(const char* transpose_a, const char* transpose_b, const int* m, const int* n, const int* k,
                       const double* alpha, const double* a, const int* lda, const double* b, const int* ldb,
                       const double* beta, double* c, const int* ldc);

namespace clothid {
namespace {

// Large enough for the full speed of a core, small enough for some 10 ms.
constexpr int kDgemmSize = 512;

}  // namespace

double ThreadSeconds() {
  timespec now = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double MedianOfRuns(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

double MeasureDgemmRate() {
  const int n = kDgemmSize;
  const double one = 1.0, zero = 0.0;
  const Eigen::MatrixXd a = Eigen::MatrixXd::Constant(n, n, 0.5), b = Eigen::MatrixXd::Constant(n, n, 0.25);
  Eigen::MatrixXd c = Eigen::MatrixXd::Zero(n, n);
  const BlasGuard guard;  // on one thread, as steps call it
  const double start = ThreadSeconds();
  dgemm_("N", "N", &n, &n, &n, &one, a.data(), &n, b.data(), &n, &zero, c.data(), &n);
  return 2.0 * n * n * n / (ThreadSeconds() - start);
}

std::string BlasKernel() {
  using GetName = const char* (*)();
  const auto get_name = reinterpret_cast<GetName>(dlsym(RTLD_DEFAULT, "openblas_get_corename"));
  return get_name == nullptr ? "" : get_name();
}

double FitExponent(const std::vector<double>& x, const std::vector<double>& y) {
  const auto logarithms = [](const std::vector<double>& values) {
    Eigen::ArrayXd result = Eigen::Map<const Eigen::ArrayXd>(values.data(), static_cast<Eigen::Index>(values.size()));
    result = result.log();
    return Eigen::ArrayXd(result - result.mean());
  };
  const Eigen::ArrayXd log_x = logarithms(x), log_y = logarithms(y);
  return (log_x * log_y).sum() / log_x.square().sum();
}

}  // namespace clothid
