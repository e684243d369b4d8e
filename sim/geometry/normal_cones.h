// From where a part of a surface can hold a closest point: only along its normals.
#ifndef CLOTHID_SIM_GEOMETRY_NORMAL_CONES_H_
#define CLOTHID_SIM_GEOMETRY_NORMAL_CONES_H_

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "sim/geometry/box_tree.h"

namespace clothid {

// For a tree of the faces of a surface. Where the normals of a part are within an angle phi of an axis and its border
// is elsewhere, the distance to a point x has no local minimum q in it unless x - q is within phi of the axis or of its
// opposite: every feature is surrounded by faces, of which one would rise towards x. So of a flat sheet only what lies
// straight below a point is looked at, however far a search reaches.
class NormalCones {
 public:
  // Where the faces are, and boxes of unit normals [F]: of a face and of those around its features, m and 1; all of
  // [-1, 1]^3 where there is a border.
  void Refit(const BoxTree& tree, const std::vector<BoxTree::Box>& places, const std::vector<BoxTree::Box>& normals);

  // False where no feature below a node of the tree holds a local minimum of the distance to x.
  bool MayHoldClosest(int tree_node, const Eigen::Vector3d& x) const {
    const Cone& cone = cones_[tree_node];
    const Eigen::Vector3d offset = x - cone.centre;
    const double along = offset.dot(cone.axis);
    const double across = cone.radius + cone.tangent * (std::abs(along) + cone.radius);
    return !(offset.squaredNorm() - along * along > across * across);
  }

 private:
  struct Patch {
    BoxTree::Box places, normals;
  };
  struct Cone {
    Eigen::Vector3d centre, axis;
    double radius = 0.0;   // of a sphere around the part, m
    double tangent = 0.0;  // of phi
  };

  std::vector<Patch> faces_, patches_;
  std::vector<Cone> cones_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_GEOMETRY_NORMAL_CONES_H_
