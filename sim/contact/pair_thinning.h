// Which of the pairs that may touch get a contact: as many as leave the rows of the contacts independent.
//
// Between two layers that lie on each other, the vertices of one against the faces of the other say everything, and
// those of the other say it again: both together are rank deficient or lock the layers. So every accepted pair names a
// slave, a node of its own that follows the others of the pair, and the graph from slaves to the nodes they follow has
// no circle. Then the rows J are triangular in a suitable order, with the slaves' weights on the diagonal: of full
// rank.
//
// Slaves: the vertex of a pair of a vertex and something; either one of two vertices; of two edges, or where that
// vertex cannot follow or follows another pair, the node with the largest |weight| that can, if above 0.05.
//
// Turns: by increasing gap, where gaps that round to the same multiple of `tie` count as equal and overlaps as 0
// (layers at rest on each other differ by rounding alone). Among equals, so that layers meet in one direction:
//   1. pairs that go on with a direction: a node that the vertex would follow has a slave on the vertex's side,
//   2. pairs at new places,
//   3. pairs against a direction: a node that the vertex would follow is itself a slave of the vertex's side. What they
//      add is where the first layer has no vertices, as under a coarse one,
//   4. pairs of edges,
//   5. pairs whose vertex cannot be the slave,
// and within these by the place of their vertex in an order of the nodes that is given, which so decides the direction
// where layers meet, then by gap, then by features. A pair whose vertex has slaves on the other feature's side is
// rejected: with both directions at one place layers could not bend.
#ifndef CLOTHID_SIM_CONTACT_PAIR_THINNING_H_
#define CLOTHID_SIM_CONTACT_PAIR_THINNING_H_

#include <vector>

#include "sim/contact/pair_geometry.h"
#include "sim/mesh/mesh.h"

namespace clothid {

struct ThinningPair {
  PairFeatures features;
  PairGeometry geometry;
  double gap = 0.0;  // m
};

struct AcceptedPair {
  int pair = 0;   // its index
  int slave = 0;  // a node of the mesh
};

struct ThinnedPairs {
  std::vector<AcceptedPair> accepted;  // in the order of acceptance
  std::vector<int> rejected;           // indices, ascending
};

// An order in which nodes are fit to follow others [N], place of each: those with shorter edges at rest first, in half
// octaves, so that fine vertices follow coarse faces; then by their numbers.
std::vector<int> FollowOrder(const Mesh& mesh);

// `pairs` in any order, no two with the same features; the result is the same in all. `can_follow` [N]: false for nodes
// that must not be slaves: handles, and nodes that stick to an obstacle. `tie` > 0, m: some share of the thickness.
// `follow_order` [N]; empty: by number. O(P log P + N) for P pairs in layers.
ThinnedPairs ThinPairs(const std::vector<ThinningPair>& pairs, const std::vector<bool>& can_follow, double tie,
                       const std::vector<int>& follow_order = {});

}  // namespace clothid

#endif  // CLOTHID_SIM_CONTACT_PAIR_THINNING_H_
