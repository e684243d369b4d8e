// How a fit counts with the errors of the model, as JSON.
//
// The error of the model, by kind (points, clouds, forces), those that are zero left out: times (s), variance
// and deviation (tau^2 in m^2 or N^2, and tau) at each of them, and alike (n). Variances are read, deviations are for
// people; numbers read back exactly.
#ifndef CLOTHID_IDENTIFY_BASE_MODEL_ERROR_JSON_H_
#define CLOTHID_IDENTIFY_BASE_MODEL_ERROR_JSON_H_

#include <nlohmann/json.hpp>

#include "costs/assimilation/assimilation.h"
#include "datasets/observation/model_error.h"
#include "sim/base/json_document.h"

namespace clothid {

nlohmann::ordered_json ModelErrorJson(const ModelError& error);

// Throws `Error` (kBadData), naming the key, for anything else: other kinds, times that do not increase, variances
// below 0 or of another number than times, n below 1.
ModelError ReadModelError(const JsonNode& node);

// How recordings correct rollouts: memory_s, null where nothing is corrected, and smoothing_m, null where it is an edge
// of the mesh. An object that is read may have other keys, too.
nlohmann::ordered_json AssimilationJson(const Assimilation& assimilation);
// Throws `Error` (kBadData), naming the key, for anything else.
Assimilation ReadAssimilation(const JsonNode& node);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_BASE_MODEL_ERROR_JSON_H_
