// The shape of an obstacle of scene.json: the keys that belong to its `type`.
#ifndef CLOTHID_SIM_SCENE_SHAPE_JSON_H_
#define CLOTHID_SIM_SCENE_SHAPE_JSON_H_

#include <memory>
#include <string>

#include "sim/base/json_document.h"
#include "sim/obstacle/obstacle.h"

namespace clothid {

// Reads the shape of the obstacle `node`. Refuses every key that is neither of its type nor one that all obstacles
// have. Relative names of files in it start at `folder`. Throws `Error` naming key and line (kBadData) or a file that
// cannot be read (kIo).
std::shared_ptr<const Obstacle> ReadShape(const JsonNode& node, const std::string& folder);

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_SHAPE_JSON_H_
