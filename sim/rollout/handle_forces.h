// The force with which what holds the handles of a cloth acts on it: what a robot's wrist sensor or the gauge of a
// tensile test measures, to the sign.
//
// Of a group of handles i, summed over it, at the end of a step:
//   R = sum of  M_i a_i - f_int,i - f_ext,i
// with f_int stretch, bending and internal damping, and f_ext gravity, the scene's node force and drag, all on the
// handle's node (sim/step/step_problem.h). R is a function of the positions at the ends of three successive steps
// x_0, x_1, x_2 and of the parameters alone, so that its derivatives need nothing from the sweeps (sim/derivative) but
// those of positions; contacts of the cloth with itself push handles as pair_forces.h says, which is taken off apart:
//   v = sum r_k x_k,   a = (x_0 - 2 x_1 + x_2)/h^2,   Edot = 1/2 sum r_k C(x_k)   (strain_rate_damping.h)
// and the elastic force at the step's own x_q.
//   backward Euler   q = 2, r = (0, -1, 1)/h: to the tolerance of the steps the force that closes the balance of
//                    momentum of the step, as exact as the scheme: of first order in h. Not in the first step.
//   SDIRK2           q = 1, r = (-1, 0, 1)/(2 h): of second order in h where the handles' acceleration is continuous,
//                    impacts apart
// Where the window of three would reach over an end of the rollout it is shifted, and r are the slopes of the parabola
// through it: there a is of first order. Steps that were cut into substeps are taken as one.
#ifndef CLOTHID_SIM_ROLLOUT_HANDLE_FORCES_H_
#define CLOTHID_SIM_ROLLOUT_HANDLE_FORCES_H_

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/cloth/stretch_energy.h"
#include "sim/scene/material_field.h"
#include "sim/scene/parameters.h"

namespace clothid {

// The fewest steps that a rollout with forces must have.
inline constexpr int kFewestForceSteps = 2;

// The three successive steps that the force after one of them is a function of.
struct ForceWindow {
  int first_step = 0;
  int place = 0;                // q
  std::array<double, 3> rates;  // r, 1/s

  int last_step() const { return first_step + 2; }
};

// Of step 0 .. num_steps, whose last_step never decreases.
ForceWindow WindowOfForce(int step, int num_steps, Integrator integrator, double time_step);

class HandleForces {
 public:
  // The positions [3n x c] of `nodes()` after the three steps of a window: their first column, and further ones that
  // are changes of them.
  using States = std::array<Eigen::MatrixXd, 3>;

  // `groups` [G]: nodes of the scene, each a handle. `model` must outlive the object and have the fields of
  // `parameters`, `Simulator::UseParameters`. Throws `Error` (kBadData) for a group without nodes or a node that is
  // none, and for scenes with drag by direction or with a curved rest shape, whose forces at handles nobody has
  // derived.
  HandleForces(const ClothModel& model, const Parameters& parameters, int num_steps,
               const std::vector<std::vector<int>>& groups);

  int num_groups() const { return static_cast<int>(groups_.size()); }  // G
  int num_steps() const { return num_steps_; }
  // The nodes that forces depend on [n], ascending: those around the handles.
  const std::vector<int>& nodes() const { return nodes_; }
  // Their rows of columns over all nodes [3N x c]: [3n x c].
  Eigen::MatrixXd Gather(const Eigen::Ref<const Eigen::MatrixXd>& all) const;
  ForceWindow Window(int step) const;

  // R [3G] N after `step` steps, from the first columns of the states of its window.
  Eigen::VectorXd At(int step, const States& states) const;
  // dR/dx_k [3G x 3n] N/m.
  std::array<Eigen::MatrixXd, 3> Jacobian(int step, const States& states) const;
  // dR/d(parameter) [3G] at fixed positions, in the parameter's own unit; zero for friction.
  Eigen::VectorXd ParameterDerivative(ParameterId id, int step, const States& states) const;

  // dR/d(logarithm of the value that a field of the parameters has in a triangle) at fixed positions [3G x K F],
  // columns as the rows of `SensitivityDirections::fields`; no columns without fields.
  Eigen::MatrixXd FieldDerivative(int step, const States& states) const;

  // R after every step [3G x (num_steps + 1)] from the positions of `nodes()` after every step [3n x (num_steps + 1)].
  Eigen::MatrixXd Over(const Eigen::MatrixXd& positions) const;
  // The sums over groups [3G x c] of columns over the scene's handles, in their order [3H x c]; and the transpose.
  Eigen::MatrixXd OverGroups(const Eigen::MatrixXd& handles) const;
  Eigen::MatrixXd OverGroupsTransposed(const Eigen::MatrixXd& groups) const;

  // The first columns of the window of `step`, of the same positions.
  States StatesAt(int step, const Eigen::MatrixXd& positions) const;

 private:
  // Of a node of a group.
  struct Handle {
    int group;
    int node;          // of the mesh
    int local;         // its place in nodes()
    double mass_area;  // what has weight over the density, m^2
    double inertia;    // M, kg: of the cloth and of the air that moves with it
    double drag_area;  // m^2; 0: no drag
  };
  struct Bending {
    ParameterKind kind;
    double stiffness;
    Eigen::SparseMatrix<double> rows;  // of Q, those of the handles of a group summed up [G x n]
  };

  void FindNodes(const std::vector<std::vector<int>>& groups);
  void MakeTriangles(const Parameters& parameters);
  void MakePieces(const Parameters& parameters);
  void MakeBending();
  // Those of Q [N x N], as `Bending` has them.
  Eigen::SparseMatrix<double> RowsOf(const Eigen::SparseMatrix<double>& matrix) const;
  // What eta `id` multiplies.
  StrainRateDamping DampingOf(ParameterId id) const;
  Eigen::Index FirstRowOf(const Handle& handle) const;  // in columns over the scene's handles
  Eigen::Vector3d Derivative(const std::array<double, 3>& weights, const Handle& handle, const States& states) const;
  Eigen::Vector3d Acceleration(const Handle& handle, const States& states) const;  // a, m/s^2
  // The velocity of a handle to the air around it, m/s; and dR/dx_k of drag, kg/s. All that is said of air is here.
  Eigen::Vector3d AirSpeed(int step, const Handle& handle, const States& states) const;
  double AirSlope(const Handle& handle, double rate) const { return material_.drag * handle.drag_area * rate; }
  // S with Edot = (C(x_q) - S)/(2 h), as the code of damping takes it; q's own share of it is there, too.
  std::array<double, 3> MetricShares(const ForceWindow& window) const;
  std::vector<MetricBatch> StartMetrics(const ForceWindow& window, const States& states) const;
  // Adds stiffness times the sums of Q x over groups to `sums` [3G].
  void AddBending(const Bending& bending, double stiffness, const Eigen::VectorXd& positions,
                  Eigen::VectorXd* sums) const;
  // Takes the sums of a force [3n] over groups off `sums` [3G].
  void SubtractSums(const Eigen::VectorXd& force, Eigen::VectorXd* sums) const;

  // What the triangles owe to fields of stretch, density and bending, added to `derivative` [3G x F].
  void AddStretchColumns(int step, const States& states, Eigen::Ref<Eigen::MatrixXd> derivative) const;
  void AddMassColumns(const FieldFactors& field, const States& states, Eigen::Ref<Eigen::MatrixXd> derivative) const;
  void AddBendingColumns(const FieldFactors& field, int step, const States& states,
                         Eigen::Ref<Eigen::MatrixXd> derivative) const;

  const ClothModel& model_;
  Material material_;
  Wind wind_;
  int num_steps_;
  double time_step_;  // h, s
  std::vector<std::vector<int>> groups_;
  std::vector<Handle> handles_;
  std::vector<int> nodes_, faces_;  // of the mesh, ascending
  std::vector<int> local_;          // [N] the place in nodes_, -1: none
  Eigen::MatrixXd selection_;       // [3n x 3G] 1 where a coordinate of a handle belongs to a group
  std::shared_ptr<const BlockPattern> pattern_;
  std::shared_ptr<const std::vector<FieldFactors>> fields_;  // null: none
  std::optional<Membrane> membrane_;                         // of the triangles at handles, over nodes_
  std::optional<StretchEnergy> stretch_;                     // of the same, where stretch is a field
  std::optional<StrainRateDamping> damping_;                 // likewise
  std::shared_ptr<const TriangleElements> triangles_;        // what all of them are made of
  std::vector<Bending> bending_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_ROLLOUT_HANDLE_FORCES_H_
