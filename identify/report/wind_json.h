// The part of result.json about profiles of the wind.
#ifndef CLOTHID_IDENTIFY_REPORT_WIND_JSON_H_
#define CLOTHID_IDENTIFY_REPORT_WIND_JSON_H_

#include <nlohmann/json.hpp>

#include "identify/wind/wind_result.h"

namespace clothid {

// Of every recording "profile", as the "wind" of a scene has it, and of each fitted component its name, start and
// intervals, null where there is none; and how smooth it was believed to be.
nlohmann::ordered_json WindJson(const WindResult& result);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPORT_WIND_JSON_H_
