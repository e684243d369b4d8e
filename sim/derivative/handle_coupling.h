// What a step owes to the positions of the handles, which its equations take as given.
//
// With x_h the handles at the end of a step and x_h,n those at its start, the gradient g of sim/step/step_problem.h
// changes at fixed velocities of the free nodes by
//   dg = (h H_fh + C_fh + N_fh) dx_h + (h V_fh - C_fh) dx_h,n
// where H_fh, V_fh and N_fh are the columns of the handles, in the rows of the free nodes, of the H, V and N of
// sim/derivative/step_derivative.h; V is there with internal damping alone, N with drag by direction alone. So is C =
// d2D/dv2: the velocity of a handle is (x_h - x_h,n)/h. In a second stage, which starts from x_s, h V_fh dx_h,n gives
// way to what V_n and V_1 owe to the handles at the start of the step and at the end of its first stage, and dx_h,n to
// (1 - kappa) dx_h,n + kappa dx_h,1. Made by the code of H itself, of a cloth whose handles are free.
//
// Pairs of the cloth with itself in contact, of which handles are nodes (impulse_blocks.h), add what their weights owe
// to dx_h,n, and have equations of their own, which are rows of `StepColumns`, too:
//   dR = (dR/dx_n) dx_h,n + (dR/dv_h) (dx_h - dx_h,n)/h
#ifndef CLOTHID_SIM_DERIVATIVE_HANDLE_COUPLING_H_
#define CLOTHID_SIM_DERIVATIVE_HANDLE_COUPLING_H_

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/derivative/step_derivative.h"
#include "sim/rollout/step_record.h"
#include "sim/scene/material_field.h"
#include "sim/scene/parameters.h"
#include "sim/step/step_problem.h"

namespace clothid {

// The velocity of handles over the solve that `record` ends, (x_h - x_h,n)/h: a sum of their positions at times, each
// with its weight.
struct HandleSpeedTerm {
  double time;    // s
  double weight;  // 1/s
};
std::vector<HandleSpeedTerm> HandleSpeedTerms(const StepRecord& record);

class HandleCoupling {
 public:
  // `model` must outlive the object.
  explicit HandleCoupling(const ClothModel& model);
  HandleCoupling(const HandleCoupling&) = delete;
  HandleCoupling& operator=(const HandleCoupling&) = delete;

  // The solve that `record` ends and `step` is the derivative of. All of these and what `start` refers to must live
  // until the next call.
  void SetStep(const StepRecord& record, const SolveStart& start, const Parameters& parameters,
               const StepDerivative& step);

  // The places of the handles that count: the first at the end of the solve; the others before are there with internal
  // damping, drag by direction or pairs in contact alone.
  int num_places() const { return static_cast<int>(times_.size()); }
  double time(int place) const { return times_[place]; }  // s

  // The product with columns over the handles at a place [3H x s], in the order of the scene's: dg and dR.
  StepColumns Times(int place, const Eigen::MatrixXd& columns) const;
  // That with the transpose: [3H x s].
  Eigen::MatrixXd TimesTransposed(int place, const StepColumns& columns) const;
  // Likewise what the pairs' force upon handles, sum w_i r/h [3H] N, owes to their weights at fixed r.
  Eigen::MatrixXd ContactForceTimes(int place, const Eigen::MatrixXd& columns) const;
  Eigen::MatrixXd ContactForceTimesTransposed(int place, const Eigen::MatrixXd& columns) const;

 private:
  Eigen::MatrixXd TimesHessian(const Eigen::MatrixXd& all) const;  // (h H + C) y, with the masses that K has
  ForcePoint point() const;

  const ClothModel& model_;
  Scene scene_;       // without handles
  ClothModel whole_;  // of that scene, with the fields of the latest step
  BlockMatrix hessian_;
  HeldForces held_;
  const StepRecord* record_ = nullptr;
  const ImpulseBlocks* impulses_ = nullptr;
  const Parameters* parameters_ = nullptr;
  std::vector<double> times_;  // of the places
  // Of the places before the end, and how much of V and -C they have.
  struct Origin {
    const Eigen::VectorXd* positions;
    double share;
  };
  std::vector<Origin> origins_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_DERIVATIVE_HANDLE_COUPLING_H_
