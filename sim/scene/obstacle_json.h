// The `obstacles` of scene.json.
#ifndef CLOTHID_SIM_SCENE_OBSTACLE_JSON_H_
#define CLOTHID_SIM_SCENE_OBSTACLE_JSON_H_

#include <string>
#include <vector>

#include "sim/base/json_document.h"
#include "sim/scene/scene.h"

namespace clothid {

// Reads the array `list`. Relative names of files in it start at `folder`. Obstacles without a name get that of their
// type, made unique: "sphere", "sphere2", ... Throws `Error` naming key and line (kBadData) or a file that cannot be
// read (kIo).
std::vector<SceneObstacle> ReadObstacles(const JsonNode& list, const std::string& folder);

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_OBSTACLE_JSON_H_
