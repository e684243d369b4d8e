// What the solves of steps took and what happened at their contacts.
#ifndef CLOTHID_SIM_STEP_STEP_COUNTS_H_
#define CLOTHID_SIM_STEP_STEP_COUNTS_H_

#include "sim/contact/contact_set.h"

namespace clothid {

// Counts over a rollout, for reports. Those of several rollouts add up.
struct RolloutCounts {
  int steps = 0;
  int newton_iterations = 0;
  int factorizations = 0;
  int linear_iterations = 0;  // of the linear solves of steps, with friction or with the factor of an earlier point
  int fallbacks = 0;          // solves handed to continuation in the friction
  int substeps = 0;           // solves beyond one per step: each makes the cost jump a little
  int failed_steps = 0;
  int contacts = 0;  // nodes in contact at the end of a solve
  // Contact events, from the end of one solve to the end of the next. Those that the first solve finds in contact have
  // not joined.
  int nodes_joined = 0;       // the contacts
  int nodes_left = 0;         // them
  int branch_switches = 0;    // from stick to slip or back
  int obstacle_switches = 0;  // contacts that jumped from one obstacle to another
  // Pairs of the cloth with itself in contact at the end of a solve, and how many have come, gone or switched branches:
  // where a node slides from one triangle to the next, one goes and one comes.
  int self_contacts = 0;
  int pair_changes = 0;
  int second_solves = 0;  // with pairs that were left out at first: derivatives there are not certain

  int contact_changes() const { return nodes_joined + nodes_left + branch_switches + pair_changes; }

  RolloutCounts& operator+=(const RolloutCounts& other);
  RolloutCounts& operator-=(const RolloutCounts& other);
};

// Adds the contacts `after` a solve, and their changes since the one before it, to `counts`.
void CountContactChanges(const ContactRecords& before, const ContactRecords& after, RolloutCounts* counts);

}  // namespace clothid

#endif  // CLOTHID_SIM_STEP_STEP_COUNTS_H_
