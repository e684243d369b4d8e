// What a step owes to the positions of the handles, which its equations take as given.
//
// With x_h the handles at the end of a step and x_h,n those at its start, the gradient g of sim/step/step_problem.h
// changes at fixed velocities of the free nodes by
//   dg = h H_fh dx_h + h V_fh dx_h,n
// where H_fh and V_fh are the columns of the handles, in the rows of the free nodes, of the H and V of
// sim/derivative/step_derivative.h; V is there with internal damping alone. Made by the code of H itself, of a cloth
// whose handles are free.
#ifndef CLOTHID_SIM_DERIVATIVE_HANDLE_COUPLING_H_
#define CLOTHID_SIM_DERIVATIVE_HANDLE_COUPLING_H_

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/rollout/step_record.h"
#include "sim/scene/parameters.h"

namespace clothid {

class HandleCoupling {
 public:
  // `model` must outlive the object.
  explicit HandleCoupling(const ClothModel& model);
  HandleCoupling(const HandleCoupling&) = delete;
  HandleCoupling& operator=(const HandleCoupling&) = delete;

  // The step that `record` ends and that started from `start_positions` [3N]. Both must live until the next call.
  void SetStep(const StepRecord& record, const Eigen::VectorXd& start_positions, const Parameters& parameters);

  // h H_fh y + h V_fh y_n [3 Nf x s], for columns y at the end and y_n at the start over the handles [3H x s], in the
  // order of the scene's.
  Eigen::MatrixXd Times(const Eigen::MatrixXd& end, const Eigen::MatrixXd& start) const;

  // The transpose: adds h H_fh^T y to `end` and h V_fh^T y to `start` [3H x s], y [3 Nf x s].
  void AddTransposed(const Eigen::MatrixXd& columns, Eigen::MatrixXd* end, Eigen::MatrixXd* start) const;

 private:
  // Columns over the handles as columns over all nodes [3N x s], zero at free nodes; and the other way.
  Eigen::MatrixXd FromHandles(const Eigen::MatrixXd& columns) const;
  void AddHandleRows(const Eigen::MatrixXd& all, Eigen::MatrixXd* columns) const;
  Eigen::MatrixXd TimesHessian(const Eigen::MatrixXd& all) const;  // h H y, with the masses that K has
  Eigen::MatrixXd TimesMixed(const Eigen::VectorXd& positions, const Eigen::VectorXd& start_positions,
                             const Eigen::MatrixXd& all) const;  // h V y, h V^T y with the positions exchanged

  const ClothModel& model_;
  Scene scene_;       // without handles
  ClothModel whole_;  // of that scene
  BlockMatrix hessian_;
  std::vector<MetricBatch> start_metrics_;
  const StepRecord* record_ = nullptr;
  const Eigen::VectorXd* start_positions_ = nullptr;
  double damping_ = 0.0;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_DERIVATIVE_HANDLE_COUPLING_H_
