// Fits fields (sim/scene/material_field.h) together with parameters: up to some thousand unknowns (field_model.h), by
// Gauss-Newton with conjugate gradients (field_newton.h).
#ifndef CLOTHID_IDENTIFY_FIELD_FIELD_FIT_H_
#define CLOTHID_IDENTIFY_FIELD_FIELD_FIT_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "datasets/observation/observation.h"
#include "identify/field/field_fit_options.h"
#include "identify/field/field_request.h"
#include "identify/field/field_result.h"
#include "identify/uncertainty/uncertainty.h"

namespace clothid {

struct FieldFit {
  FieldResult result;
  Eigen::VectorXd coordinates;  // of all blocks, the levels of fields among them
  // In these coordinates, all else eliminated; absent where deviations were not estimated.
  std::optional<Linearization> marginal;
  PredictionError start_error;                   // at the starting values, as they were evaluated
  std::vector<Eigen::MatrixXd> start_predicted;  // per recording [R x T] m
};

// From the starting values of `blocks`, and the fields as the scenes of `motions` have them, which must be the same
// everywhere. Throws `Error` where `FieldModel` does.
FieldFit FitFields(const std::vector<RecordedMotion>& motions, const std::vector<ParameterBlock>& blocks,
                   const std::vector<FieldRequest>& requests, const FieldFitOptions& options);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIELD_FIELD_FIT_H_
