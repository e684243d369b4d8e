// The steps of a recording's frames where its clock may be fitted.
//
// Where no time offset is fitted, linear in time, as of datasets/observation/frame_stencil.h. Where one is, the frames
// move against the steps, often from one to the next, and a piecewise linear prediction has a kink at every step: a
// cost with kinks at its very start, as frames often lie at steps. So the prediction then is a C1 cubic: piecewise
// Hermite with slopes from the parabola through each step and its neighbours (Catmull and Rom 1974), at steps the
// states themselves. With u = (t_i + time_offset - start)/h, a = floor(u), c = u - a:
//   x = h00 x_a + h10 m_a + h01 x_{a+1} + h11 m_{a+1},   m_a = (x_{a+1} - x_{a-1})/2,   m_0 = (-3 x_0 + 4 x_1 - x_2)/2
// A frame that falls before the start of the scene (a negative offset moves the first one there) is predicted on the
// tangent of the start, x_0 + u m_0: the derivative has no jump there, and what the cloth did before its start is not
// known anyway. The simulation goes on behind the last frame as far as the upper bound of the offset asks.
#ifndef CLOTHID_COSTS_PREDICTION_FRAME_INTERPOLATION_H_
#define CLOTHID_COSTS_PREDICTION_FRAME_INTERPOLATION_H_

#include <Eigen/Core>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "datasets/observation/frame_stencil.h"
#include "datasets/observation/observation.h"

namespace clothid {

class FrameInterpolation {
 public:
  // Linear: there is no time offset.
  explicit FrameInterpolation(const Observation& observation);
  // Cubic, for offsets up to `largest_offset`, s; beyond it the last cubic goes on.
  FrameInterpolation(const RecordedMotion& motion, double largest_offset);

  int num_steps() const { return num_steps_; }  // what the rollouts must have
  // Whether frames have slopes, which only a time offset needs.
  bool has_slopes() const { return is_cubic_; }
  // Per frame [T]; first_step and last_step never decrease. Linear: `time_offset` must be zero.
  std::vector<FrameStencil> At(double time_offset) const;

 private:
  FrameStencil CubicAt(double steps) const;

  bool is_cubic_;
  double time_step_ = 1.0;  // h, s
  int num_steps_ = 0;
  Eigen::VectorXd frame_steps_;         // cubic: [T] (t_i - start)/h
  std::vector<FrameStencil> stencils_;  // linear
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_PREDICTION_FRAME_INTERPOLATION_H_
