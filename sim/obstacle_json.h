// The `obstacles` of scene.json.
#ifndef CLOTHID_SIM_OBSTACLE_JSON_H_
#define CLOTHID_SIM_OBSTACLE_JSON_H_

#include <vector>

#include "sim/json_document.h"
#include "sim/scene.h"

namespace clothid {

// Reads the array `list`. Obstacles without a name get that of their type, made unique: "sphere", "sphere2", ... Throws
// `Error` (kBadData) naming key and line.
std::vector<SceneObstacle> ReadObstacles(const JsonNode& list);

}  // namespace clothid

#endif  // CLOTHID_SIM_OBSTACLE_JSON_H_
