// What contacts and their friction do to the energy of a cloth.
//
// A solve of weight w (energy_loss.h) gives its contacts the impulses r at the velocities v of the nodes and V of the
// obstacles' material points; in a first stage r is without what stopped an impact there and is not carried on
// (sim/step/second_start.h): m u at an obstacle, L r of a pair of the cloth with itself (sim/contact/impact_share.h).
// Of a pair, u = sum w_i v_i is the relative velocity, of handles among its nodes V = sum w_i v_i. Sums over all
// contacts:
//   work      w sum of r . V over obstacles, -w sum of r . V over pairs
//                                     what the motion of obstacles and handles brings in; 0 where they stand still
//   friction  -w sum of r . (v - V) over obstacles, -w sum of r . u over pairs
//                                     what friction takes, and what is lost where a gap is used up
//   push      that part of -friction which normal impulses of pairs bring in, where they part what was too near
// so that kinetic, gravitational and elastic energy of a cloth without air and with handles that touch nothing but
// pairs change over a step by work - friction - `StepEnergyLoss`, and by what else moves the handles.
#ifndef CLOTHID_SIM_ROLLOUT_CONTACT_WORK_H_
#define CLOTHID_SIM_ROLLOUT_CONTACT_WORK_H_

#include "sim/rollout/record_reader.h"
#include "sim/rollout/rollout.h"

namespace clothid {

class Simulator;

struct ContactWork {
  double work = 0.0, friction = 0.0, push = 0.0;  // J

  ContactWork& operator+=(const ContactWork& other);
};

// Of the step or substep that ends in record `last` of `rollout`, which `reader` reads.
ContactWork StepContactWork(const Rollout& rollout, int last, RecordReader* reader, const Simulator& simulator);

}  // namespace clothid

#endif  // CLOTHID_SIM_ROLLOUT_CONTACT_WORK_H_
