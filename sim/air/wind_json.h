// The "wind" and "air" of scene.json.
#ifndef CLOTHID_SIM_AIR_WIND_JSON_H_
#define CLOTHID_SIM_AIR_WIND_JSON_H_

#include "sim/air/wind.h"
#include "sim/base/json_document.h"

namespace clothid {

// What the objects leave out stays as it is. Throw `Error` (kBadData) naming key and line.
void ReadWind(const JsonNode& node, Wind* wind);
void ReadAirLaw(const JsonNode& node, AirLaw* law);

}  // namespace clothid

#endif  // CLOTHID_SIM_AIR_WIND_JSON_H_
