#include "datasets/observation/frame_stencil.h"

#include <algorithm>
#include <cmath>

namespace clothid {
namespace {

// A recorded time this close to a step (in steps) is that step: times are multiples of h up to their rounding.
constexpr double kSameTime = 1e-9;

}  // namespace

std::vector<FrameStencil> LinearStencils(const Eigen::VectorXd& times, const Scene& scene) {
  std::vector<FrameStencil> stencils;
  for (const double time : times) {
    double steps = (time - scene.start_time) / scene.time_step;
    const double nearest = std::round(steps);
    if (std::abs(steps - nearest) <= kSameTime * std::max(1.0, nearest)) steps = nearest;
    FrameStencil stencil;
    stencil.first_step = static_cast<int>(std::floor(steps));
    const double fraction = steps - stencil.first_step;
    if (fraction > 0.0) stencil.size = 2;
    stencil.weights = {1.0 - fraction, fraction, 0.0, 0.0};
    stencils.push_back(stencil);
  }
  return stencils;
}

std::pair<int, int> FramesAt(int step, const std::vector<FrameStencil>& stencils) {
  const auto ends_before = [](const FrameStencil& stencil, int value) { return stencil.last_step() < value; };
  const auto starts_after = [](int value, const FrameStencil& stencil) { return value < stencil.first_step; };
  const auto first = std::lower_bound(stencils.begin(), stencils.end(), step, ends_before);
  const auto end = std::upper_bound(first, stencils.end(), step, starts_after);
  return {static_cast<int>(first - stencils.begin()), static_cast<int>(end - stencils.begin())};
}

FrameSampler::FrameSampler(const std::vector<FrameStencil>* stencils, Visitor visitor)
    : stencils_(stencils), visitor_(std::move(visitor)) {
  int most = 1;
  for (const FrameStencil& stencil : *stencils) most = std::max(most, stencil.size);
  kept_.resize(static_cast<std::size_t>(most));
}

void FrameSampler::AddStep(int step, const Eigen::Ref<const Eigen::MatrixXd>& state) {
  kept(step) = state;
  for (; next_frame_ < stencils_->size(); ++next_frame_) {
    const FrameStencil& stencil = (*stencils_)[next_frame_];
    if (stencil.last_step() > step) return;
    FrameStates states;
    for (int k = 0; k < stencil.size; ++k) {
      const Eigen::MatrixXd& own = kept(stencil.first_step + k);
      states.emplace_back(own.data(), own.rows(), own.cols());
    }
    visitor_(static_cast<int>(next_frame_), states);
  }
}

}  // namespace clothid
