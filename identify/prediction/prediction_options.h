// How a prediction is made (identify/prediction/prediction.h).
#ifndef CLOTHID_IDENTIFY_PREDICTION_PREDICTION_OPTIONS_H_
#define CLOTHID_IDENTIFY_PREDICTION_PREDICTION_OPTIONS_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "identify/prediction/derived.h"

namespace clothid {

// Rollouts that tell what start, or handles, spread alone.
inline constexpr int kDrawsAlone = 20;

struct PredictionOptions {
  int num_draws = 50;
  std::uint64_t seed = 1;
  bool with_force = true;                       // what the model lacks, where the fit has found it
  bool with_step = true, with_mesh = true;      // what those of the scene are off by
  bool with_start = true, with_handles = true;  // what start and path of handles are off by, where the fit has found it
  std::vector<DerivedRequest> derived = {};     // what is asked for beside the positions of nodes
  bool keeps_draws = false;                     // `Prediction::cloths` are all draws that work
  double frame_rate = 0.0;                      // Hz; 0: a frame per step
  int num_threads = 1;                          // that run rollouts side by side; the result does not depend on them
  const std::atomic<bool>* cancel = nullptr;
  std::function<void(int num_done)> on_rollout = {};  // never two at a time
};

// "force,step": what spreads rollouts beside parameters; "parameters" adds nothing. Throws `Error` (kUsage), naming
// `flag`, for others.
void SetSources(const std::string& list, const std::string& flag, PredictionOptions* options);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PREDICTION_PREDICTION_OPTIONS_H_
