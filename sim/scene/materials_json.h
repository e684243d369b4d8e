// The `fabric`, `materials` and `fields` of scene.json: constants of the cloth, and those of them that vary over it;
// and what is believed of them.
#ifndef CLOTHID_SIM_SCENE_MATERIALS_JSON_H_
#define CLOTHID_SIM_SCENE_MATERIALS_JSON_H_

#include <string>
#include <vector>

#include "sim/base/json_document.h"
#include "sim/scene/material_field.h"
#include "sim/scene/scene.h"

namespace clothid {

// The `warp_direction` of a cloth whose warp follows the UV map of its mesh.
inline constexpr char kWarpByUv[] = "uv";

// Whether `materials` has it.
bool WarpFollowsUv(const JsonNode& materials);

// Reads the object `node` into the constants of the cloth and its laws. What it leaves out stays as `scene` has it: of
// a warp that follows a UV map, the directions that came with the mesh. A relative name of a file starts at `folder`.
// Throws `Error` naming key and line (kBadData) or a file that cannot be read (kIo).
void ReadMaterials(const JsonNode& node, const std::string& folder, Scene* scene);

// The name of a fabric (sim/fabric/fabric.h), and its constants for those that are read later. Before `ReadMaterials`,
// once the law of bending that goes without saying is known. Throws as above.
void ReadFabric(const JsonNode& node, Scene* scene);

// {"median": .., "factor": ..} of a parameter whose logarithm is believed, else {"mean": .., "std": ..}. Throws as
// above.
ParameterPrior ReadPrior(const JsonNode& node, ParameterKind kind);

// {"k_stretch": [[..], ..], ..}: the rows of control grids. Throws `Error` (kBadData) naming the key.
std::vector<GridField> ReadFields(const JsonNode& node);

// Gives the material of a scene that `ValidateScene` accepts the levels of its fields.
void SetLevels(Scene* scene);

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_MATERIALS_JSON_H_
