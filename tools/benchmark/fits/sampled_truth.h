// A truth that is finer than the model: simulated with smaller steps, or on a finer mesh, and seen where the model is.
#ifndef CLOTHID_TOOLS_BENCHMARK_FITS_SAMPLED_TRUTH_H_
#define CLOTHID_TOOLS_BENCHMARK_FITS_SAMPLED_TRUTH_H_

#include <string>
#include <vector>

#include "datasets/synthetic/true_recording.h"

namespace clothid {

struct TruthResolution {
  int steps = 1;   // of the truth per step of the scene
  int levels = 0;  // so often its mesh is refined (sim/scene/refinement.h)
};

// What `SimulateTruth` gives at that resolution, of it the positions of the scene's own nodes after each of its steps:
// a rollout to be recorded, not to be differentiated. Throws `Error` as that does, and where the mesh cannot be refined.
Rollout SampleTruth(const std::vector<TrueParameter>& truth, const std::string& source, const Scene& scene,
                    const TruthResolution& resolution);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_FITS_SAMPLED_TRUTH_H_
