// PLY: meshes and point clouds, and writing them again.
#include "datasets/formats/ply_file.h"
#include "tests/fuzz/fuzz_target.h"

int clothid::FuzzPly(const std::uint8_t* data, std::size_t size) {
  static const MemoryFile file, copy;
  file.Write(AsText(data, size));
  Mesh mesh;
  if (!Accepts([&] { mesh = ReadPly(file.path()); }, file.path())) return 0;
  if (mesh.num_faces() > 0) {
    Check(mesh.faces.minCoeff() >= 0 && mesh.faces.maxCoeff() < mesh.num_nodes(), "faces made of its vertices");
  }
  Check(!mesh.rest_positions.array().isInf().any(), "positions that are finite or NaN");
  copy.Write(PlyBytes(mesh.rest_positions, mesh.faces));
  const Mesh again = ReadPly(copy.path());
  Check(again.num_nodes() == mesh.num_nodes() && again.faces == mesh.faces, "the mesh that was written");
  Check((again.rest_positions.array() == mesh.rest_positions.array() || mesh.rest_positions.array().isNaN()).all(),
        "the positions that were written");
  return 0;
}
