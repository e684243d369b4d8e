// The prescribed motion of a surface that deforms: the same triangles, the places of its vertices given at increasing
// times.
#ifndef CLOTHID_SIM_OBSTACLE_SURFACE_SEQUENCE_H_
#define CLOTHID_SIM_OBSTACLE_SURFACE_SEQUENCE_H_

#include <Eigen/Core>
#include <utility>

#include "sim/obstacle/triangulated_surface.h"
#include "sim/path/placement.h"
#include "sim/path/rigid_path.h"

namespace clothid {

// Where all vertices are, and their velocities.
struct VerticesJet {
  Eigen::Matrix3Xd pose, rate;  // m, m/s
};

// Every vertex follows a piecewise cubic with continuous velocity, as the origin of a rigid body does (rigid_path.h).
// Before the first and after the last frame the surface stands still.
class SurfaceSequence {
 public:
  // times [T] s, strictly increasing; positions [3V x T] m of the vertices of `surface`. Throws `Error` (kBadData)
  // for numbers of another size, `MeshError`, naming the frame from 0 on, for one that is not finite, for a frame in
  // which the surface has no outside (TriangulatedSurface::ExpectOutsideAt), and for a vertex that jumps: faster than
  // kMostPathSpeed from frame to frame.
  SurfaceSequence(const TriangulatedSurface& surface, const Eigen::VectorXd& times, const Eigen::MatrixXd& positions);

  const Eigen::VectorXd& times() const { return times_; }
  const Eigen::MatrixXd& positions() const { return positions_; }
  int num_vertices() const { return static_cast<int>(positions_.rows() / 3); }

  // At `placement`.
  VerticesJet At(const Placement& placement, double time) const;
  // The surface with its vertices there [3 x V].
  TriangulatedSurface MovedTo(Eigen::Matrix3Xd vertices) const { return surface_.MovedTo(std::move(vertices)); }

  // The map of a face at `placement` (deformed_surface.h): its corners a, b, c and normal n are in [b - a | c - a | n |
  // a]. FaceChange is its derivative by a part of the placement, without the acceleration.
  PoseJet FaceAt(int face, const Placement& placement, double time) const;
  PoseJet FaceChange(int face, const Placement& placement, PlacementPart part, double time) const;

 private:
  PoseJet UnplacedFace(int face, double time) const;

  TriangulatedSurface surface_;
  Eigen::VectorXd times_;
  Eigen::MatrixXd positions_;  // [3V x T]
  Eigen::MatrixXd slopes_;     // [3V x T] m/s
  Eigen::Vector3d centre_;     // of the vertices in the first frame
};

}  // namespace clothid

#endif  // CLOTHID_SIM_OBSTACLE_SURFACE_SEQUENCE_H_
