// benchmark discretization: what the grid and the time step of the fitted model do to its estimates.
//
// There are two truths, both by SDIRK2 at h/64, h the scene's time step: on the scene's own grid, and on one of twice
// the density. They are seen without noise at the nodes of the scene's own grid and at multiples of h, which all models
// share. Models with either integrator, at several time steps that divide h, are fitted to them: to the first truth
// models on its grid, to the second on several. A point that is no node of a coarse grid is a fixed point of one of its
// triangles.
#ifndef CLOTHID_TOOLS_BENCHMARK_FITS_BENCHMARK_DISCRETIZATION_H_
#define CLOTHID_TOOLS_BENCHMARK_FITS_BENCHMARK_DISCRETIZATION_H_

#include <array>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "datasets/synthetic/true_recording.h"
#include "identify/fit/fit.h"
#include "tools/benchmark/base/integrators.h"

namespace clothid {

// One fit. Depends on the options alone.
struct DiscretizationFit {
  std::array<int, 2> true_nodes = {};
  std::string integrator;
  std::array<int, 2> nodes = {};
  double time_step = 0.0;     // s
  std::vector<double> value;  // the estimates; NaN where there are none
  std::vector<double> error;  // (value - truth)/truth
  double rmse = 0.0;          // m
  int rollouts = 0;
  FitStatus status = FitStatus::kFailed;
  std::string message;  // one line: why the fit ended
};

struct DiscretizationOptions {
  std::string scene_path;
  std::map<std::string, double> truth;  // the parameters to be fitted; all others have the scene's nominal value
  std::vector<int> nodes;  // along the first axis, the second in proportion; empty: the scene's and the truth's
  std::vector<int> step_divisors = {1, 2, 4};
  std::vector<std::string> integrators = kIntegratorNames;
  int true_step_divisor = 64;  // of the truths
  int num_threads = 1;         // fits side by side; results do not depend on it
  // After every fit, in the order in which they end; never two at a time. May be empty.
  std::function<void(const DiscretizationFit& fit, int num_done, int num_fits)> on_fit;

  // Throws `Error` (kUsage) naming the first flag out of range.
  void Validate() const;
};

struct DiscretizationBenchmark {
  std::vector<TrueParameter> truth;
  double true_time_step = 0.0;          // s
  double frame_rate = 0.0;              // Hz
  std::vector<DiscretizationFit> fits;  // by truth, integrator, nodes, time step
};

// Fits start from the scene's nominal values. Throws `Error` for options and scenes that cannot be used (see
// `ReadGridScene` and `Regrid`) and where the rollout with the true parameters fails.
DiscretizationBenchmark RunDiscretizationBenchmark(const DiscretizationOptions& options);

// One line per fit.
std::string DiscretizationTable(const DiscretizationBenchmark& benchmark);

// One row per fit.
std::string DiscretizationCsv(const DiscretizationBenchmark& benchmark);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_FITS_BENCHMARK_DISCRETIZATION_H_
