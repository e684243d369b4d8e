// `simulate --result`: a scene with what a fit has learnt, and how far that may be off.
#ifndef CLOTHID_TOOLS_SIMULATE_PREDICT_H_
#define CLOTHID_TOOLS_SIMULATE_PREDICT_H_

#include <string>

#include "datasets/motion/motion_tensors.h"
#include "identify/prediction/prediction.h"
#include "identify/view/view_page.h"
#include "sim/scene/scene.h"

namespace clothid {

// The scene as it was read, for the recording of the median.
struct ScenePart {
  const Scene& scene;
  const std::string& text;
  const std::string& path;
};

// What a prediction writes.
struct PredictionOutput {
  MotionTensors median;
  std::string bands;    // the bytes of bands.npz
  PredictionView view;  // for the page
};

// Predicts `scene` by the result.json `result_path`, into `output`; tells on stdout what was drawn and what came of it.
// Returns an exit code: where that is not kExitSuccess the outputs are not to be used, and a line on stderr says why.
// Throws `Error` where `ReadPosterior`, `FitToScene` and `Predict` do.
int PredictScene(const ScenePart& scene, const std::string& result_path, PredictionOptions options,
                 PredictionOutput* output);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_SIMULATE_PREDICT_H_
