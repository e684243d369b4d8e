// What obstacles and their friction do to the energy of a cloth.
//
// A solve of weight w (energy_loss.h) gives its contacts the impulses r at the velocities v of the nodes and V of the
// obstacles' material points; in a first stage r is without m u, which stopped an impact there and is not carried on
// (sim/step/second_start.h):
//   work      w sum of r . V          what the motion of the obstacles brings in; 0 where they stand still
//   friction  -w sum of r . (v - V)   what friction takes, and what is lost where a gap is used up
// so that kinetic, gravitational and elastic energy of a cloth without handles and air change over a step by
// work - friction - `StepEnergyLoss`.
#ifndef CLOTHID_SIM_ROLLOUT_CONTACT_WORK_H_
#define CLOTHID_SIM_ROLLOUT_CONTACT_WORK_H_

#include "sim/rollout/record_reader.h"
#include "sim/rollout/rollout.h"

namespace clothid {

class Simulator;

struct ContactWork {
  double work = 0.0, friction = 0.0;  // J
};

// Of the step or substep that ends in record `last` of `rollout`, which `reader` reads.
ContactWork StepContactWork(const Rollout& rollout, int last, RecordReader* reader, const Simulator& simulator);

}  // namespace clothid

#endif  // CLOTHID_SIM_ROLLOUT_CONTACT_WORK_H_
