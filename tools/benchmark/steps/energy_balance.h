// Where the energy of a rollout comes from and where it goes.
//
// Energy E_n = kinetic and gravitational energy of the free nodes + stretch and bending energy of the whole cloth. A
// step has one solve (backward Euler) or two (SDIRK2, sim/step/stage.h). Solve s, of size h_s, ends with the velocities
// v_s, and counts with the weight w_s = h_s, but kappa h_s in a first stage, so that x_{n+1} - x_n = sum of w_s v_s.
// Its impulses J^T r_s count likewise as R_s = r_s, but kappa (r_s - M u) in a first stage: that part of them which is
// carried on (sim/step/second_start.h). With U stretch and bending, f = -dU/dx and f_d internal damping at the end of
// the solve, e its residual, sums over the solves of the step, it is exactly
//   E_{n+1} - E_n = W_force + W_air + W_handles + W_contact - D_inertia - D_damping - D_elastic + sum e . v_s
//   W_force   = sum over free nodes of w_s node_force . v_s
//   W_air     = sum over free nodes of w_s c_d a (w - v_s) . v_s
//   W_handles = -w_s (f + f_d) . v_s over the handles: what holds a handle acts against the cloth
//   W_contact = sum over contacts of R_s . v_s: not positive but for W_push, that part of normal impulses which does
//               positive work, where a node starts inside an obstacle
//   D_inertia, D_damping, D_elastic: what the integrator takes (sim/rollout/energy_loss.h)
// So a step can gain energy that no work pays for, by D_elastic < -(D_inertia + D_damping): a property of its
// integrator, not an error. It is summed as the excess. Whatever is left over is e . v_s, for which |e| <= tolerance *
// scale bounds it: more would be an error of a force, of an energy or of the solver.
//
// **What contacts gain.** At a node with impulses, R_s . v_s without W_push, less its part of D_inertia, is what
// contact brings it beyond the work of all other forces. An impact that threw a node back would be a gain.
#ifndef CLOTHID_TOOLS_BENCHMARK_STEPS_ENERGY_BALANCE_H_
#define CLOTHID_TOOLS_BENCHMARK_STEPS_ENERGY_BALANCE_H_

#include <Eigen/Core>

#include "sim/rollout/energy_loss.h"
#include "sim/rollout/rollout.h"

namespace clothid {

class RecordReader;
class Simulator;

// The balance of one step, or of several: they add up. J.
struct EnergyFlow {
  double change = 0.0;  // E_1 - E_0
  double force_work = 0.0, air_work = 0.0, handle_work = 0.0, contact_work = 0.0;
  double push_work = 0.0;     // part of contact_work
  double contact_gain = 0.0;  // what contacts gain, over the nodes where it is positive
  EnergyLoss loss;
  double tolerance = 0.0;  // of unexplained(): that of the solver, |v_1| times the residual, and of rounding

  double work() const { return force_work + air_work + handle_work + contact_work; }
  // E_1 - E_0 beyond the work: positive where energy was gained without a source.
  double excess() const { return change - work(); }
  // e . v_1 and rounding.
  double unexplained() const { return excess() + loss.total(); }

  EnergyFlow& operator+=(const EnergyFlow& other);
};

// Of the step or substep that ends in record `last` of `rollout`, which `reader` reads.
EnergyFlow StepEnergyFlow(const Rollout& rollout, int last, RecordReader* reader, Simulator* simulator);

// Of a rollout that keeps all its records, as far as it came. J.
struct EnergyBalance {
  EnergyFlow total;
  double start_energy = 0.0;  // E_0
  double largest_energy =
      0.0;                    // of kinetic + elastic energy + what gravitational energy has changed by since the start
  double excess = 0.0;        // the largest of E_n - E_0 - work up to n, at least 0
  double excess_time = 0.0;   // s, of that n; the start where there is none
  double gain = 0.0;          // the sum of the excesses of the steps that have one
  double contact_gain = 0.0;  // the largest of a step
  int unexplained_steps = 0;  // steps and substeps with |unexplained()| > tolerance

  // Relative to the largest energy; 0 where there is neither.
  double relative_contact_gain() const { return contact_gain > 0.0 ? contact_gain / largest_energy : 0.0; }
  double relative_excess() const { return excess > 0.0 ? excess / largest_energy : 0.0; }
};

EnergyBalance BalanceEnergy(const Rollout& rollout, Simulator* simulator);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_STEPS_ENERGY_BALANCE_H_
