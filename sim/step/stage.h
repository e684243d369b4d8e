// The solves of which a time step is made: one of backward Euler, two of SDIRK2.
//
// SDIRK2 is the two-stage, L-stable, diagonally implicit Runge-Kutta method of second order (Alexander 1977). With
//   gamma = 1 - 1/sqrt(2),   eta = gamma h,   kappa = (1 - gamma)/gamma = 1 + sqrt(2)
// both of its solves are backward Euler steps of size eta:
//   first stage   from (x_n, v_n) to t_n + eta:    v_1,   x_1 = x_n + eta v_1
//   second stage  from (x_s, v_s) to t_n + h:      v_2,   x_2 = x_s + eta v_2, the end of the step
// where x_s = x_n + kappa (x_1 - x_n), and v_s is v_n + kappa (v_1 - v_n) but for impacts (second_start.h).
//
// **The gap's time.** Gap mode asks phi/T + u_N >= 0, that a node reaches an obstacle within T at the earliest. T is
// the size of the solve, but h in the first stage: a node that would use up its gap within eta would start the second
// stage inside the obstacle, kappa times as deep as its gap was.
#ifndef CLOTHID_SIM_STEP_STAGE_H_
#define CLOTHID_SIM_STEP_STAGE_H_

#include <Eigen/Core>

#include "sim/scene/scene.h"

namespace clothid {

inline constexpr double kStageShare = 0.29289321881345254;       // gamma
inline constexpr double kSecondStageReach = 2.4142135623730950;  // kappa

enum class Stage : char {
  kOnly,    // the one solve of a step of backward Euler
  kFirst,   // of SDIRK2
  kSecond,  // of SDIRK2
};

// Solves of a step that is not cut.
inline int NumStages(Integrator integrator) { return integrator == Integrator::kSdirk2 ? 2 : 1; }

// When a solve takes place.
struct SolveTimes {
  double time_step;  // of the solve: h, or eta, s
  double end_time;   // s
  Stage stage = Stage::kOnly;

  double gap_time() const { return stage == Stage::kFirst ? time_step / kStageShare : time_step; }  // T, s
};

// What a solve starts from.
struct SolveStart {
  const Eigen::VectorXd& positions;   // x_n, or x_s in a second stage [3N] m
  const Eigen::VectorXd& velocities;  // v_n, or v_s [3N] m/s
  // In a second stage x_n and x_1 [3N], which give the metrics that its strain rate is taken from (second_start.h);
  // else null.
  const Eigen::VectorXd* step_positions = nullptr;
  const Eigen::VectorXd* first_positions = nullptr;
};

struct SecondStart {
  Eigen::VectorXd positions;   // x_s [3N] m
  Eigen::VectorXd velocities;  // v_s [3N] m/s
};

}  // namespace clothid

#endif  // CLOTHID_SIM_STEP_STAGE_H_
