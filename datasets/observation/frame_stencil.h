// From the steps of a rollout to the times of a recording's frames: the one way there.
//
// The state at the time of a frame is a combination of the states after a few successive steps. Here it is linear in
// time: with the frame at t_i between the steps a and a + 1, h apart,
//   x(t_i) = (1 - c) x_a + c x_{a+1},   c = (t_i - start)/h - a,
// and of one step where c = 0. Where a time offset is fitted it is a cubic: costs/prediction/frame_interpolation.h.
#ifndef CLOTHID_DATASETS_OBSERVATION_FRAME_STENCIL_H_
#define CLOTHID_DATASETS_OBSERVATION_FRAME_STENCIL_H_

#include <Eigen/Core>
#include <array>
#include <functional>
#include <utility>
#include <vector>

#include "sim/scene/scene.h"

namespace clothid {

// x(t) = sum_k weights[k] x_{first_step + k} for the state at one frame.
struct FrameStencil {
  static constexpr int kMaxSize = 4;
  int first_step = 0;
  int size = 1;
  std::array<double, kMaxSize> weights = {1.0, 0.0, 0.0, 0.0};
  std::array<double, kMaxSize> slopes = {};  // d weights / d time, 1/s; zero where nothing needs them

  int last_step() const { return first_step + size - 1; }
  double weight(int step) const { return weights[static_cast<std::size_t>(step - first_step)]; }
};

// Of increasing times [T] from the start of the scene on, linear. first_step and last_step never decrease.
std::vector<FrameStencil> LinearStencils(const Eigen::VectorXd& times, const Scene& scene);

// The frames whose stencils hold `step`: those from the first to before the second.
std::pair<int, int> FramesAt(int step, const std::vector<FrameStencil>& stencils);

// The states at the steps of one stencil, in their order: [3N x c] each.
using FrameStates = std::vector<Eigen::Map<const Eigen::MatrixXd>>;

// The states of frames from states that arrive step by step: no more are stored than the largest stencil holds.
class FrameSampler {
 public:
  // Called once per frame, in order.
  using Visitor = std::function<void(int frame, const FrameStates& states)>;

  // `stencils` must outlive the sampler; first_step and last_step must never decrease.
  FrameSampler(const std::vector<FrameStencil>* stencils, Visitor visitor);
  // `state` [3N x c] after `step` steps; steps 0, 1, 2, .. in order.
  void AddStep(int step, const Eigen::Ref<const Eigen::MatrixXd>& state);
  // The state after that step for the frames that end after it, in place of the one that was added.
  void ReplaceStep(int step, const Eigen::Ref<const Eigen::MatrixXd>& state) { kept(step) = state; }

 private:
  Eigen::MatrixXd& kept(int step) { return kept_[static_cast<std::size_t>(step) % kept_.size()]; }
  const Eigen::MatrixXd& kept(int step) const { return kept_[static_cast<std::size_t>(step) % kept_.size()]; }

  const std::vector<FrameStencil>* stencils_;
  Visitor visitor_;
  std::size_t next_frame_ = 0;
  std::vector<Eigen::MatrixXd> kept_;  // the latest states, that of step s at place s modulo their number
};

}  // namespace clothid

#endif  // CLOTHID_DATASETS_OBSERVATION_FRAME_STENCIL_H_
