// The scenes on which `benchmark accuracy` measures trajectories and fits: those of
// tools/benchmark/base/benchmark_scene.h from their start, with the stiffness and the time step of a setting of
// tools/benchmark/derivatives/backprop_case.h.
#ifndef CLOTHID_TOOLS_BENCHMARK_ACCURACY_ACCURACY_CASE_H_
#define CLOTHID_TOOLS_BENCHMARK_ACCURACY_ACCURACY_CASE_H_

#include <string>

#include "sim/scene/scene.h"
#include "tools/benchmark/accuracy/accuracy_point.h"
#include "tools/benchmark/derivatives/backprop_case.h"

namespace clothid {

// The cloth of `slope` starts under this tension, N/m, along both axes: as much as friction puts on it. Without strain
// neither its stiffness nor any tolerance would matter.
inline constexpr double kSlopeTension = 0.4;

struct AccuracyCase {
  std::string scene;
  BackpropSetting setting;

  // s. Long enough for contacts and folds, short enough that errors do not grow without bound: the stiff cloth buckles
  // into many folds soon.
  double duration() const { return setting.stretch_stiffness > 1e4 ? 0.1 : 0.2; }
  // Throws `Error` where MakeBenchmarkScene does.
  Scene MakeScene(int nodes) const;
  // A point with what is the same for all of this case.
  AccuracyPoint MakePoint(const std::string& quantity, const std::string& reference, const std::string& method,
                          int nodes) const;
};

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_ACCURACY_ACCURACY_CASE_H_
