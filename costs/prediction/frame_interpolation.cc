#include "costs/prediction/frame_interpolation.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace clothid {
namespace {

// The Hermite polynomials on [0, 1] at c, and their derivatives.
struct HermiteBasis {
  explicit HermiteBasis(double c)
      : h00(1.0 + c * c * (2.0 * c - 3.0)),
        h10(c * (1.0 - c) * (1.0 - c)),
        h01(c * c * (3.0 - 2.0 * c)),
        h11(c * c * (c - 1.0)),
        d00(6.0 * c * (c - 1.0)),
        d10((1.0 - c) * (1.0 - 3.0 * c)),
        d01(6.0 * c * (1.0 - c)),
        d11(c * (3.0 * c - 2.0)) {}
  double h00, h10, h01, h11, d00, d10, d01, d11;
};

// The slopes m_a in terms of states, per step.
constexpr std::array<double, 3> kStartSlope = {-1.5, 2.0, -0.5};  // m_0 of x_0, x_1, x_2

FrameStencil ScaledSlopes(FrameStencil stencil, double time_step) {
  for (double& slope : stencil.slopes) slope /= time_step;
  return stencil;
}

FrameStencil BeforeStart(double steps) {
  FrameStencil stencil{0, 3, {1.0, 0.0, 0.0, 0.0}, {}};
  for (int k = 0; k < 3; ++k) {
    stencil.weights[k] += steps * kStartSlope[k];
    stencil.slopes[k] = kStartSlope[k];
  }
  return stencil;
}

FrameStencil InFirstCell(const HermiteBasis& b) {
  FrameStencil stencil{0, 3, {b.h00 - 0.5 * b.h11, b.h01, 0.5 * b.h11, 0.0}, {b.d00 - 0.5 * b.d11, b.d01, 0.5 * b.d11}};
  for (int k = 0; k < 3; ++k) {
    stencil.weights[k] += b.h10 * kStartSlope[k];
    stencil.slopes[k] += b.d10 * kStartSlope[k];
  }
  return stencil;
}

FrameStencil InCell(int cell, const HermiteBasis& b) {
  return {cell - 1,
          4,
          {-0.5 * b.h10, b.h00 - 0.5 * b.h11, b.h01 + 0.5 * b.h10, 0.5 * b.h11},
          {-0.5 * b.d10, b.d00 - 0.5 * b.d11, b.d01 + 0.5 * b.d10, 0.5 * b.d11}};
}

}  // namespace

FrameInterpolation::FrameInterpolation(const Observation& observation)
    : is_cubic_(false), num_steps_(observation.num_steps()), stencils_(observation.stencils()) {}

FrameInterpolation::FrameInterpolation(const RecordedMotion& motion, double largest_offset)
    : is_cubic_(true),
      time_step_(motion.scene.time_step),
      frame_steps_((motion.times.array() - motion.scene.start_time) / motion.scene.time_step) {
  const double last = frame_steps_[frame_steps_.size() - 1] + largest_offset / time_step_;
  num_steps_ = static_cast<int>(std::floor(std::max(0.0, last))) + 2;
}

FrameStencil FrameInterpolation::CubicAt(double steps) const {
  if (steps < 0.0) return BeforeStart(steps);
  const int cell = static_cast<int>(std::min(std::floor(steps), num_steps_ - 2.0));
  const HermiteBasis basis(steps - cell);
  return cell == 0 ? InFirstCell(basis) : InCell(cell, basis);
}

std::vector<FrameStencil> FrameInterpolation::At(double time_offset) const {
  if (!is_cubic_) return stencils_;
  std::vector<FrameStencil> stencils;
  for (const double steps : frame_steps_) {
    stencils.push_back(ScaledSlopes(CubicAt(steps + time_offset / time_step_), time_step_));
  }
  return stencils;
}

}  // namespace clothid
