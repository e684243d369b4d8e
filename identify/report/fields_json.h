// The part of result.json about fields.
#ifndef CLOTHID_IDENTIFY_REPORT_FIELDS_JSON_H_
#define CLOTHID_IDENTIFY_REPORT_FIELDS_JSON_H_

#include <nlohmann/json.hpp>

#include "identify/field/field_result.h"

namespace clothid {

// Values, standard deviations of their logarithms and whether they are determined, row by row of the control grids; and
// how the fit went.
nlohmann::ordered_json FieldsJson(const FieldResult& result);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPORT_FIELDS_JSON_H_
