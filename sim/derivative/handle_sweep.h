// What sweeps do with the path of the handles: one object per sweep, which does nothing where no handle moves.
#ifndef CLOTHID_SIM_DERIVATIVE_HANDLE_SWEEP_H_
#define CLOTHID_SIM_DERIVATIVE_HANDLE_SWEEP_H_

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/derivative/handle_coupling.h"
#include "sim/derivative/second_start_derivative.h"
#include "sim/rollout/rollout.h"

namespace clothid {

// Forward: how the handles move along directions, and what that does to a step.
class HandleTangent {
 public:
  // `columns`: changes of `offsets`, as of `SensitivityDirections::handle_offsets`. Throws `std::logic_error` where
  // they have other sizes. All must outlive the object.
  HandleTangent(const Eigen::MatrixXd& columns, const HandlePath* offsets, const ClothModel& model);

  bool is_empty() const { return coupling_ == nullptr; }

  // Takes its part off the last columns of `right` [x (p + q)].
  void Subtract(const StepRecord& record, const SolveStart& start, const Parameters& parameters,
                const StepDerivative& step, StepColumns* right);
  // Of the same solve, adds what the weights of its pairs change in their force upon handles to the last columns of
  // `forces` [3H x (p + q)].
  void AddContactForces(Eigen::MatrixXd* forces) const;

  // Takes what the impacts of pairs in the stage `first` owe to the handles off the last columns of `velocities`, dv_s.
  void SubtractImpacts(const StepRecord& first, const SecondStartDerivative& derivative,
                       Eigen::MatrixXd* velocities) const;
  // The solve that ends a step: its handles' velocities are those that the next one starts with.
  void EndStep(const StepRecord& record);

  // Writes the handles' rows of the last columns of `all` [3N x (p + q)] at a time.
  void SetRows(double time, Eigen::MatrixXd* all) const;

 private:
  Eigen::MatrixXd At(double time) const;  // [3H x (q - first_)]
  // Zero where there are no terms: handles start with the velocities that the rollout is given.
  Eigen::MatrixXd Sum(const std::vector<HandleSpeedTerm>& terms) const;

  const Eigen::MatrixXd& columns_;
  const HandlePath* offsets_;
  const std::vector<int>& nodes_;
  Eigen::Index first_ = 0;  // the first column that moves a handle
  std::unique_ptr<HandleCoupling> coupling_;
  std::vector<HandleSpeedTerm> start_speed_;  // of the handles' velocities at the start of the step
};

// Reverse: gathers dC/d(handle offsets) [3 H K x s].
class HandleGradient {
 public:
  // Both must outlive the object.
  HandleGradient(const Rollout& rollout, int num_columns, const ClothModel& model);

  // Of a scalar that depends on the handles' positions at `time` itself, dC/dx [3N x s].
  void AddSeed(double time, const Eigen::MatrixXd& seed);

  // Through a solve: (y, rho), y = (I + S)^T z of it.
  void AddSolve(const StepRecord& record, const SolveStart& start, const StepDerivative& step, const StepColumns& y);
  // Of the same solve, through the weights of its pairs in their force upon handles, by which the gradient is given
  // [3H x s].
  void AddContactForces(const Eigen::MatrixXd& by_forces);

  // Through the impacts of pairs in the stage `first`, of gradients by x_s and v_s.
  void AddImpacts(const StepRecord& first, const SecondStartDerivative& derivative, const StateColumns& second);
  // The solve that ends a step: the velocities of its handles are those that the step after it has started with.
  void EnterStep(const StepRecord& record);

  Eigen::MatrixXd& values() { return values_; }

 private:
  void AddSpeed(const StepRecord& record, const Eigen::MatrixXd& rows);  // by the handles' velocities over a solve
  void Add(double time, const Eigen::MatrixXd& rows);

  const HandlePath& offsets_;
  const ClothModel& model_;
  const Parameters& parameters_;
  std::unique_ptr<HandleCoupling> coupling_;
  Eigen::MatrixXd values_;
  Eigen::MatrixXd by_start_speed_;  // of the step that was swept last [3H x s]; empty: zero
};

}  // namespace clothid

#endif  // CLOTHID_SIM_DERIVATIVE_HANDLE_SWEEP_H_
