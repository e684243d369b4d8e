// Fields in report.html: a picture of each on the cloth at rest, and where the recordings do not determine it.
#ifndef CLOTHID_IDENTIFY_REPORT_REPORT_FIELDS_H_
#define CLOTHID_IDENTIFY_REPORT_REPORT_FIELDS_H_

#include <nlohmann/json.hpp>

#include "identify/estimate/fitted_field.h"
#include "sim/mesh/mesh.h"

namespace clothid {

// A list, one per field: what report_field.js draws. Of square cells over the cloth, seen along its mean normal
// (sim/scene/material_field.h): "x" and "y" of their centres in m, and per row of cells, null off the cloth, "value" in
// the parameter's unit, "std" of its logarithm and "determined", 1 or 0, by the rule of `IsDetermined` between control
// nodes; the last two are absent where they were not estimated. "outline": the border of the cloth as lines.
nlohmann::ordered_json FieldMapsJson(const FieldResult& result, const Mesh& mesh);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPORT_REPORT_FIELDS_H_
