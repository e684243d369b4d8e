// Scenes at the limits of what a simulator of cloth may be given, one at a time. Unless it says otherwise a scene is
// the drape of tools/benchmark/steps/stability_scene.h with k = 1000 N/m, h = 5 ms, mu = 0.35 in gap mode.
#ifndef CLOTHID_TOOLS_BENCHMARK_STEPS_STABILITY_EXTREMES_H_
#define CLOTHID_TOOLS_BENCHMARK_STEPS_STABILITY_EXTREMES_H_

#include <functional>
#include <string>
#include <vector>

#include "sim/scene/scene.h"

namespace clothid {

struct StabilityExtreme {
  std::string name;
  std::string description;                // one line
  std::function<Scene(int nodes)> scene;  // with `nodes` nodes along an axis, at least 4, where it is a grid
};

// All of them, in the order of the benchmark's table.
const std::vector<StabilityExtreme>& StabilityExtremes();

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_STEPS_STABILITY_EXTREMES_H_
