// benchmark jacobian: the same fits, from the same grid of starts, with each way to differentiate a recording.
//
// A recording is made from a scene with known values of two parameters, once without noise and once with it. From every
// start of an n x n grid both parameters are fitted with each method. What is compared: whether a fit reaches the
// minimum that it should, how many rollouts that takes, and the time.
#ifndef CLOTHID_TOOLS_BENCHMARK_DERIVATIVES_BENCHMARK_JACOBIAN_H_
#define CLOTHID_TOOLS_BENCHMARK_DERIVATIVES_BENCHMARK_JACOBIAN_H_

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "identify/fit/fit.h"
#include "tools/benchmark/base/common.h"

namespace clothid {

// Levenberg-Marquardt with each Jacobian of `RolloutCost`. That by reverse sweeps may say how these solve their linear
// systems, as in adjoint:fixed_point:1e-4 (see `ParseAdjointOptions`).
inline const std::vector<std::string> kJacobianBenchmarkMethods = {"adjoint", "sensitivity", "numeric"};

// Starts of friction coefficients are spaced linearly over this range; all others by factors of the truth.
inline constexpr double kFirstFriction = 0.02, kLastFriction = 0.58;
inline constexpr double kFirstFactor = 0.1, kLastFactor = 10.0;

// Without noise a fit has reached its minimum where each parameter is within kTruthTolerance of the truth; with noise
// where its cost is within kCostTolerance of the lowest of all fits to the same recording, and each parameter within
// kParameterTolerance of that fit's. All relative.
inline constexpr double kTruthTolerance = 1e-4, kCostTolerance = 1e-6, kParameterTolerance = 1e-3;

// One fit. Its place in the benchmark and its result, which depend on the options alone, and its time.
struct JacobianFit {
  double noise = 0.0;  // standard deviation on every coordinate, relative to the cloth's size
  std::string method;
  std::array<double, 2> start = {};
  std::array<double, 2> value = {};  // the estimates; NaN where there are none
  double cost = 0.0;                 // infinite where there is no estimate
  int num_iterations = 0, rollouts = 0, sweeps = 0, failed_steps = 0;
  FitStatus status = FitStatus::kFailed;
  std::string message;  // one line: why the fit ended
  bool reached = false;
  double seconds = 0.0;  // processor time of the fit, which other work on the machine disturbs less than wall time
};

struct JacobianBenchmarkOptions {
  std::string scene_path;
  std::map<std::string, double> truth;  // the two parameters to be fitted; all others have the scene's nominal value
  double noise = 0.01;                  // relative to the cloth's size, beside the noise-free recording; 0: only that
  int starts_per_axis = 4;              // n >= 2; even, so that no start is on the truth
  std::vector<std::string> methods = kJacobianBenchmarkMethods;
  FitPrecision precision = FitPrecision::kAdaptive;
  std::uint64_t seed = 1;         // of the noise
  int num_threads = 1;            // fits side by side; results do not depend on it
  BenchmarkProgress on_progress;  // after every fit

  // Throws `Error` (kUsage) naming the first flag out of range.
  void Validate() const;
};

struct JacobianBenchmark {
  std::array<std::string, 2> names;  // of the fitted parameters, friction first
  std::vector<double> noises;        // 0, and that of the options
  std::vector<std::string> methods;
  std::vector<JacobianFit> fits;  // by noise, then start, then method: methods take turns, so that times compare
};

// Throws `Error` for options and scenes that cannot be used and where the rollout with the true parameters fails.
JacobianBenchmark RunJacobianBenchmark(const JacobianBenchmarkOptions& options);

// One line per noise and method: fits that reached the minimum, median and maximum of rollouts, median of sweeps,
// failed steps, median of seconds, and the median over the starts of seconds relative to `sensitivity`.
std::string JacobianTable(const JacobianBenchmark& benchmark);
std::string JacobianCsv(const JacobianBenchmark& benchmark);  // one row per fit

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_DERIVATIVES_BENCHMARK_JACOBIAN_H_
