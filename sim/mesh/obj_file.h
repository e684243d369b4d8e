// Wavefront OBJ files: the surface in their `v` and `f` lines, the UV map of their `vt` lines, for the direction of u
// in it or as a rest shape, and the groups of their `g` and `usemtl` lines. A backslash at the end of a line lets it go
// on in the next, '#' starts a comment.
#ifndef CLOTHID_SIM_MESH_OBJ_FILE_H_
#define CLOTHID_SIM_MESH_OBJ_FILE_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "sim/mesh/mesh.h"

namespace clothid {

inline constexpr std::uint64_t kMaxObjBytes = std::uint64_t{1} << 29;

using FaceRange = std::array<int, 2>;  // the first and the last of triangles that follow each other
using FaceRanges = std::vector<FaceRange>;
// The triangles of every group by its name: those after a `g` line that names it, up to the next, or after a `usemtl`
// line. A name may have none.
using FaceGroups = std::map<std::string, FaceRanges>;

// The `v` and `f` lines; polygons are cut into triangles (sim/geometry/polygon.h), into the fan about their first
// corner where that turns none over. Throws `Error` naming file and line.
Mesh ReadObj(const std::string& path);
// Another frame of a surface with the triangles `faces` [3 x F]: its polygons are cut into these where they have their
// vertices, however they are deformed.
Mesh ReadObjLike(const std::string& path, const Eigen::Matrix3Xi& faces);
Mesh ReadObjWithGroups(const std::string& path, FaceGroups* groups);

// The same, and in `along_u` [3 x F] of every triangle the unit vector dX/du: where points X of the surface go when u
// grows and v does not. Throws `Error`, too, where a corner has no texture coordinates, or where those of a triangle
// lie on a line, so that it has no such direction; names file, line and triangle.
Mesh ReadObjWithUv(const std::string& path, Eigen::Matrix3Xd* along_u, FaceGroups* groups = nullptr);

// The same with the UV map as the rest shape, `scale` m per unit, in `corner_rest`; polygons are cut as they lie in it.
// Throws `Error`, too, where a corner
// has no texture coordinates, or where those of a triangle lie on a line; names file, line and triangle.
Mesh ReadObjWithUvRest(const std::string& path, double scale, FaceGroups* groups = nullptr);

// Where in an OBJ file a part of its mesh stands: "path:17", the line of the polygon that a triangle is of, or of the
// vertex; `path` where that is not known.
std::string PlaceInObj(const std::string& path, MeshPart part);

// ValidateMesh, its errors led by the place in the file `path` of the mesh.
void ValidateObjMesh(const Mesh& mesh, const std::string& path);

}  // namespace clothid

#endif  // CLOTHID_SIM_MESH_OBJ_FILE_H_
