// What the accuracy of a trajectory costs: `benchmark accuracy`, quantity forward.
//
// The error of a trajectory is  rms |x - x_ref| / rms |x_ref - x_ref(0)|  over nodes and frames: relative to the
// motion. Frames are the multiples of the setting's time step h, whatever the step of the rollout. Curves, each
// kind against a reference of its own:
//   euler, sdirk2   steps of h/1 .. h/32 by that integrator, each at several step tolerances, against SDIRK2 at h/64
//                   and kTightTolerance on the same mesh: all that integration in time does. At kMeshTolerance also
//                   against SDIRK2 at h/64 with 2n cells: what time step and mesh do together
//   step_tolerance  backward Euler at h and falling tolerances, against the same at kTightTolerance: what the solver
//                   leaves
//   mesh            backward Euler with n/4, n/2 and n cells along each axis, against 2n: at the nodes of the coarsest,
//                   which all of them have
#ifndef CLOTHID_TOOLS_BENCHMARK_ACCURACY_ACCURACY_FORWARD_H_
#define CLOTHID_TOOLS_BENCHMARK_ACCURACY_ACCURACY_FORWARD_H_

#include <string>
#include <vector>

#include "tools/benchmark/accuracy/accuracy_case.h"

namespace clothid {

inline constexpr double kTightTolerance = 1e-12;  // rounding in the step's residual is often larger
inline constexpr int kReferenceDivisor = 64;
inline const std::vector<int> kStepDivisors = {1, 2, 4, 8, 16, 32};
inline constexpr double kMeshTolerance = 1e-8;
inline const std::vector<double> kDivisorTolerances = {1e-2, 1e-3, 1e-4, 1e-6, 1e-8};  // of each of these steps
inline const std::vector<double> kStepTolerances = {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10};

// All curves with `nodes` x `nodes` nodes, 4 i + 1 >= 5, those over the time step of each of `integrators`. Seconds are
// processor time of a rollout, medians over at most `repeats` of them: fewer where they take long.
std::vector<AccuracyPoint> MeasureForward(const AccuracyCase& accuracy_case,
                                          const std::vector<std::string>& integrators, int nodes, int repeats);

// The curves by themselves.
std::vector<AccuracyPoint> MeasureTimeSteps(const AccuracyCase& accuracy_case,
                                            const std::vector<std::string>& integrators, int nodes, int repeats);
std::vector<AccuracyPoint> MeasureStepTolerances(const AccuracyCase& accuracy_case, int nodes, int repeats);
std::vector<AccuracyPoint> MeasureMeshes(const AccuracyCase& accuracy_case, int nodes, int repeats);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_ACCURACY_ACCURACY_FORWARD_H_
