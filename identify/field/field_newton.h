// Gauss-Newton with conjugate gradients for fields.
//
// A step d solves H d = -gradient, H = J^T J + lambda P (field_model.h), by conjugate gradients: a product with H is a
// forward sweep with one column and a reverse sweep, along the rollout that is at hand with its factors. Within a trust
// region (Steihaug 1983), preconditioned over a coarse basis and by the prior (field_preconditioner.h), which makes the
// number of products that of what the recordings tell beyond that basis, not that of the unknowns. Before every step
// the weight lambda is chosen anew (field_posterior.h), unless it is given. A step that does not lower the cost, as
// across a kink of a contact, is tried shorter along its line. Far from the solution rollouts are loose.
#ifndef CLOTHID_IDENTIFY_FIELD_FIELD_NEWTON_H_
#define CLOTHID_IDENTIFY_FIELD_FIELD_NEWTON_H_

#include "identify/field/field_fit_options.h"
#include "identify/field/field_model.h"
#include "identify/field/field_result.h"

namespace clothid {

// From `point` to the best one. Fills how it ended, iterations and weight of `result`. False where it cannot go on:
// then the message says why.
bool RunFieldNewton(const FieldFitOptions& options, FieldModel* model, FieldPoint* point, FieldResult* result);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIELD_FIELD_NEWTON_H_
