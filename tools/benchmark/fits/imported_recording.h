// What a user has who imports the recording of a rollout: nothing in its scene says where the cloth was at first, and
// it may have been in motion by then. For `benchmark coverage --initial`. And a truth that is finer than the model, for
// its --truth_steps and --truth_levels.
#ifndef CLOTHID_TOOLS_BENCHMARK_FITS_IMPORTED_RECORDING_H_
#define CLOTHID_TOOLS_BENCHMARK_FITS_IMPORTED_RECORDING_H_

#include <string>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "datasets/synthetic/synthetic.h"
#include "datasets/synthetic/true_recording.h"
#include "sim/rollout/rollout.h"
#include "sim/scene/scene.h"

namespace clothid {

struct ImportOfRollout {
  // Where the start of a fit comes from. Any but `kScene` takes `initial` out of the scene's text.
  StartSource start = StartSource::kScene;
  // s >= 0: frames that are earlier than this after the scene's start are dropped, and the recording ends with its last
  // frame. 0 with `kScene`, whose start is the scene's.
  double cut = 0.0;
  // m >= 0, standard deviation of a coordinate of noise on the handles' recorded path, frame by frame. 0 for handles
  // that stand still, which have no path of their own: their points show them.
  double handle_sigma = 0.0;
};

// Throws `Error` (kUsage), naming the flag, where `ImportRollout` would for a rollout of all of `scene`, and where less
// than two frames are left after the cut. To be asked before a long simulation.
void CheckImport(const ImportOfRollout& import, const SyntheticOptions& options, const Scene& scene,
                 const std::string& scene_text);

// The recording of `rollout` as a file of it would be read. Arguments and errors are those of `RecordRollout`. Same
// arguments, same recording; may be called side by side.
RecordedMotion ImportRollout(const ImportOfRollout& import, const Rollout& rollout, const Scene& scene,
                             const std::string& scene_text, const SyntheticOptions& options);

struct TruthResolution {
  int steps = 1;   // of the truth per step of the scene
  int levels = 0;  // so often its mesh is refined (sim/scene/refinement.h)
};

// What `SimulateTruth` gives at that resolution, of it the positions of the scene's own nodes after each of its steps:
// a rollout to be recorded, not to be differentiated. Throws `Error` as that does, and where the mesh cannot be
// refined.
Rollout SampleTruth(const std::vector<TrueParameter>& truth, const std::string& source, const Scene& scene,
                    const TruthResolution& resolution);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_FITS_IMPORTED_RECORDING_H_
