// The `mesh` of scene.json.
#ifndef CLOTHID_SIM_MESH_MESH_JSON_H_
#define CLOTHID_SIM_MESH_MESH_JSON_H_

#include <Eigen/Core>
#include <string>

#include "sim/base/json_document.h"
#include "sim/mesh/mesh.h"
#include "sim/mesh/obj_file.h"

namespace clothid {

// What the value may be, for messages.
inline constexpr char kMeshForms[] = "{\"grid\": {..}} or {\"obj\": \"FILE\"}";

// Reads the object `node`. A relative name of a file in it starts at `folder`. `recorded` (may be null): the mesh that
// a recording brings itself. It is what is then returned; a grid in the text has to be of its size, and a file is not
// opened. Throws `Error` naming key and line (kBadData) or a file that cannot be read (kIo).
//
// Seams and buttons sew it (sewing.h); that of a recording is sewn already. With `"rest": "uv"` its rest shape is the
// UV map of the file, and `along_u` stays as it is: the warp is along u anyway.
//
// `along_u` (may be null): where the warp is to follow the UV map of a file, the direction of u in every triangle
// [3 x F] (sim/mesh/obj_file.h); stays as it is with a grid. `groups` (may be null): likewise, its groups of triangles.
// With either, the file has to have the triangles of `recorded`.
Mesh ReadMesh(const JsonNode& node, const std::string& folder, const Mesh* recorded, Eigen::Matrix3Xd* along_u,
              FaceGroups* groups);

// A vector [3] per node or triangle, `count` of them: the .npy file of shape (count, 3) that `node` names, starting at
// `folder`. Throws `Error` naming key and file unless it holds as many, all finite (kBadData), or where it cannot be
// read (kIo).
Eigen::Matrix3Xd ReadNpyVectors(const JsonNode& node, const std::string& folder, int count);

}  // namespace clothid

#endif  // CLOTHID_SIM_MESH_MESH_JSON_H_
