// An obstacle made of triangles: the signed distance to a closed surface, such as one read from an OBJ file.
//
// The closest point is that of the nearest feature, a face, an edge or a vertex, and the gap is negative where the
// angle-weighted pseudonormal of that feature points away from x (Baerentzen and Aanaes, "Signed distance computation
// using the angle weighted pseudonormal", 2005). With q the offset of x from the closest point and s = +-1 the sign:
//
//     face:    phi = n . q,   n the normal of the face,   dn/dx = 0
//     edge:    phi = s |q|,   n = s q / |q|,              dn/dx = s (I - n n^T - e e^T) / |q|,  e along the edge
//     vertex:  phi = s |q|,   n = s q / |q|,              dn/dx = s (I - n n^T) / |q|
//
// Normals are not smoothed. Close to the surface n jumps where x moves from one face to the next, so contacts there are
// not a smooth function of the state; at a distance outside, edges and vertices act as parts of cylinders and spheres
// around them. A contact distance (see `SceneObstacle`) therefore rounds off convex edges, with that radius. An edge
// between faces in one plane is no edge, and a vertex within a straight edge or a flat face is none either.
#ifndef CLOTHID_SIM_OBSTACLE_TRIANGULATED_SURFACE_H_
#define CLOTHID_SIM_OBSTACLE_TRIANGULATED_SURFACE_H_

#include <Eigen/Core>
#include <memory>
#include <string>

#include "sim/obstacle/obstacle.h"
#include "sim/obstacle/surface_features.h"

namespace clothid {

// The most faces a surface may have: what fits into the text of a scene, in which a recording carries it.
inline constexpr int kMaxSurfaceFaces = 100000;

// What is closest to a point.
struct NearestFeature {
  SurfaceFeature feature;
  int face = 0;  // that it belongs to
  SurfacePoint point;
};

// Immutable; copies share their data. `Closest` is a function of the position alone, may be called from several threads
// and allocates nothing. Where features are equally near, which one counts is arbitrary but always the same.
class TriangulatedSurface : public Obstacle {
 public:
  // `vertices` [3 x V] m, `faces` [3 x F] vertex indices, counter-clockwise seen from outside. Throws
  // `MeshError` unless the mesh is one that `ValidateMesh` accepts, has at most kMaxSurfaceFaces faces, is closed
  // (every edge has two triangles: a surface with a border has no inside; a sheet must be given a thickness), encloses
  // a positive volume, and has no triangles folded flat onto each other. Several closed parts are one obstacle. That
  // parts do not cut each other or themselves is not checked.
  TriangulatedSurface(Eigen::Matrix3Xd vertices, Eigen::Matrix3Xi faces);

  // Where |q| is lost to rounding, n is the pseudonormal and dn/dx = 0.
  SurfacePoint Closest(const Eigen::Vector3d& position) const override;
  NearestFeature Nearest(const Eigen::Vector3d& position) const;

  // The same faces between other places of the vertices: its search tree is that of this one, refitted. Nothing is
  // checked. Where faces lie flat on each other or have no area, n is that of one side.
  TriangulatedSurface MovedTo(Eigen::Matrix3Xd vertices) const;
  // Throws `MeshError`, led by `source`, where it cannot be an obstacle there: "triangle 5 has no area", ..
  void ExpectOutsideAt(const Eigen::Matrix3Xd& vertices, const std::string& source) const;

  const Eigen::Matrix3Xd& vertices() const;
  const Eigen::Matrix3Xi& faces() const;

 private:
  struct Data;
  explicit TriangulatedSurface(std::shared_ptr<const Data> data);

  std::shared_ptr<const Data> data_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_OBSTACLE_TRIANGULATED_SURFACE_H_
