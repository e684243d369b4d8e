// The force with which the contacts of a cloth with itself push its handles (sim/contact/self_contact.h).
#ifndef CLOTHID_SIM_ROLLOUT_PAIR_FORCES_H_
#define CLOTHID_SIM_ROLLOUT_PAIR_FORCES_H_

#include <Eigen/Core>

#include "sim/cloth/cloth_model.h"
#include "sim/rollout/step_record.h"
#include "sim/scene/parameters.h"

namespace clothid {

// At every handle, in the order of the scene's, sum of w_i r/h over its pairs at the end of the solve of size h that
// `record` ends [3H] N; after a step, that of its last solve.
Eigen::VectorXd PairForces(const ClothModel& model, const Parameters& parameters, const StepRecord& record);

}  // namespace clothid

#endif  // CLOTHID_SIM_ROLLOUT_PAIR_FORCES_H_
