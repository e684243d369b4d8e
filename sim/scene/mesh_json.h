// The `mesh` of scene.json.
#ifndef CLOTHID_SIM_SCENE_MESH_JSON_H_
#define CLOTHID_SIM_SCENE_MESH_JSON_H_

#include <string>

#include "sim/base/json_document.h"
#include "sim/scene/mesh.h"

namespace clothid {

// What the value may be, for messages.
inline constexpr char kMeshForms[] = "{\"grid\": {..}} or {\"obj\": \"FILE\"}";

// Reads the object `node`. A relative name of a file in it starts at `folder`. `recorded` (may be null): the mesh that
// a recording brings itself. It is what is then returned; a grid in the text has to be of its size, and a file is not
// opened. Throws `Error` naming key and line (kBadData) or a file that cannot be read (kIo).
Mesh ReadMesh(const JsonNode& node, const std::string& folder, const Mesh* recorded);

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_MESH_JSON_H_
