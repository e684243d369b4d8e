#include "sim/mesh/sewing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <sstream>
#include <string>

#include "sim/base/error.h"

namespace clothid {
namespace {

constexpr double kAtNode = 1e-9;  // of the length of an edge: as near is at its end

[[noreturn]] void FailOnSeam(const std::string& message) { throw Error(ErrorKind::kBadData, message); }

std::string NodeText(int node) { return "node " + std::to_string(node); }

// Half the length of the edges beside a node of a chain.
double ShareOfLength(const std::vector<double>& places, std::size_t i) {
  return 0.5 * (places[std::min(i + 1, places.size() - 1)] - places[i == 0 ? 0 : i - 1]);
}

}  // namespace

Sewing::Sewing(Mesh* mesh) : mesh_(mesh), now_(static_cast<std::size_t>(mesh->num_nodes())) {
  for (std::size_t node = 0; node < now_.size(); ++node) now_[node] = static_cast<int>(node);
  FindBorder();
}

void Sewing::FindBorder() {
  border_.clear();
  std::map<Edge, int> counts;
  for (int face = 0; face < mesh_->num_faces(); ++face) {
    for (int side = 0; side < 3; ++side) {
      const Edge edge = std::minmax(int{mesh_->faces(side, face)}, int{mesh_->faces((side + 1) % 3, face)});
      border_[edge] = {face, side};
      if (++counts[edge] > 1) border_.erase(edge);
    }
  }
}

bool Sewing::IsSewn(int from, int to) const {
  return std::any_of(sewn_.begin(), sewn_.end(), [&](const Edge& edge) {
    return Edge(std::minmax(now_[edge.first], now_[edge.second])) == Edge(std::minmax(from, to));
  });
}

double Sewing::BorderLength(int from, int to, const char* name) const {
  const Edge edge = std::minmax(now_[from], now_[to]);
  const std::string nodes = "nodes " + std::to_string(from) + " and " + std::to_string(to) + " of " + name;
  if (IsSewn(edge.first, edge.second)) {
    FailOnSeam(nodes + " are sewn already; an edge of the cloth has two triangles at most");
  }
  const auto found = border_.find(edge);
  if (found != border_.end()) return RestLength(*mesh_, found->second.first, found->second.second);
  for (const int node : {from, to}) {
    const bool is_at_border = std::any_of(border_.begin(), border_.end(), [&](const auto& entry) {
      return entry.first.first == now_[node] || entry.first.second == now_[node];
    });
    if (!is_at_border) FailOnSeam(NodeText(node) + " of " + name + " is not on the border of the mesh");
  }
  FailOnSeam(nodes + " are no edge of the border of the mesh");
}

Sewing::Chain Sewing::FindChain(const std::vector<int>& nodes, const char* name) const {
  Chain chain;
  int last = 0;  // as it is called
  for (const int node : nodes) {
    if (node < 0 || node >= static_cast<int>(now_.size())) {
      FailOnSeam(NodeText(node) + " of " + name + ": expected 0 to " + std::to_string(now_.size() - 1));
    }
    if (!chain.nodes.empty() && chain.nodes.back() == now_[node]) {
      if (last == node) FailOnSeam(NodeText(node) + " is twice in " + name);
      continue;  // over a seam: the same node by its two numbers
    }
    chain.places.push_back(chain.nodes.empty() ? 0.0 : chain.places.back() + BorderLength(last, node, name));
    chain.nodes.push_back(now_[node]);
    last = node;
  }
  if (chain.nodes.size() < 2) FailOnSeam(std::string("expected at least two nodes in ") + name);
  std::vector<int> sorted = chain.nodes;
  if (sorted.front() == sorted.back() && sorted.size() > 3) sorted.pop_back();  // it is closed
  std::sort(sorted.begin(), sorted.end());
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
  if (twice != sorted.end()) FailOnSeam(NodeText(*twice) + " is twice in " + name);
  return chain;
}

void Sewing::Add(const Seam& seam) {
  const Chain a = FindChain(seam.a, "a"), b = FindChain(seam.b, "b");
  const double length_a = a.places.back(), length_b = b.places.back();
  if (!seam.is_eased && std::abs(length_a - length_b) > kMostEase * std::max(length_a, length_b)) {
    std::ostringstream text;
    text << "a is " << length_a << " m long at rest and b " << length_b << " m; expected the same within "
         << 100.0 * kMostEase << " %, or \"ease\": true";
    FailOnSeam(text.str());
  }
  for (std::size_t i = 1; i < a.nodes.size(); ++i) {
    const Edge edge = std::minmax(a.nodes[i - 1], a.nodes[i]);
    for (std::size_t k = 1; k < b.nodes.size(); ++k) {
      if (Edge(std::minmax(b.nodes[k - 1], b.nodes[k])) != edge) continue;
      FailOnSeam("nodes " + std::to_string(edge.first) + " and " + std::to_string(edge.second) + " are in a and in b");
    }
  }
  if (a.nodes.size() == b.nodes.size() && !seam.is_drawn) {
    Join(seam, a, b);
  } else if (a.nodes.size() > b.nodes.size()) {
    Draw(seam, a, b);
  } else {
    Draw(seam, b, a);
  }
  for (const Chain* chain : {&a, &b}) {
    for (std::size_t i = 1; i < chain->nodes.size(); ++i) sewn_.push_back({chain->nodes[i - 1], chain->nodes[i]});
  }
}

void Sewing::Join(const Seam& seam, const Chain& a, const Chain& b) {
  if (!mesh_->has_corner_rest()) {
    FailOnSeam(
        "expected \"rest\": \"uv\" of the mesh, or \"closes\": a seam that joins pieces needs each of them at rest");
  }
  for (std::size_t i = 0; i < a.nodes.size(); ++i) {
    const int from = now_[b.nodes[i]], to = now_[a.nodes[i]];
    std::replace(now_.begin(), now_.end(), from, to);
    for (int& node : mesh_->faces.reshaped()) node = node == from ? to : node;
    if (i > 0 && seam.is_fold) folds_.push_back({a.nodes[i - 1], a.nodes[i]});
  }
  FindBorder();
}

void Sewing::Draw(const Seam& seam, const Chain& from, const Chain& to) {
  const bool in_turn = from.nodes.size() == to.nodes.size();
  std::size_t edge = 0;  // of `to`, at the node
  for (std::size_t i = 0; i < from.nodes.size(); ++i) {
    SeamLink link{from.nodes[i], {to.nodes[0], to.nodes[0]}, 0.0, 0.0, seam.is_drawn ? seam.closing_time : 0.0};
    link.stiffness = seam.stiffness * ShareOfLength(from.places, i);
    if (in_turn) {
      link.edge = {to.nodes[i], to.nodes[i]};
    } else {
      const double place = from.places[i] / from.places.back() * to.places.back();
      while (edge + 2 < to.nodes.size() && to.places[edge + 1] <= place) ++edge;
      link.edge = {to.nodes[edge], to.nodes[edge + 1]};
      link.share = std::clamp((place - to.places[edge]) / (to.places[edge + 1] - to.places[edge]), 0.0, 1.0);
      if (link.share < kAtNode) link.edge[1] = link.edge[0];
      if (link.share > 1.0 - kAtNode) link.edge[0] = link.edge[1];
      if (link.edge[0] == link.edge[1]) link.share = 0.0;
    }
    const bool is_same = link.edge[0] == link.edge[1] && link.edge[0] == link.node;
    if (is_same && (i == 0 || i + 1 == from.nodes.size())) continue;  // where both sides start or end
    if (link.edge[0] == link.node || link.edge[1] == link.node) {
      FailOnSeam(NodeText(link.node) + " is in a and in b; expected that at their ends alone");
    }
    links_.push_back(link);
  }
}

void Sewing::AddButton(int a, int b) {
  for (const int node : {a, b}) {
    if (node >= 0 && node < static_cast<int>(now_.size())) continue;
    FailOnSeam(NodeText(node) + ": expected 0 to " + std::to_string(now_.size() - 1));
  }
  if (now_[a] == now_[b]) FailOnSeam("nodes " + std::to_string(a) + " and " + std::to_string(b) + " are the same");
  links_.push_back({a, {b, b}, 0.0, kButtonStiffness, 0.0});
}

void ExpectEvenSeams(const Mesh& mesh, const std::string& source) {
  std::map<std::pair<int, int>, double> lengths;  // of the first side
  for (int face = 0; face < mesh.num_faces(); ++face) {
    for (int side = 0; side < 3; ++side) {
      const double length = RestLength(mesh, face, side);
      const std::pair<int, int> edge = std::minmax(int{mesh.faces(side, face)}, int{mesh.faces((side + 1) % 3, face)});
      const double other = lengths.emplace(edge, length).first->second;
      if (std::abs(length - other) <= kMostEase * std::max(length, other)) continue;
      std::ostringstream text;
      text << "edge " << edge.first << "-" << edge.second << " is " << other << " m long on one side in the UV map and "
           << length << " m on the other, in triangle " << face << "; expected the same within " << 100.0 * kMostEase
           << " %, or \"ease\": true of the mesh";
      FailOnData(source, text.str());
    }
  }
}

void Sewing::Finish() {
  std::vector<int> kept, number(now_.size(), 0);
  for (std::size_t node = 0; node < now_.size(); ++node) {
    if (now_[node] != static_cast<int>(node)) continue;
    number[node] = static_cast<int>(kept.size());
    kept.push_back(static_cast<int>(node));
  }
  const auto renumber = [&](int node) { return number[now_[node]]; };
  mesh_->rest_positions = mesh_->rest_positions(Eigen::all, kept).eval();
  for (int& node : mesh_->faces.reshaped()) node = number[node];
  for (const auto& [a, b] : folds_) {
    const auto [low, high] = std::minmax({renumber(a), renumber(b)});
    mesh_->folds.push_back({low, high});
  }
  for (SeamLink link : links_) {
    link.node = renumber(link.node);
    for (int& node : link.edge) node = renumber(node);
    mesh_->links.push_back(link);
  }
}

}  // namespace clothid
