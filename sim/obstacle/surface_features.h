// What can be closest to a point on a closed surface of triangles: a face, an edge or a vertex (triangulated_surface.h
// has the formulas). What they are depends on the places of the vertices, which may change; which there are and what
// lies between them does not.
#ifndef CLOTHID_SIM_OBSTACLE_SURFACE_FEATURES_H_
#define CLOTHID_SIM_OBSTACLE_SURFACE_FEATURES_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "sim/geometry/triangle_tree.h"
#include "sim/mesh/mesh.h"
#include "sim/obstacle/obstacle.h"

namespace clothid {

// The normal is constant on a plane, turns about a crease and points away from a corner; an edge within a plane is a
// plane, a vertex within a straight edge a crease.
struct SurfaceFeature {
  enum class Kind { kPlane, kCrease, kCorner };

  Kind kind = Kind::kPlane;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();   // any point of it
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // pseudonormal, a unit vector
  Eigen::Vector3d along = Eigen::Vector3d::Zero();   // of a crease, a unit vector
};

// phi, n and dn/dx of points whose closest point is on `feature`. Nearer than `least_distance` (m) there is no
// direction: n is the pseudonormal and dn/dx = 0.
SurfacePoint EvaluateFeature(const SurfaceFeature& feature, const Eigen::Vector3d& x, double least_distance);

// The features of a surface are numbered: first the faces, then the edges, then the vertices.
class SurfaceTopology {
 public:
  // Throws `MeshError` where an edge has one triangle only. `mesh` is one that ValidateMesh accepts.
  explicit SurfaceTopology(const Mesh& mesh);

  int num_features() const { return num_faces_ + static_cast<int>(edges_.size() + corners_.size()); }
  // Numbers the features of `triangles`, which are the faces in their order.
  void NumberFeatures(std::vector<SearchTriangle>* triangles) const;
  // Where the faces are at `triangles`. Where a normal is undefined, which ExpectOutside tells, it is any.
  SurfaceFeature FeatureAt(int feature, const std::vector<SearchTriangle>& triangles) const;
  // A face that a feature belongs to: the first.
  int FaceOf(int feature) const;
  // Throws `MeshError`, led by `source`, where the surface has no outside there.
  void ExpectOutside(const std::vector<SearchTriangle>& triangles, const std::string& source) const;

 private:
  struct Side {
    int face, side;  // side k runs from corner k to corner k + 1
  };
  struct Edge {
    Side one, other;  // the one runs from the lower to the higher vertex
    int low, high;
  };

  SurfaceFeature EdgeAt(const Edge& edge, const std::vector<SearchTriangle>& triangles) const;
  SurfaceFeature VertexAt(const std::vector<Side>& corners, const std::vector<SearchTriangle>& triangles) const;

  int num_faces_;
  std::vector<Edge> edges_;                 // in the order of their vertices
  std::vector<std::vector<Side>> corners_;  // of the faces around every vertex
};

}  // namespace clothid

#endif  // CLOTHID_SIM_OBSTACLE_SURFACE_FEATURES_H_
