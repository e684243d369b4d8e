// The `materials` of scene.json.
#ifndef CLOTHID_SIM_SCENE_MATERIALS_JSON_H_
#define CLOTHID_SIM_SCENE_MATERIALS_JSON_H_

#include "sim/base/json_document.h"
#include "sim/scene/scene.h"

namespace clothid {

// Reads the object `node` into the constants of the cloth and its laws. What it leaves out stays as `scene` has it.
// Throws `Error` (kBadData) naming key and line.
void ReadMaterials(const JsonNode& node, Scene* scene);

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_MATERIALS_JSON_H_
