// A fit with fields, as `identify --field` runs it: the parameters with the levels of flat fields; from there fields
// and parameters together (field_fit.h); then the parameters as any fit goes on, on the cloth that the fields make,
// with intervals that count with what is not known of the fields.
#ifndef CLOTHID_IDENTIFY_FIELD_FIELD_STAGE_H_
#define CLOTHID_IDENTIFY_FIELD_FIELD_STAGE_H_

#include <memory>
#include <optional>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "identify/base/options.h"
#include "identify/field/field_request.h"
#include "identify/field/field_result.h"
#include "identify/fit/fit_summary.h"
#include "identify/fit/problem.h"

namespace clothid {

// `problem` is that of `motions` and `options`. Both become those of the cloth with the fitted fields. Flat fields
// start at the starting value of their parameter, nominal where that is not fitted. Where the fields cannot be
// fitted the summary says why and has no estimate. Throws `Error` where `FitFields` does, and (kUsage) for a field of a
// constant that the scene does not have.
FitSummary FitWithFields(const FitOptions& options, const std::vector<FieldRequest>& requests, double weight,
                         std::vector<RecordedMotion>* motions, std::unique_ptr<FitProblem>* problem,
                         FieldResult* result);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIELD_FIELD_STAGE_H_
