// The derivative of all residuals of a recording with respect to its prediction, at one prediction.
//
// Of tracked points it is the same everywhere, P/sigma; the rows of clouds depend on where the cloth is. So whoever
// differentiates says first at which prediction.
#ifndef CLOTHID_DATASETS_OBSERVATION_RESIDUAL_DERIVATIVE_H_
#define CLOTHID_DATASETS_OBSERVATION_RESIDUAL_DERIVATIVE_H_

#include <Eigen/Core>
#include <vector>

#include "datasets/observation/cloud_observation.h"
#include "datasets/observation/observation.h"

namespace clothid {

class ResidualDerivative {
 public:
  // `observation` must outlive it. `predicted` [R x T] m.
  ResidualDerivative(const Observation* observation, const Eigen::MatrixXd& predicted);

  // What a change of the prediction [R x T] is of the residual [m].
  Eigen::VectorXd Apply(const Eigen::MatrixXd& change) const;
  // The same for one row of the residual, per m that points and nodes of its frame are shifted along x, y and z.
  Eigen::RowVector3d OfShift(int row) const;
  // The transpose for one frame: adds  weight (d residual of the frame/d nodes)^T seeds,  seeds [m x s], to `gradient`
  // [3N x s].
  void AddFrameSeeds(int frame, double weight, const Eigen::MatrixXd& seeds, Eigen::MatrixXd* gradient) const;

 private:
  const Observation* observation_;
  std::vector<CloudRows> cloud_rows_;  // [T], or empty without clouds
};

}  // namespace clothid

#endif  // CLOTHID_DATASETS_OBSERVATION_RESIDUAL_DERIVATIVE_H_
