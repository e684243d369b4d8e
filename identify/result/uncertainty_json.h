// "uncertainty" of result.json.
#ifndef CLOTHID_IDENTIFY_RESULT_UNCERTAINTY_JSON_H_
#define CLOTHID_IDENTIFY_RESULT_UNCERTAINTY_JSON_H_

#include <nlohmann/json.hpp>

#include "identify/estimate/fit_summary.h"

namespace clothid {

// Correlations, hidden directions and how the intervals were checked; null where there are no intervals.
nlohmann::ordered_json UncertaintyJson(const FitSummary& summary);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_RESULT_UNCERTAINTY_JSON_H_
