// Gauss-Newton with conjugate gradients for fields.
//
// A step d solves H d = -gradient, H = J^T J + lambda P (field_model.h). At first over the 4 x 4 smoothest modes of the
// fields (field_prior.h) and the parameters, then over 8 x 8, directly: J^T J over them is one forward sweep with a
// column each, formed anew once the fields have moved by 5 %. After that over all, by conjugate gradients: a product
// with H is a forward sweep with one column and a reverse sweep, along the rollout that is at hand with its factors.
// They are preconditioned by H over the 8 x 8 modes and by the prior across (field_preconditioner.h), which makes the
// number of products that of what the recordings tell beyond these modes, not that of the unknowns. A step that leaves
// the trust region ends at its border (Steihaug 1983).
//
// Before every step the weight lambda is chosen anew (field_posterior.h), unless it is given. A step that does not
// lower the cost, as across a kink of a contact, is tried shorter along its line. Far from the solution rollouts are
// loose.
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
