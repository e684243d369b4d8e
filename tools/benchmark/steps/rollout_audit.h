// Whether a rollout is what it claims to be, found out again from its records alone.
//
// Every solve: its step equation is evaluated at the recorded velocity, from the recorded state before it, without
// anything that the solver has left behind. A rollout that is ok() and has a violation is a silent failure.
#ifndef CLOTHID_TOOLS_BENCHMARK_STEPS_ROLLOUT_AUDIT_H_
#define CLOTHID_TOOLS_BENCHMARK_STEPS_ROLLOUT_AUDIT_H_

#include "sim/rollout/rollout.h"
#include "sim/rollout/self_contact_audit.h"

namespace clothid {

class Simulator;

struct RolloutAudit {
  // Solves that violate ...
  int not_finite = 0;  // ... that positions and velocities are finite; not looked at further
  // ... x_1 = x_0 + h v_1 at the free nodes, up to rounding, or the recorded branches; or with pairs of the cloth with
  // itself that the step had not, or with friction where thinning had left them out
  int inconsistent = 0;
  int unsolved = 0;  // ... the tolerance of the step
  // ... the contact law: a node of the contact set is deeper in its obstacle than phi(x_0) - h gap_speed by more than
  // the tolerance of the step lets it, h |residual|/d. (Obstacles are convex, so what holds for the plane that a
  // step replaces them by holds for them; of one that moves, the plane itself is looked at, as of pairs.)
  int too_deep = 0;
  int missing_steps = 0;           // that an ok() rollout has not, or that its solves do not add up to
  double worst_residual = 0.0;     // of all solves, relative to the tolerance
  double loosest_tolerance = 0.0;  // that a solve was allowed: the scene's, or more where rounding is larger
  double penetration = 0.0;        // -phi, the deepest of any free node at the end of any solve, at least 0, m
  SelfContactAudit self_contact;   // after every step; no violation of what a step claims

  int violations() const { return not_finite + inconsistent + unsolved + too_deep + missing_steps; }
};

// `rollout` keeps all its records, comes from the scene of `simulator`, and was to have `num_steps` steps.
RolloutAudit AuditRollout(const Rollout& rollout, int num_steps, Simulator* simulator);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_STEPS_ROLLOUT_AUDIT_H_
