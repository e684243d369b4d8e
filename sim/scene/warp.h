// The directions of the yarns in a cloth at rest.
#ifndef CLOTHID_SIM_SCENE_WARP_H_
#define CLOTHID_SIM_SCENE_WARP_H_

#include <Eigen/Core>
#include <string>

#include "sim/mesh/mesh.h"

namespace clothid {

// In a triangle the warp is `direction`, or that of the triangle in `directions`, projected onto its plane and turned
// there by `angle`, counter-clockwise as seen from the side of its normal, about which its corners run
// counter-clockwise. The weft is a right angle further. Of a mesh with a rest place per corner, directions are
// (u, v, 0): the default is along u.
struct Warp {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();
  double angle = 0.0;                // degrees
  Eigen::Matrix3Xd directions = {};  // [3 x F], in place of `direction`; empty: it is the same everywhere
};

// Unit vectors [3 x F], in the order of the mesh's faces.
Eigen::Matrix3Xd WarpDirections(const Warp& warp, const Mesh& mesh);

// Throws `Error` (kBadData), led by `source`, unless numbers are finite, there is one direction, or one for each
// triangle, and no triangle is perpendicular to its own.
void ValidateWarp(const Warp& warp, const Mesh& mesh, const std::string& source);

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_WARP_H_
