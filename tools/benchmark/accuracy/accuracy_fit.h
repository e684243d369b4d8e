// What the accuracy of estimates costs: `benchmark accuracy`, quantity fit.
//
// A recording without noise, of all nodes after every step of a rollout at kTightTolerance, is fitted by the model that
// made it, with each method of kJacobianBenchmarkMethods and adaptive precision: mu and k_stretch, on `wind`, which has
// no obstacle, density and k_stretch. A fit starts at half the true mu, 1.5 times the density and 3 times the
// stiffness. There is one point per iteration, with the error |value/truth - 1| of the worst parameter and the
// processor time since the fit began.
#ifndef CLOTHID_TOOLS_BENCHMARK_ACCURACY_ACCURACY_FIT_H_
#define CLOTHID_TOOLS_BENCHMARK_ACCURACY_ACCURACY_FIT_H_

#include <vector>

#include "tools/benchmark/accuracy/accuracy_case.h"

namespace clothid {

// With `nodes` x `nodes` nodes; methods take turns, seconds are medians over `repeats`. The threshold of a point is the
// tolerance of its rollouts, steps_failed that of the whole fit. Throws `Error` (kBadData) where the recording cannot
// be made.
std::vector<AccuracyPoint> MeasureFits(const AccuracyCase& accuracy_case, int nodes, int repeats);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_ACCURACY_ACCURACY_FIT_H_
