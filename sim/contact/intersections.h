// Counts where a cloth passes through itself.
#ifndef CLOTHID_SIM_CONTACT_INTERSECTIONS_H_
#define CLOTHID_SIM_CONTACT_INTERSECTIONS_H_

#include <Eigen/Core>
#include <array>
#include <vector>

#include "sim/geometry/box_tree.h"
#include "sim/mesh/mesh.h"

namespace clothid {

struct Intersections {
  int count = 0;                        // of pairs of triangles
  std::array<int, 2> first = {-1, -1};  // the lowest pair, ascending
};

// Pairs of triangles without a common node of which an edge of one passes through the other: its ends are strictly on
// either side of the triangle's plane, and its line passes strictly inside the triangle's three sides, by the signs of
// five volumes. A volume that is zero within rounding has no sign: triangles that touch at a point or along an edge or
// lie in a plane do not count. O(n log n). Not to be used by several threads at once.
class IntersectionCounter {
 public:
  explicit IntersectionCounter(const Mesh& mesh);

  Intersections Count(const Eigen::VectorXd& positions);  // [3N] m

 private:
  void Place(const Eigen::VectorXd& positions);  // boxes_

  Eigen::Matrix3Xi faces_;
  std::vector<BoxTree::Box> boxes_;
  BoxTree tree_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_CONTACT_INTERSECTIONS_H_
