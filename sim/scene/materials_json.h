// The `materials` and `fields` of scene.json: constants of the cloth, and those of them that vary over it.
#ifndef CLOTHID_SIM_SCENE_MATERIALS_JSON_H_
#define CLOTHID_SIM_SCENE_MATERIALS_JSON_H_

#include <vector>

#include "sim/base/json_document.h"
#include "sim/scene/material_field.h"
#include "sim/scene/scene.h"

namespace clothid {

// Reads the object `node` into the constants of the cloth and its laws. What it leaves out stays as `scene` has it.
// Throws `Error` (kBadData) naming key and line.
void ReadMaterials(const JsonNode& node, Scene* scene);

// {"k_stretch": [[..], ..], ..}: the rows of control grids. Throws `Error` (kBadData) naming the key.
std::vector<GridField> ReadFields(const JsonNode& node);

// Gives the material of a scene that `ValidateScene` accepts the levels of its fields.
void SetLevels(Scene* scene);

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_MATERIALS_JSON_H_
