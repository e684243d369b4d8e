// Surfaces that deform, for tests.
#ifndef CLOTHID_TESTS_SIM_MOVING_SURFACES_H_
#define CLOTHID_TESTS_SIM_MOVING_SURFACES_H_

#include <Eigen/Core>
#include <memory>

#include "sim/obstacle/surface_sequence.h"
#include "sim/obstacle/triangulated_surface.h"
#include "sim/scene/scene.h"
#include "tests/sim/scene/triangle_meshes.h"

namespace clothid {

// Gives `obstacle` the shape `mesh`, of which every vertex p is at `place(p, t)` m at `count` times from `begin` to
// `end`, s.
template <typename Place>
void Deform(const TriangleMesh& mesh, double begin, double end, int count, const Place& place,
            SceneObstacle* obstacle) {
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(count, begin, end);
  Eigen::MatrixXd positions(mesh.vertices.size(), count);
  for (int frame = 0; frame < count; ++frame) {
    for (Eigen::Index i = 0; i < mesh.vertices.cols(); ++i) {
      positions.col(frame).segment<3>(3 * i) = place(Eigen::Vector3d(mesh.vertices.col(i)), times[frame]);
    }
  }
  const auto surface = std::make_shared<TriangulatedSurface>(mesh.vertices, mesh.faces);
  obstacle->shape = surface;
  obstacle->sequence = std::make_shared<SurfaceSequence>(*surface, times, positions);
}

// A slab of the thickness 0.1 m under the square of the side 2 `half` in the plane z = 0, in many triangles.
inline TriangleMesh SlabMesh(double half, int splits) {
  TriangleMesh mesh = CubeMesh(1.0);
  for (int i = 0; i < splits; ++i) mesh = Split(mesh);
  for (auto vertex : mesh.vertices.colwise()) {
    vertex = Eigen::Vector3d(half * vertex.x(), half * vertex.y(), 0.05 * (vertex.z() - 1.0));
  }
  return mesh;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_MOVING_SURFACES_H_
