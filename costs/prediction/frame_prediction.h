// How a recording is predicted at one value of its own parameters (costs/prediction/alignment.h), in this order:
//   1. the steps of every frame,            costs/prediction/frame_interpolation.h
//   2. the observed points at its time,     datasets/observation/observation.h
//   3. their rigid correction,              costs/prediction/rigid_correction.h
// and the transpose. Where nothing is corrected, 3 is the identity and takes no time.
#ifndef CLOTHID_COSTS_PREDICTION_FRAME_PREDICTION_H_
#define CLOTHID_COSTS_PREDICTION_FRAME_PREDICTION_H_

#include <Eigen/Core>
#include <vector>

#include "costs/prediction/alignment.h"
#include "costs/prediction/frame_interpolation.h"
#include "costs/prediction/rigid_correction.h"
#include "datasets/observation/frame_stencil.h"
#include "datasets/observation/observation.h"
#include "datasets/observation/residual_derivative.h"

namespace clothid {

class FramePrediction {
 public:
  // center: c of the correction, m. `observation` must outlive the prediction.
  FramePrediction(const Alignment& alignment, const Eigen::Vector3d& center, const FrameInterpolation& interpolation,
                  const Observation* observation);

  const std::vector<FrameStencil>& stencils() const { return stencils_; }  // [T]

  // Of states [3N x (1 + c)], positions and c changes of them: the prediction [R] m of the frame (see Observation), and
  // what the changes are of it, [R x (1 + c)].
  Eigen::MatrixXd Points(int frame, const FrameStates& states) const;
  // The time derivative of the prediction [R] m/s; zero where the interpolation is linear.
  Eigen::VectorXd Velocities(int frame, const FrameStates& states) const;

  // d points/d id [R] of a frame, in the unit of `id`, for a fixed rollout: zero for start velocity, shift of
  // handles and force bias.
  // `points` and `velocities`: of the frame; only the time offset needs velocities.
  Eigen::VectorXd Derivative(ParameterId id, const Eigen::VectorXd& points, const Eigen::VectorXd& velocities) const;

  // Of the frames that hold a step: those that end there, or those that go on.
  enum class FramesOf { kAll, kEnding, kGoingOn };
  // Adds to `gradient` [3N x s] the part at `step` of  dC/dx = (d residual/dx)^T seeds,  seeds [m x s], of `frames`.
  void AddSeeds(int step, FramesOf frames, const Eigen::MatrixXd& seeds, const ResidualDerivative& derivative,
                Eigen::MatrixXd* gradient) const;

 private:
  const Observation* observation_;
  std::vector<FrameStencil> stencils_;
  RigidCorrection correction_;
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_PREDICTION_FRAME_PREDICTION_H_
