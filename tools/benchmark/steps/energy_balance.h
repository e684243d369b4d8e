// Where the energy of a rollout comes from and where it goes.
//
// Energy E_n = kinetic and gravitational energy of the free nodes + stretch and bending energy of the whole cloth. The
// step M (v_1 - v_0) = h (f_ext + f_int(x_1)) + J^T r + e, e its residual, times v_1, with x_1 - x_0 = h v_1 at free
// nodes, U stretch and bending, f = -dU/dx at x_1 and f_d the force of internal damping, is exactly
//   E_1 - E_0 = W_force + W_air + W_handles + W_contact - D_inertia - D_damping - D_elastic + e . v_1
//   W_force   = sum over free nodes of node_force . (x_1 - x_0)
//   W_air     = sum over free nodes of h c_d a (w - v_1) . v_1
//   W_handles = -(f + f_d) . (x_1 - x_0) over the handles: what holds a handle acts against the cloth
//   W_contact = sum over contacts of J^T r . v_1; of it W_push = the part of normal impulses that do positive work:
//               where a node starts inside an obstacle
//   D_inertia = 1/2 (v_1 - v_0) . M (v_1 - v_0) >= 0, what backward Euler takes from every change of velocity
//   D_damping = -f_d . (x_1 - x_0) over all nodes, what internal damping takes
//   D_elastic = U(x_0) - U(x_1) - f . (x_1 - x_0) over all nodes: >= 0 where U is convex from x_0 to x_1, which it is
//               not where cloth is compressed
// So a step can gain energy that no work pays for, by D_elastic < -(D_inertia + D_damping): a property of backward
// Euler on buckling cloth, not an error. It is summed as the excess. Whatever is left over is e . v_1, for which |e| <=
// tolerance * scale bounds it: more would be an error of a force, of an energy or of the solver.
#ifndef CLOTHID_TOOLS_BENCHMARK_STEPS_ENERGY_BALANCE_H_
#define CLOTHID_TOOLS_BENCHMARK_STEPS_ENERGY_BALANCE_H_

#include <Eigen/Core>

#include "sim/rollout/rollout.h"

namespace clothid {

class Simulator;

// The balance of one solve, or of several: they add up. J.
struct EnergyFlow {
  double change = 0.0;  // E_1 - E_0
  double force_work = 0.0, air_work = 0.0, handle_work = 0.0, contact_work = 0.0;
  double push_work = 0.0;  // part of contact_work
  double inertia_loss = 0.0, damping_loss = 0.0, elastic_loss = 0.0;
  double tolerance = 0.0;  // of unexplained(): that of the solver, |v_1| times the residual, and of rounding

  double work() const { return force_work + air_work + handle_work + contact_work; }
  // E_1 - E_0 beyond the work: positive where energy was gained without a source.
  double excess() const { return change - work(); }
  // e . v_1 and rounding.
  double unexplained() const { return excess() + inertia_loss + damping_loss + elastic_loss; }

  EnergyFlow& operator+=(const EnergyFlow& other);
};

// Of a state. J.
struct EnergyParts {
  double kinetic = 0.0;
  double gravitational = 0.0;  // 0 at the origin
  double stretch = 0.0, bending = 0.0;

  double elastic() const { return stretch + bending; }
  double total() const { return kinetic + gravitational + elastic(); }
};

// Of the state [3N] given.
EnergyParts StateEnergy(const Parameters& parameters, const Eigen::VectorXd& positions,
                        const Eigen::VectorXd& velocities, const Simulator& simulator);

// Of the solve that ends in `record` and started from the state [3N] given.
EnergyFlow StepEnergyFlow(const StepRecord& record, const Eigen::VectorXd& start_positions,
                          const Eigen::VectorXd& start_velocities, const Parameters& parameters, Simulator* simulator);

// Of a rollout by backward Euler that keeps all its records, as far as it came. J. Throws `std::logic_error` for one by
// another integrator, which loses energy in other ways.
struct EnergyBalance {
  EnergyFlow total;
  double start_energy = 0.0;  // E_0
  double largest_energy =
      0.0;                    // of kinetic + elastic energy + what gravitational energy has changed by since the start
  double excess = 0.0;        // the largest of E_n - E_0 - work up to n, at least 0
  double excess_time = 0.0;   // s, of that n; the start where there is none
  double gain = 0.0;          // the sum of the excesses of the steps that have one
  int unexplained_steps = 0;  // solves with |unexplained()| > tolerance

  // Relative to the largest energy; 0 where there is neither.
  double relative_excess() const { return excess > 0.0 ? excess / largest_energy : 0.0; }
};

EnergyBalance BalanceEnergy(const Rollout& rollout, Simulator* simulator);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_STEPS_ENERGY_BALANCE_H_
