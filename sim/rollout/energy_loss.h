// What an integrator takes of the energy of a cloth, or gives it.
//
// A step has one solve (backward Euler) or two (SDIRK2, sim/step/stage.h). Solve s, of size h_s, ends with the
// velocities v_s, and counts with the weight w_s = h_s, but kappa h_s in a first stage, so that x_{n+1} - x_n = sum of
// w_s v_s. With U stretch, bending and seam energy, f = -dU/dx and f_d internal damping at the end of the solve, sums
// over the solves of the step, kinetic, gravitational and elastic energy together change by the work of all forces from
// outside (gravity apart; what draws seams does the work sum of w_s dU/dt, at the ends of the solves) less
//   D_inertia = 1/2 b . M b + c . M (kappa u - c/2), b the change of velocity over the last solve, c + u that over the
//               first stage, u what stopped an impact there (sim/step/second_start.h), c = 0 without a first stage:
//               backward Euler takes it from every change of velocity; with stages it is of third order in h, of either
//               sign, where nothing hits an obstacle (b . M b - c . M c)/2
//   D_damping = -w_s f_d . v_s over all nodes, what internal damping takes
//   D_elastic = U_n - U_{n+1} - sum w_s (f . v_s - dU/dt) over all nodes: of backward Euler >= 0 where U is convex
//               from x_n to x_{n+1}, which it is not where cloth is compressed; of SDIRK2 an error of third order
// A step whose sum of these is negative gains energy that no work pays for: a property of its integrator, not an error
// of its solver.
#ifndef CLOTHID_SIM_ROLLOUT_ENERGY_LOSS_H_
#define CLOTHID_SIM_ROLLOUT_ENERGY_LOSS_H_

#include <Eigen/Core>

#include "sim/rollout/record_reader.h"
#include "sim/rollout/rollout.h"
#include "sim/scene/scene.h"

namespace clothid {

class Simulator;

// Of a state. J.
struct EnergyParts {
  double kinetic = 0.0;
  double gravitational = 0.0;  // 0 at the origin
  double stretch = 0.0, bending = 0.0, seams = 0.0;

  double elastic() const { return stretch + bending + seams; }
  double total() const { return kinetic + gravitational + elastic(); }
};

// Of the state [3N] given, with seams as they are drawn at `time`, s on the scene's clock.
EnergyParts StateEnergy(const Parameters& parameters, const Eigen::VectorXd& positions,
                        const Eigen::VectorXd& velocities, const Simulator& simulator, double time);

// The first record of the step or substep that ends in record `last`.
int FirstOfStep(const Rollout& rollout, int last);

// What a solve is taken for in its step: kappa times for a first stage.
double SolveWeight(const StepRecord& record);

// Forces in the cloth at the end of a solve [3N], N.
struct InternalForces {
  Eigen::VectorXd elastic, viscous;
};
InternalForces ForcesAtEnd(const Parameters& parameters, const StepRecord& record, const SolveStart& start,
                           const Simulator& simulator);

// Of the step or substep that ends in a record [3N], m/s: b, c and u.
struct VelocityChanges {
  Eigen::VectorXd last, first, impact;
};
VelocityChanges ChangesInStep(const Rollout& rollout, int last, RecordReader* reader);

// D_inertia at each node [N], J.
Eigen::VectorXd NodeInertiaLoss(const Parameters& parameters, const VelocityChanges& changes,
                                const Simulator& simulator);

// What draws the seams in the step or substep that ends in record `last`, J.
double SeamWork(const Rollout& rollout, int last, RecordReader* reader, const Simulator& simulator);
// Likewise jaws that turn, as far as they change the elastic energy at fixed positions, J.
double ClampWork(const Rollout& rollout, int last, RecordReader* reader, const Simulator& simulator);

// What a step loses, J.
struct EnergyLoss {
  double inertia = 0.0, damping = 0.0, elastic = 0.0;

  double total() const { return inertia + damping + elastic; }
};

// Of the step or substep that ends in record `last` of `rollout`, which `reader` reads.
EnergyLoss StepEnergyLoss(const Rollout& rollout, int last, RecordReader* reader, const Simulator& simulator);

}  // namespace clothid

#endif  // CLOTHID_SIM_ROLLOUT_ENERGY_LOSS_H_
