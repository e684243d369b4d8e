// Seams and buttons: pieces of cloth become one mesh.
#ifndef CLOTHID_SIM_MESH_SEWING_H_
#define CLOTHID_SIM_MESH_SEWING_H_

#include <map>
#include <utility>
#include <vector>

#include "sim/mesh/mesh.h"

namespace clothid {

// Stiffness of what draws a seam together, N/m per m of its length at rest, and of a button, N/m: 2 N/m of tension, the
// weight of a metre of shirt, open a seam by 0.02 mm.
inline constexpr double kSeamStiffness = 1e5;
inline constexpr double kButtonStiffness = 1e3;

// How much longer one side of a seam may be than the other that is not eased in, relative to the longer one.
inline constexpr double kMostEase = 0.05;

// Two chains of nodes along borders, a and b. They run the same way along the seam, a closed one ends where it starts.
//
// Joined, with as many nodes each, the nodes of b become those of a, at the positions of a; the mesh must have a rest
// place per corner. Else, the chain with more nodes, b where both have as many, is drawn to the other by links: to
// its nodes in turn, or, with another number of them, to the points at the same shares of its rest length. A link has
// the stiffness times half the rest length of the edges beside its node.
struct Seam {
  std::vector<int> a, b;
  bool is_drawn = false;              // by links, over `closing_time`; else joined, or linked at once
  double closing_time = 0.0;          // s
  double stiffness = kSeamStiffness;  // N/m^2
  bool is_fold = false;               // nothing bends across it where it is joined; across links nothing ever does
  bool is_eased = false;              // the sides may have different lengths
};

// Sews one seam after the other. Seams and buttons count the nodes of the mesh as it came; a chain may go on over a
// seam that is joined already. In the mesh that is sewn the nodes of b are gone, those that follow count down.
class Sewing {
 public:
  explicit Sewing(Mesh* mesh);  // which must outlive it

  // Throws `Error` (kBadData), in words for the key of the seam: unless there are two nodes or more in each chain, each
  // once, and edges of the border between them that no other seam has; where the rest lengths differ by more than
  // kMostEase of the longer one and are not eased in; and where joining needs a rest place per corner.
  void Add(const Seam& seam);
  // Throws `Error` (kBadData) unless they are two nodes that are not joined.
  void AddButton(int a, int b);

  // Gives the mesh its new numbers, folds and links. It then has to pass ValidateMesh.
  void Finish();

 private:
  // A border, by the nodes that the mesh has now.
  struct Chain {
    std::vector<int> nodes;
    std::vector<double> places;  // of the nodes, m at rest from the first
  };
  using Edge = std::pair<int, int>;  // low, high

  void FindBorder();
  Chain FindChain(const std::vector<int>& nodes, const char* name) const;
  double BorderLength(int from, int to, const char* name) const;  // m at rest
  bool IsSewn(int from, int to) const;
  void Join(const Seam& seam, const Chain& a, const Chain& b);
  void Draw(const Seam& seam, const Chain& from, const Chain& to);

  Mesh* mesh_;
  std::vector<int> now_;                        // [N] which node a node has become
  std::map<Edge, std::pair<int, int>> border_;  // of the mesh as it is now: face and side
  std::vector<Edge> sewn_, folds_;              // by numbers that their nodes had once
  std::vector<SeamLink> links_;                 // likewise
};

// Of a mesh with a rest place per corner, whose pieces share nodes already: throws `Error` (kBadData), led by `source`,
// where the two sides of an edge differ in length by more than kMostEase of the longer one, as in a map that distorts.
void ExpectEvenSeams(const Mesh& mesh, const std::string& source);

}  // namespace clothid

#endif  // CLOTHID_SIM_MESH_SEWING_H_
