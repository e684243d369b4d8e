// What the benchmarks measure time with.
#ifndef CLOTHID_TOOLS_BENCHMARK_BASE_TIMING_H_
#define CLOTHID_TOOLS_BENCHMARK_BASE_TIMING_H_

#include <string>
#include <vector>

namespace clothid {

// Processor time of the calling thread, s.
double ThreadSeconds();

// Of at least one value; the mean of the middle two where their number is even.
double MedianOfRuns(std::vector<double> values);

// Floating-point operations per second of one product of matrices with dgemm, of the BLAS that the factorisations call,
// in processor time of the calling thread: a multiplication and an addition are two.
double MeasureDgemmRate();

// The kind of processor that OpenBLAS takes this one for, which decides its speed; empty where BLAS is another.
std::string BlasKernel();

// The exponent p of the power law y ~ x^p that is nearest to the points in logarithms. All values positive, at least
// two different x.
double FitExponent(const std::vector<double>& x, const std::vector<double>& y);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_BASE_TIMING_H_
