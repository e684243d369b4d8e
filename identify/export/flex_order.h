// An order of nodes and triangles in which MuJoCo bends every edge as it should.
//
// MuJoCo 3.14.0 keeps the ends of an edge in the order of their numbers, but computes its bending weights in the order
// in which its first triangle runs along it: where that is from the higher number to the lower one the weights of both
// ends are swapped. With its nodes in rising order, a triangle does so along the edge from its lowest to its highest
// node alone. Across that edge lies a triangle that spans more numbers, unless it is the longest edge of both: so
// triangles come by falling span, and what is left to choose is the numbers of the nodes.
#ifndef CLOTHID_IDENTIFY_EXPORT_FLEX_ORDER_H_
#define CLOTHID_IDENTIFY_EXPORT_FLEX_ORDER_H_

#include <Eigen/Core>
#include <vector>

#include "sim/scene/mesh.h"

namespace clothid {

struct FlexOrder {
  std::vector<int> nodes;  // [N] of the mesh, by their number in the flex
  Eigen::Matrix3Xi faces;  // [3 x F] of these numbers
  int num_swapped = 0;     // inner edges whose weights MuJoCo swaps and that differ
};

// The best of the mesh's own order and of orders along some directions.
FlexOrder OrderFlex(const Mesh& mesh);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_EXPORT_FLEX_ORDER_H_
