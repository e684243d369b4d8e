// Where the second stage of an SDIRK2 step starts, from the end (x_1, v_1) of its first (stage.h has gamma and kappa):
//
//   x_s = x_n + kappa (x_1 - x_n)              = x_n + (1 - gamma) h v_1 at free nodes
//   v_s = v_n + kappa (v_1 - v_n - u)
//   C_s = C(x_n) + kappa (C(x_1) - C(x_n))     per triangle, what the second strain rate (C(x) - C_s)/(2 eta) is from
// With u = 0 these are the Runge-Kutta formulas, C carried along as a quantity of its own, whose rate a rigid motion
// leaves at zero; their error per step is of third order in h.
//
// u is the change of velocity that has stopped an impact in the first stage (sim/contact/impact_share.h). An impact
// takes no time, so it must not be carried on as if it were a force: kappa times what stops a node would throw it back.
// The second stage stops it again. All other contact forces are carried on, as those of a node that slides have to be.
#ifndef CLOTHID_SIM_STEP_SECOND_START_H_
#define CLOTHID_SIM_STEP_SECOND_START_H_

#include <Eigen/Core>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/contact/contact_set.h"
#include "sim/scene/parameters.h"
#include "sim/step/stage.h"

namespace clothid {

// After a first stage of size `time_step` eta from `start` to x_1 and v_1 [3N], in which `contacts` stuck or slipped.
SecondStart StartSecondStage(const ClothModel& model, const Material& material, const SolveStart& start,
                             const Eigen::VectorXd& first_positions, const Eigen::VectorXd& first_velocities,
                             double time_step, const ContactSet& contacts);

// What the forces of a solve of size `time_step` need of its start: the positions x_n, or x_n and x_1 of a second
// stage, from which C is taken, and x^ = x_n + h v_n (x_s and v_s of a second stage), `handles` where they are in
// `end_positions` [3N].
void SetForceStart(const ForceSet& forces, const SolveStart& start, double time_step, const std::vector<int>& handles,
                   const Eigen::VectorXd& end_positions, ForceStart* force_start);

}  // namespace clothid

#endif  // CLOTHID_SIM_STEP_SECOND_START_H_
