#include "identify/experiment/plan_options.h"

#include <cmath>

#include "identify/base/parallel_for.h"
#include "sim/base/error.h"

namespace clothid {
namespace {

constexpr int kMostDraws = 1000;

}  // namespace

void PlanOptions::Validate() const {
  ExpectUsage(!scene_paths.empty(), "--scenes: expected at least one scene.json");
  ExpectUsage(!fit.parameters.empty() || !fit.each.empty(), "--fit: expected the parameters that are to be told");
  ExpectUsage(std::isfinite(sigma) && sigma > 0.0, "--sigma: expected a standard deviation > 0 in m");
  ExpectUsage(std::isfinite(frame_rate) && frame_rate >= 0.0, "--frame_rate: expected a rate >= 0 in Hz");
  ExpectUsage(num_markers >= 0, "--markers: expected a number >= 0");
  ExpectUsage(std::isfinite(force_sigma) && force_sigma > 0.0, "--force_sigma: expected a standard deviation > 0 in N");
  ExpectUsage(std::isfinite(handle_sigma) && handle_sigma >= 0.0,
              "--handle_sigma: expected a standard deviation >= 0 in m");
  ExpectUsage(start == StartSource::kScene || IsUnknown(start), "--initial: expected scene, estimated, rest or moving");
  ExpectUsage(num_draws >= 0 && num_draws <= kMostDraws,
              "--draws: expected a number from 0 to " + std::to_string(kMostDraws));
  ExpectUsage(fit.num_threads >= 1 && fit.num_threads <= kMaxThreads,
              "--threads: expected a number from 1 to " + std::to_string(kMaxThreads));
}

}  // namespace clothid
