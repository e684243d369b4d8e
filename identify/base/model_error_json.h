// The error of the model as JSON, by kind (points, clouds, forces), those that are zero left out: times (s), variance
// and deviation (tau^2 in m^2 or N^2, and tau) at each of them, and alike (n). Variances are read, deviations are for
// people; numbers read back exactly.
#ifndef CLOTHID_IDENTIFY_BASE_MODEL_ERROR_JSON_H_
#define CLOTHID_IDENTIFY_BASE_MODEL_ERROR_JSON_H_

#include <nlohmann/json.hpp>

#include "datasets/observation/model_error.h"
#include "sim/base/json_document.h"

namespace clothid {

nlohmann::ordered_json ModelErrorJson(const ModelError& error);

// Throws `Error` (kBadData), naming the key, for anything else: other kinds, times that do not increase, variances
// below 0 or of another number than times, n below 1.
ModelError ReadModelError(const JsonNode& node);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_BASE_MODEL_ERROR_JSON_H_
