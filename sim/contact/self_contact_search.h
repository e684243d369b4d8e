// The parts of a cloth that may touch each other in a step.
//
// A pair is a local minimum of the distance of two features (as in "Offset Geometric Contact", Chen et al. 2025). With
// the offset e = p - q of its closest points:
//   vertex, face     q is inside the face
//   vertex, edge     q is inside the edge, and e points into none of the edge's faces: they hold no closer point
//   vertex, vertex   e points along none of the edges of one of the two
//   edge, edge       p and q are inside, sin^2 of the angle between the edges is above 1e-4, and e is within the normal
//                    cones of both edges: e points away from the faces of one, -e from those of the other; .001 rad
//                    away from the borders of both cones, .05 rad from those of one. Beside an edge that is joined to
//                    the other one by a face, e may point .1 rad into that face, whose points make no pair with it. All
//                    this where the cones themselves are as wide: of one edge .1 rad, of the other .002
// The vertex of the first three need not be a local minimum itself. "Inside" is by more than 1e-6 of the edge or face,
// and what is less belongs to the lower feature: where meshes lie on each other vertex on vertex, rounding then does
// not choose the kind. Layers that lie flat on each other have no pair of two edges; a distance of zero is no pair.
//
// Parts that belong together at rest are no pairs: those of which two nodes, one of each feature, are less than twice
// the thickness apart at rest, along edges and links (seams and buttons of `Mesh::links`), which have no length. So two
// faces beside an edge may meet where a cloth folds as finely as its mesh.
#ifndef CLOTHID_SIM_CONTACT_SELF_CONTACT_SEARCH_H_
#define CLOTHID_SIM_CONTACT_SELF_CONTACT_SEARCH_H_

#include <Eigen/Core>
#include <array>
#include <vector>

#include "sim/contact/pair_geometry.h"
#include "sim/geometry/box_tree.h"
#include "sim/geometry/normal_cones.h"
#include "sim/mesh/mesh.h"
#include "sim/mesh/rest_neighbours.h"

namespace clothid {

// Not to be used by several threads at once: memory is kept from call to call.
class SelfContactSearch {
 public:
  // `thickness` > 0, m: the distance at which the cloth's midsurface meets itself.
  SelfContactSearch(const Mesh& mesh, double thickness);

  // The pairs at `positions` [3N], m, whose distance is at most
  //   5/4 thickness + further_reach + gap_time (|v_i| + |v_j|),
  // |v_i| and |v_j| the largest speeds of the nodes of either feature in `velocities` [3N], m/s; ascending, each once.
  // About O(n log n) while the reach is in the order of an edge; beyond, it grows with the square of the reach.
  void Find(const Eigen::VectorXd& positions, const Eigen::VectorXd& velocities, double gap_time, double further_reach,
            std::vector<PairFeatures>* pairs);

  // The least distance at `positions` of parts that are nearer than 5/4 of the thickness, m; that, where there are
  // none.
  double LeastDistance(const Eigen::VectorXd& positions);

 private:
  struct Edge {
    std::array<int, 2> nodes;                // ascending
    std::array<int, 2> opposite = {-1, -1};  // the third nodes of its faces; -1: a border
    std::array<int, 2> faces = {-1, -1};
  };
  struct Search;  // one call of `Find`

  void CollectEdges();
  void CollectEdgesOfNodes();
  void CollectRings();
  void PlaceFaces(const Search& search);
  void PlaceEdges(const Search& search);

  double reach_;                      // 5/4 thickness, m
  Eigen::Matrix3Xi faces_;            // [3 x F]
  Eigen::Matrix3Xi face_edges_;       // [3 x F] of the sides from a corner to the next
  std::vector<Edge> edges_;           // [E] ascending by nodes
  std::vector<int> node_faces_;       // [N] the first face of every node
  std::vector<int> node_edges_;       // of node 0, of node 1, ...
  std::vector<int> first_node_edge_;  // [N + 1] where these begin
  // Of a face and the edges and nodes of which it is the first face: all faces around them; none where a border is.
  std::vector<int> rings_, first_ring_;  // as above, [F + 1]
  RestNeighbours neighbours_;
  BoxTree face_tree_, edge_tree_;
  NormalCones cones_;
  // Of the last search.
  std::vector<double> node_reach_;                                             // [N] gap_time |v|, m
  std::vector<int> sharp_edges_;                                               // one of two is among these
  std::vector<Eigen::Vector3d> normals_;                                       // [F]
  std::vector<BoxTree::Box> places_, normal_boxes_, face_boxes_, edge_boxes_;  // [F], [F], [F], [E]
};

}  // namespace clothid

#endif  // CLOTHID_SIM_CONTACT_SELF_CONTACT_SEARCH_H_
