#include "sim/mesh/rest_neighbours.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <tuple>

namespace clothid {
namespace {

// A node that can be reached, and the length of the way, m.
struct Way {
  double length;
  int node;
  bool operator>(const Way& other) const { return std::tie(length, node) > std::tie(other.length, other.node); }
};
using Ways = std::vector<std::vector<Way>>;  // [N] to the neighbours of every node

Ways WaysAtRest(const Mesh& mesh) {
  Ways ways(mesh.num_nodes());
  const auto join = [&](int a, int b, double length) {
    ways[a].push_back({length, b});
    ways[b].push_back({length, a});
  };
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int k = 0; k < 3; ++k) join(mesh.faces(k, f), mesh.faces((k + 1) % 3, f), RestLength(mesh, f, k));
  }
  for (const SeamLink& link : mesh.links) {
    for (const int end : link.edge) join(link.node, end, 0.0);
  }
  return ways;
}

// Nodes that are less than `limit` away from one (Dijkstra 1959).
class NearNodes {
 public:
  NearNodes(const Ways& ways, double limit)
      : ways_(ways), limit_(limit), lengths_(ways.size(), std::numeric_limits<double>::infinity()) {}

  void Append(int start, std::vector<int>* nodes) {
    std::vector<int> reached;
    Reach({0.0, start}, &reached);
    while (!queue_.empty()) {
      const Way way = queue_.top();
      queue_.pop();
      if (way.length > lengths_[way.node]) continue;
      for (const Way& next : ways_[way.node]) Reach({way.length + next.length, next.node}, &reached);
    }
    for (const int node : reached) lengths_[node] = std::numeric_limits<double>::infinity();
    nodes->insert(nodes->end(), reached.begin(), reached.end());
  }

 private:
  void Reach(const Way& way, std::vector<int>* reached) {
    if (!(way.length < limit_ && way.length < lengths_[way.node])) return;
    if (std::isinf(lengths_[way.node])) reached->push_back(way.node);
    lengths_[way.node] = way.length;
    queue_.push(way);
  }

  const Ways& ways_;
  double limit_;
  std::vector<double> lengths_;
  std::priority_queue<Way, std::vector<Way>, std::greater<Way>> queue_;
};

}  // namespace

RestNeighbours::RestNeighbours(const Mesh& mesh, double closest) : first_(1, 0) {
  const Ways ways = WaysAtRest(mesh);
  NearNodes near(ways, closest);
  for (std::size_t i = 0; i < ways.size(); ++i) {
    neighbours_.push_back(static_cast<int>(i));
    near.Append(static_cast<int>(i), &neighbours_);
    const auto first = neighbours_.begin() + first_.back();
    std::sort(first, neighbours_.end());
    neighbours_.erase(std::unique(first, neighbours_.end()), neighbours_.end());
    first_.push_back(static_cast<int>(neighbours_.size()));
  }
}

bool RestNeighbours::Contains(int node, int other) const {
  const auto begin = neighbours_.begin();
  return std::binary_search(begin + first_[node], begin + first_[node + 1], other);
}

}  // namespace clothid
