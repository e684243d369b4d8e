// What constants that vary over the cloth (sim/scene/material_field.h) do to the solves of a rollout, for both sweeps.
//
// The unknowns are the logarithms of their values, one per triangle: F of the scene's first field, then F of its
// second, .. [K F]. With theta_f that of triangle f, h the size of the solve:
//   stretch, bending   dg/dtheta_f = h dE_f/dx,   E_f the energy of the triangle, or its share of that of its edges
//   density            dg/dtheta_f = m_f (v - v_n - h g_0) at the corners, m_f a third of the triangle's mass
// and the masses that second_start_derivative.h asks for change by m_f at the corners.
#ifndef CLOTHID_SIM_DERIVATIVE_FIELD_DERIVATIVE_H_
#define CLOTHID_SIM_DERIVATIVE_FIELD_DERIVATIVE_H_

#include <Eigen/Core>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/derivative/second_start_derivative.h"
#include "sim/rollout/step_record.h"
#include "sim/scene/parameters.h"
#include "sim/step/stage.h"

namespace clothid {

// Forward: along columns [K F x q], which are the last ones of the sweep. Nothing without columns.
class FieldTangent {
 public:
  // The parameters' fields must be in the model, `Simulator::UseParameters`. Throws `std::logic_error` where the
  // columns have other rows.
  FieldTangent(const Eigen::MatrixXd& columns, const Parameters& parameters, const ClothModel& model);

  // Takes dg of a solve off the last columns of `right` [3 Nf x c].
  void Subtract(const StepRecord& record, const SolveStart& start, Eigen::MatrixXd* right) const;
  // Takes what the change of masses does off the last columns of dv_s.
  void SubtractMasses(const SecondStartDerivative& derivative, StateColumns* second) const;

 private:
  // What a column changes.
  struct Direction {
    std::vector<ForceTerm::FieldDirection> forces;
    Eigen::VectorXd masses;  // [N] kg
  };

  const Parameters& parameters_;
  const ClothModel& model_;
  std::vector<Direction> directions_;
};

// Reverse: gathers the gradients [K F x s] over the sweep. Nothing where the parameters have no fields.
class FieldGradient {
 public:
  FieldGradient(const Parameters& parameters, int num_columns, const ClothModel& model);

  // Through a solve, y = (I + S)^T z of it [3 Nf x s].
  void AddSolve(const StepRecord& record, const SolveStart& start, const Eigen::MatrixXd& y);
  // Through the masses at the start of a second stage.
  void AddSecondStart(const SecondStartDerivative& derivative, const StateColumns& second);

  Eigen::MatrixXd& values() { return values_; }

 private:
  bool is_empty() const { return values_.rows() == 0; }
  // From a gradient by the nodes' masses [N x s] to the rows of a field of the density.
  void AddMassGradient(const Eigen::MatrixXd& by_mass, Eigen::Index first_row);

  const Parameters& parameters_;
  const ClothModel& model_;
  Eigen::VectorXd third_masses_;  // m_f [F] kg; empty unless the density is a field
  Eigen::MatrixXd values_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_DERIVATIVE_FIELD_DERIVATIVE_H_
