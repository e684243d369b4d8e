// The parts of result.json about what varies: fields over the cloth, the wind over time.
#ifndef CLOTHID_IDENTIFY_RESULT_VARYING_JSON_H_
#define CLOTHID_IDENTIFY_RESULT_VARYING_JSON_H_

#include <nlohmann/json.hpp>

#include "identify/estimate/fitted_field.h"
#include "identify/wind/wind_result.h"

namespace clothid {

// Values, standard deviations of their logarithms and whether they are determined, row by row of the control grids; and
// how the fit went.
nlohmann::ordered_json FieldsJson(const FieldResult& result);

// Of every recording "profile", as the "wind" of a scene has it, and of each fitted component its name, start and
// intervals, null where there is none; and how smooth it was believed to be.
nlohmann::ordered_json WindJson(const WindResult& result);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_RESULT_VARYING_JSON_H_
