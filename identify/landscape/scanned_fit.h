// The fit whose cost a scan is of (`landscape --result`).
#ifndef CLOTHID_IDENTIFY_LANDSCAPE_SCANNED_FIT_H_
#define CLOTHID_IDENTIFY_LANDSCAPE_SCANNED_FIT_H_

#include <nlohmann/json.hpp>
#include <string>

#include "datasets/motion/recorded_motion.h"
#include "datasets/observation/model_error.h"
#include "identify/base/fitted_result.h"
#include "identify/landscape/landscape.h"
#include "sim/base/json_document.h"

namespace clothid {

// The part of `motion` in a fit. Throws `Error` (kUsage), naming --result, where it is none of its recordings, or was
// read with another sigma or start.
ScannedFit ScannedFitOf(const FittedResult& result, const RecordedMotion& motion);

// Whether both weigh frames alike, but for rounding.
bool IsSameWeight(const ModelError& a, const ModelError& b);

// Of plan.json: held by name, model_error (identify/base/model_error_json.h) and, of rollouts that the recording
// corrects, assimilation. Numbers read back exactly.
nlohmann::ordered_json ScannedFitJson(const ScannedFit& fit);

// Throws `Error` (kBadData), naming the key, for anything else.
ScannedFit ReadScannedFit(const JsonNode& node);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_LANDSCAPE_SCANNED_FIT_H_
