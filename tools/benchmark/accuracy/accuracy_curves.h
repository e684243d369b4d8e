// What the accuracy of trajectories and of gradients costs: the curves of `benchmark accuracy`. Seconds are processor
// time, medians over at most `repeats`.
#ifndef CLOTHID_TOOLS_BENCHMARK_ACCURACY_ACCURACY_CURVES_H_
#define CLOTHID_TOOLS_BENCHMARK_ACCURACY_ACCURACY_CURVES_H_

#include <string>
#include <vector>

#include "sim/scene/scene.h"
#include "tools/benchmark/base/common.h"
#include "tools/benchmark/derivatives/backprop_case.h"

namespace clothid {

struct AccuracyPoint {
  std::string scene, setting;  // of kBenchmarkScenes and kBackpropSettings
  std::string quantity;        // of kAccuracyQuantities
  std::string reference;       // what the error is taken against; errors against others do not compare
  std::string method;
  double threshold = kNoNumber;  // what `method` was solved to; NaN: directly
  int nodes = 0;                 // along both axes
  double time_step = 0.0;        // s
  double error = kNoNumber;      // relative; NaN where a rollout failed, here or for the reference
  double seconds = kNoNumber;    // processor time; NaN where a rollout failed
  // Steps that did not converge; gradient: linear systems that missed the threshold, so that LU stepped in.
  int steps_failed = 0;
};

inline const std::vector<std::string> kAccuracyQuantities = {"forward", "gradient"};

// A scene of tools/benchmark/base/benchmark_scene.h from its start, with stiffness and time step of the setting.
struct AccuracyCase {
  std::string scene;
  BackpropSetting setting;

  // With nodes x nodes nodes, for 0.2 s, the stiff cloth for 0.1 s: long enough for contacts and folds, short enough
  // that errors do not grow without bound. The cloth of `slope` starts under tension, or neither its stiffness nor any
  // tolerance would matter. Throws `Error` where MakeBenchmarkScene does.
  Scene MakeScene(int nodes) const;
  // A point with what is the same for all of this case.
  AccuracyPoint MakePoint(const std::string& quantity, const std::string& reference, const std::string& method,
                          int nodes) const;
};

inline constexpr double kTightTolerance = 1e-12;  // rounding in the step's residual is often larger
inline constexpr double kMeshTolerance = 1e-8;
inline const std::vector<int> kStepDivisors = {1, 2, 4, 8, 16, 32};
inline const std::vector<double> kDivisorTolerances = {1e-2, 1e-3, 1e-4, 1e-6, 1e-8};  // of each of these steps

// Quantity forward: steps of h/1 .. h/32 by each integrator, each at several step tolerances, with nodes x nodes nodes.
// The error is  rms |x - x_ref| / rms |x_ref - x_ref(0)|  over nodes and the multiples of h: relative to the motion.
// The reference is SDIRK2 at h/64: "time_step/64" at kTightTolerance on the same mesh, all that integration in time
// does; "finest/64" on one of 2 nodes - 1 along each axis at kMeshTolerance, what step and mesh do together.
std::vector<AccuracyPoint> MeasureTimeSteps(const AccuracyCase& accuracy_case,
                                            const std::vector<std::string>& integrators, int nodes, int repeats);

// Thresholds of the iterative methods, as in section 5.4 of the DiffCloth paper.
inline const std::vector<double> kGradientThresholds = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9};

// Quantity gradient: the reverse sweep of the case of tools/benchmark/derivatives/backprop_case.h over 20 steps, solved
// to kTightTolerance, by umfpack, the reference, and by fixed_point, gmres, reduced and kept at falling thresholds.
// Errors are those of the worst parameter (GradientErrors). Throws `Error` (kBadData) where a step does not converge.
std::vector<AccuracyPoint> MeasureGradients(const AccuracyCase& accuracy_case, int nodes, int repeats);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_ACCURACY_ACCURACY_CURVES_H_
