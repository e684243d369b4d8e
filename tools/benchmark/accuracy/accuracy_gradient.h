// What the accuracy of a gradient costs: `benchmark accuracy`, quantity gradient.
//
// The case of tools/benchmark/derivatives/backprop_case.h, with kGradientSteps steps; errors are of its worst parameter
// (GradientErrors). Two kinds of curves, each against a reference of its own:
//   umfpack, fixed_point, gmres, reduced, kept   the linear solvers of the reverse sweep, the iterative ones at falling
//                   thresholds, against UMFPACK on the same rollout, at kTightTolerance; seconds of the sweep
//   step_tolerance  gradients, by `kept`, of rollouts at falling step tolerances, against that of one at
//                   kTightTolerance; seconds of rollout and sweep
#ifndef CLOTHID_TOOLS_BENCHMARK_ACCURACY_ACCURACY_GRADIENT_H_
#define CLOTHID_TOOLS_BENCHMARK_ACCURACY_ACCURACY_GRADIENT_H_

#include <vector>

#include "tools/benchmark/accuracy/accuracy_case.h"

namespace clothid {

inline constexpr int kGradientSteps = 20;
// Of the iterative methods, as in section 5.4 of the DiffCloth paper.
inline const std::vector<double> kGradientThresholds = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9};

// All curves with `nodes` x `nodes` nodes. Seconds are processor time, medians over `repeats`. Throws `Error`
// (kBadData) where a step of a rollout does not converge.
std::vector<AccuracyPoint> MeasureGradients(const AccuracyCase& accuracy_case, int nodes, int repeats);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_ACCURACY_ACCURACY_GRADIENT_H_
