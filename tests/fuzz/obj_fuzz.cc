// OBJ: as the cloth, and as an obstacle.
#include <cmath>

#include "sim/mesh/mesh.h"
#include "sim/mesh/obj_file.h"
#include "sim/obstacle/triangulated_surface.h"
#include "tests/fuzz/fuzz_target.h"

namespace clothid {
namespace {

void CheckFinite(const SurfacePoint& point) {
  Check(std::isfinite(point.gap) && point.normal.allFinite() && point.normal_gradient.allFinite(),
        "a finite distance, normal and curvature");
}

void CheckSurface(const Mesh& mesh) {
  const TriangulatedSurface surface(mesh.rest_positions, mesh.faces);
  const Eigen::Vector3d vertex = mesh.rest_positions.col(0);
  for (const Eigen::Vector3d& position : {Eigen::Vector3d(0.1, 0.2, 0.3), vertex, Eigen::Vector3d(2.0 * vertex),
                                          Eigen::Vector3d(mesh.rest_positions.rowwise().mean())}) {
    CheckFinite(surface.Closest(position));
  }
}

}  // namespace
}  // namespace clothid

int clothid::FuzzObj(const std::uint8_t* data, std::size_t size) {
  static const MemoryFile file;
  file.Write(AsText(data, size));
  Mesh mesh;
  if (!Accepts([&] { mesh = ReadObj(file.path()); }, file.path())) return 0;
  Eigen::Matrix3Xd along_u;
  if (Accepts([&] { ReadObjWithUv(file.path(), &along_u); }, file.path())) {
    Check(along_u.cols() == mesh.num_faces(), "a direction of u in every triangle");
  }
  FaceGroups groups;
  ReadObjWithGroups(file.path(), &groups);
  for (const auto& [name, ranges] : groups) {
    for (const auto& [first, last] : ranges) {
      Check(0 <= first && first <= last && last < mesh.num_faces(), "triangles of a group that are there");
    }
  }
  Mesh garment;
  if (Accepts([&] { garment = ReadObjWithUvRest(file.path(), 0.5); }, file.path())) {
    Check(garment.corner_rest.cols() == 3 * garment.num_faces(), "a place at rest for every corner");
    Accepts([&] { ValidateMesh(garment, "garment"); }, "garment");
  }
  if (Accepts([&] { ValidateMesh(mesh, "cloth"); }, "cloth")) Check(ClothSize(mesh) > 0.0, "a cloth with an area");
  Accepts([&] { CheckSurface(mesh); }, "triangulated surface");
  return 0;
}
