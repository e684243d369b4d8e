// The force with which what holds the handles of a cloth acts on it: what a robot's wrist sensor or the gauge of a
// tensile test measures, to the sign.
//
// Of a group of handles i, summed over it, at the end of a step:
//   R = sum of  M_i a_i - f_i
// with f_i all forces on the handle's node but contact (sim/cloth/cloth_model.h). R is a function of the positions at
// the ends of three successive steps x_0, x_1, x_2 and of the parameters alone, so that its derivatives need nothing
// from the sweeps (sim/derivative) but those of positions; contacts of the cloth with itself push handles as
// pair_forces.h says, which is taken off apart:
//   v = sum r_k x_k,   a = (x_0 - 2 x_1 + x_2)/h^2,   Edot = 1/2 sum r_k C(x_k)   (strain_rate_damping.h)
// and all else at the step's own x_q.
//   backward Euler   q = 2, r = (0, -1, 1)/h: to the tolerance of the steps the force that closes the balance of
//                    momentum of the step, as exact as the scheme: of first order in h. Not in the first step. The
//                    normals of drag by direction are at x^ = 2 x_1 - x_0, as they were in the step, of handles x_2.
//   SDIRK2           q = 1, r = (-1, 0, 1)/(2 h): of second order in h where the handles' acceleration is continuous,
//                    impacts apart
// Where the window of three would reach over an end of the rollout it is shifted, and r are the slopes of the parabola
// through it: there a is of first order. Steps that were cut into substeps are taken as one.
#ifndef CLOTHID_SIM_ROLLOUT_HANDLE_FORCES_H_
#define CLOTHID_SIM_ROLLOUT_HANDLE_FORCES_H_

#include <Eigen/Core>
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/rollout/sized_models.h"
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

  // `groups` [G]: nodes of the scene, each a handle. `model` must outlive the object and have the fields, the pieces
  // and the size of `parameters`, `Simulator::UseParameters`. `ids`: what it will be differentiated by; sizes among
  // them are prepared for. Throws `Error` (kBadData) for a group without nodes or a node that is none.
  HandleForces(const ClothModel& model, const Parameters& parameters, int num_steps,
               const std::vector<std::vector<int>>& groups, const std::vector<ParameterId>& ids = {});

  int num_groups() const { return static_cast<int>(groups_.size()); }  // G
  int num_steps() const { return num_steps_; }
  // The nodes that forces depend on [n], ascending: those around the handles.
  const std::vector<int>& nodes() const { return part_.nodes; }
  // Their rows of columns over all nodes [3N x c]: [3n x c].
  Eigen::MatrixXd Gather(const Eigen::Ref<const Eigen::MatrixXd>& all) const;
  ForceWindow Window(int step) const;

  // R [3G] N after `step` steps, from the first columns of the states of its window.
  Eigen::VectorXd At(int step, const States& states) const;
  // The moments of the same forces about the mean c of the positions of a group, with those by which a clamp turns its
  // slopes d (Handles::slopes) [3G] N m:
  //   sum of (x_i - c) x R_i + sum over its edges of d x dE/dd
  Eigen::VectorXd MomentsAt(int step, const States& states) const;
  // dR/dx_k [3G x 3n] N/m.
  std::array<Eigen::MatrixXd, 3> Jacobian(int step, const States& states) const;
  // dR/d(parameter) [3G] at fixed positions, in the parameter's own unit; zero for friction. Throws `std::logic_error`
  // for a size that was not among the `ids`.
  Eigen::VectorXd ParameterDerivative(ParameterId id, int step, const States& states) const;

  // dR/d(logarithm of the value that a field of the parameters has in a triangle) at fixed positions [3G x K F],
  // columns as the rows of `SensitivityDirections::fields`; no columns without fields.
  Eigen::MatrixXd FieldDerivative(int step, const States& states) const;

  // R after every step [3G x (num_steps + 1)] from the positions of `nodes()` after every step [3n x (num_steps + 1)].
  Eigen::MatrixXd Over(const Eigen::MatrixXd& positions) const;
  // Likewise the moments.
  Eigen::MatrixXd MomentsOver(const Eigen::MatrixXd& positions) const;
  // The sums over groups [3G x c] of columns over the scene's handles, in their order [3H x c]; and the transpose.
  Eigen::MatrixXd OverGroups(const Eigen::MatrixXd& handles) const;
  Eigen::MatrixXd OverGroupsTransposed(const Eigen::MatrixXd& groups) const;

  // The first columns of the window of `step`, of the same positions.
  States StatesAt(int step, const Eigen::MatrixXd& positions) const;

 private:
  // Of a node of a group.
  struct Handle {
    int group;
    int node;   // of the mesh
    int local;  // its place in nodes()
  };
  // Where the forces of a step are evaluated, over nodes().
  struct Place {
    ForceWindow window;
    double time;                           // s
    std::array<Eigen::VectorXd, 3> steps;  // x_k
    Eigen::VectorXd velocities;            // v
    HeldForces held;
  };
  // The same forces of the cloth at another size, whose share in the derivative by one is `weight`.
  struct Sized {
    ParameterId id;
    double weight;
    std::unique_ptr<const HandleForces> forces;
  };

  struct WithoutPart {};
  HandleForces(WithoutPart, const ClothModel& model, const Parameters& parameters, int num_steps,
               const std::vector<std::vector<int>>& groups);
  void SetPart(const std::vector<std::vector<int>>& coupled);  // of `MakeForcePart`
  std::vector<int> HandleNodes() const;
  Place PlaceOf(int step, const States& states) const;
  ForcePoint PointOf(const Place& place) const {
    return {parameters_, time_step_, place.time, place.steps[static_cast<std::size_t>(place.window.place)],
            place.velocities};
  }
  // How the step's own x^ is made of the x_k, of nodes that are no handles.
  std::array<double, 3> PredictionShares(const ForceWindow& window) const;
  // Of the x_k in C_o with Edot = (C(x_q) - C_o)/(2 h).
  std::array<double, 3> OriginShares(const ForceWindow& window) const;
  // All forces in the cloth and by the air at a place [3n].
  Eigen::VectorXd ForceAt(const Place& place) const;
  NodeMotion MotionAt(const Handle& handle, const Place& place) const;  // over a unit of time: a in place of a change
  Eigen::Index FirstRowOf(const Handle& handle) const;                  // in columns over the scene's handles
  // Takes the sums of a force [3n] over groups off `sums` [3G].
  void SubtractSums(const Eigen::VectorXd& force, Eigen::VectorXd* sums) const;
  void AddMassColumns(const FieldFactors& field, const Place& place, Eigen::Ref<Eigen::MatrixXd> derivative) const;

  const ClothModel& model_;
  Parameters parameters_;
  int num_steps_;
  double time_step_;  // h, s
  std::vector<std::vector<int>> groups_;
  std::vector<Handle> handles_;
  ForcePart part_;
  ForceSet forces_;            // of the part
  Eigen::MatrixXd selection_;  // [3n x 3G] 1 where a coordinate of a handle belongs to a group
  std::vector<SizedModel> sized_models_;
  std::vector<Sized> sized_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_ROLLOUT_HANDLE_FORCES_H_
