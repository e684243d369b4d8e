// How a recording is predicted where parameters of its own are fitted (costs/prediction/alignment.h), in this order:
//   1. the state of the nodes at the time of each frame, costs/prediction/frame_interpolation.h
//   2. the rigid correction of the nodes, costs/prediction/rigid_correction.h
//   3. the observed points of the nodes, datasets/observation/observation.h
// and the transpose. Points are affine combinations of nodes, so 2 and 3 may change places.
#ifndef CLOTHID_COSTS_PREDICTION_ALIGNED_PREDICTION_H_
#define CLOTHID_COSTS_PREDICTION_ALIGNED_PREDICTION_H_

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "costs/prediction/alignment.h"
#include "costs/prediction/frame_interpolation.h"
#include "costs/prediction/rigid_correction.h"
#include "datasets/observation/observation.h"

namespace clothid {

// At one value of the alignment.
class AlignedPrediction {
 public:
  // center: c of the correction, m. `observation` must outlive the prediction.
  AlignedPrediction(const Alignment& alignment, const Eigen::Vector3d& center, const FrameInterpolation& interpolation,
                    const Observation* observation);

  // Called once per frame, in order. State [3N x (1 + c)]: positions and c changes of them. Points: the prediction [R]
  // m (see Observation), its time derivative [R] m/s, and what the changes are of it [R x c].
  using Visitor = std::function<void(int frame, const Eigen::VectorXd& points, const Eigen::VectorXd& velocities,
                                     const Eigen::MatrixXd& changes)>;
  // Takes the states step by step. The prediction must outlive it.
  FrameStateSampler MakeSampler(Visitor visitor) const;

  // d points/d id [R] of a frame, in the unit of `id`, for a fixed rollout: zero for the start velocity.
  Eigen::VectorXd Derivative(AlignmentId id, const Eigen::VectorXd& points, const Eigen::VectorXd& velocities) const;

  // Adds to `gradient` [3N x s] the part at `step` of  dC/dx = (d residual/dx)^T seeds,  seeds [m x s].
  // `cloud_rows`: of Observation::LinearizeClouds at the prediction.
  void AddSeeds(int step, const Eigen::MatrixXd& seeds, Eigen::MatrixXd* gradient,
                const std::vector<CloudRows>& cloud_rows = {}) const;

 private:
  const Observation* observation_;
  std::vector<FrameStencil> stencils_;  // [T]
  RigidCorrection correction_;
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_PREDICTION_ALIGNED_PREDICTION_H_
