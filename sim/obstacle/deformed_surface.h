// A surface that deforms, where a solve starts, and how every place of it moves over the solve.
//
// A face is an affine body of its own: the map A = [b - a | c - a | n | a] of its corners and its unit normal takes the
// point p = (p_1, p_2, p_3) = A^-1 x to x, p_1 and p_2 its barycentric coordinates and p_3 its height over the face, at
// which it stays while the face turns and stretches. So what affine_motion.h has of a body holds of the face that the
// closest point of x belongs to: V = E A_0^-1 x at the barycentric point, and p_3 over it, where a node at a contact
// distance is. Where faces meet the V of both are the same on the surface, and differ by p_3 times what they turn
// against each other.
//
//   on a face           gap = p_3, n the normal of A_0
//   on edge and vertex  the distance from them where A_0 has the corners (triangulated_surface.h): in the second stage
//                       of a step off that of a rigid body by a share of second order in the angle of the step
#ifndef CLOTHID_SIM_OBSTACLE_DEFORMED_SURFACE_H_
#define CLOTHID_SIM_OBSTACLE_DEFORMED_SURFACE_H_

#include <Eigen/Core>
#include <functional>

#include "sim/obstacle/affine_motion.h"
#include "sim/obstacle/triangulated_surface.h"

namespace clothid {

class DeformedSurface {
 public:
  using MapsOfFace = std::function<SolveMaps(int face)>;

  // `start` has its corners where `maps` has those of every face at the start of the solve.
  DeformedSurface(TriangulatedSurface start, MapsOfFace maps);

  MovedSurfacePoint Closest(const Eigen::Vector3d& position) const;
  // How the face moves that the closest point belongs to.
  AffineMotion MotionNear(const Eigen::Vector3d& position) const;
  AffineMotion MotionOf(int face) const { return AffineMotion(maps_(face)); }
  // At `position`, along a change of the maps.
  MotionChange Differentiate(const MapsOfFace& change, const Eigen::Vector3d& position) const;

 private:
  TriangulatedSurface start_;
  MapsOfFace maps_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_OBSTACLE_DEFORMED_SURFACE_H_
