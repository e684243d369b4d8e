#include "sim/contact/self_contact_search.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace clothid {
namespace {

using Eigen::Vector3d;

constexpr double kInside = 1e-6;           // share of an edge or face from which on a point is inside
constexpr double kParallel = 1e-4;         // sin^2 of edges that have no closest points
constexpr double kConeMargin = 0.05;       // rad, of one of two edges, ...
constexpr double kLeastConeMargin = 1e-3;  // ... and of the other one
constexpr double kJoinedMargin = 0.1;      // rad, added at faces that the other edge is joined to
// Cones that are narrower than twice those margins, as in flat cloth, hold no direction.
const double kConeCosine = -std::cos(1.99 * kConeMargin), kLeastConeCosine = -std::cos(1.99 * kLeastConeMargin);
constexpr double kMarginOfReach = 0.25;  // of the thickness

// Of the projection of x to the plane through a, b, c: the weights of a, b, c. Not finite in a triangle without area.
Vector3d Barycentric(const Vector3d& x, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d to_b = b - a, to_c = c - a, to_x = x - a;
  const double bb = to_b.squaredNorm(), bc = to_b.dot(to_c), cc = to_c.squaredNorm();
  const double xb = to_x.dot(to_b), xc = to_x.dot(to_c), det = bb * cc - bc * bc;
  const double at_b = (cc * xb - bc * xc) / det, at_c = (bb * xc - bc * xb) / det;
  return {1.0 - at_b - at_c, at_b, at_c};
}

bool IsInside(double share) { return share > kInside && share < 1.0 - kInside; }

// The part of `direction` across an edge, as a unit vector.
Vector3d Across(const Vector3d& edge, const Vector3d& direction) {
  return (direction - direction.dot(edge) / edge.squaredNorm() * edge).normalized();
}

PairFeatures VertexVertex(int a, int b) { return {PairKind::kVertexVertex, {std::min(a, b), std::max(a, b), -1, -1}}; }

}  // namespace

// Everything that holds for one call.
struct SelfContactSearch::Search {
  const SelfContactSearch& cloth;
  const Eigen::VectorXd& positions;
  double reach;  // of cloth at rest
  std::vector<PairFeatures>* pairs;

  auto Position(int node) const { return positions.segment<3>(3 * node); }

  template <class Nodes>
  double FurtherReach(const Nodes& nodes) const {
    double most = 0.0;
    for (const int node : nodes) most = std::max(most, cloth.node_reach_[node]);
    return most;
  }

  template <class Nodes>
  BoxTree::Box Box(const Nodes& nodes) const {
    BoxTree::Box box;
    for (const int node : nodes) box.extend(Vector3d(Position(node)));
    const Vector3d margin = Vector3d::Constant(0.5 * reach + FurtherReach(nodes));
    return {box.min() - margin, box.max() + margin};
  }

  template <class Nodes, class OtherNodes>
  void Add(const Nodes& nodes, const OtherNodes& others, double squared_distance, const PairFeatures& pair) const {
    const double most = reach + FurtherReach(nodes) + FurtherReach(others);
    if (!(squared_distance > 0.0 && squared_distance <= most * most)) return;
    for (const int node : nodes) {
      for (const int other : others) {
        if (cloth.neighbours_.Contains(node, other)) return;
      }
    }
    pairs->push_back(pair);
  }

  void TestFace(int node, int face) const;
  void TestSide(int node, const Edge& edge) const;
  void TestCorner(int node, int corner) const;
  void TestEdges(const Edge& first, const Edge& second) const;

  double ConeCosine(const Edge& edge) const;
  double ConeMargin(const Edge& edge, const Vector3d& direction, const Edge& other) const;
};

// Edges and corners that several faces share are looked at with the first of these alone.
void SelfContactSearch::Search::TestFace(int node, int face) const {
  const auto corners = cloth.faces_.col(face);
  if ((corners.array() == node).any()) return;
  const Vector3d x = Position(node);
  const Vector3d a = Position(corners[0]), b = Position(corners[1]), c = Position(corners[2]);
  const Vector3d weights = Barycentric(x, a, b, c);
  if ((weights.array() > kInside).all()) {
    std::array<int, 3> nodes = {corners[0], corners[1], corners[2]};
    std::sort(nodes.begin(), nodes.end());
    const Vector3d offset = x - weights[0] * a - weights[1] * b - weights[2] * c;
    Add(std::array{node}, nodes, offset.squaredNorm(), {PairKind::kVertexFace, {node, nodes[0], nodes[1], nodes[2]}});
    return;
  }
  for (int k = 0; k < 3; ++k) {
    const Edge& edge = cloth.edges_[cloth.face_edges_(k, face)];
    if (edge.faces[0] == face && !(weights[(k + 2) % 3] > kInside)) TestSide(node, edge);
    if (cloth.node_faces_[corners[k]] == face) TestCorner(node, corners[k]);
  }
}

void SelfContactSearch::Search::TestSide(int node, const Edge& edge) const {
  const auto [a, b] = edge.nodes;
  const Vector3d x = Position(node), from = Position(a), along = Position(b) - from;
  const double share = (x - from).dot(along) / along.squaredNorm();
  if (!IsInside(share)) return;
  for (const int opposite : edge.opposite) {
    if (opposite >= 0 && Barycentric(x, from, from + along, Position(opposite))[2] > kInside) return;
  }
  Add(std::array{node}, edge.nodes, (x - from - share * along).squaredNorm(),
      {PairKind::kVertexEdge, {node, a, b, -1}});
}

void SelfContactSearch::Search::TestCorner(int node, int corner) const {
  const Vector3d from = Position(corner), offset = Position(node) - from;
  for (int i = cloth.first_node_edge_[corner]; i < cloth.first_node_edge_[corner + 1]; ++i) {
    const auto [a, b] = cloth.edges_[cloth.node_edges_[i]].nodes;
    const Vector3d along = Position(a + b - corner) - from;
    if (offset.dot(along) > kInside * along.squaredNorm()) return;
  }
  Add(std::array{node}, std::array{corner}, offset.squaredNorm(), VertexVertex(node, corner));
}

void SelfContactSearch::Search::TestEdges(const Edge& first, const Edge& second) const {
  const Vector3d from = Position(first.nodes[0]), along = Position(first.nodes[1]) - from;
  const Vector3d other_from = Position(second.nodes[0]), other_along = Position(second.nodes[1]) - other_from;
  const Vector3d between = other_from - from;
  const double aa = along.squaredNorm(), ab = along.dot(other_along), bb = other_along.squaredNorm();
  const double det = aa * bb - ab * ab;
  if (!(det > kParallel * aa * bb)) return;
  const double at_a = between.dot(along), at_b = between.dot(other_along);
  const double share = (bb * at_a - ab * at_b) / det, other_share = (ab * at_a - aa * at_b) / det;
  if (!IsInside(share) || !IsInside(other_share)) return;
  const Vector3d offset = share * along - between - other_share * other_along;
  const double margin = ConeMargin(first, -offset, second), other_margin = ConeMargin(second, offset, first);
  if (!(std::min(margin, other_margin) > kLeastConeMargin && std::max(margin, other_margin) > kConeMargin)) return;
  const auto [a, b] = first.nodes;
  const auto [c, d] = second.nodes;
  Add(first.nodes, second.nodes, offset.squaredNorm(), {PairKind::kEdgeEdge, {a, b, c, d}});
}

// The angle from `direction` to the nearer border of the normal cone; negative outside.
double SelfContactSearch::Search::ConeMargin(const Edge& edge, const Vector3d& direction, const Edge& other) const {
  const Vector3d from = Position(edge.nodes[0]), along = Position(edge.nodes[1]) - from;
  const Vector3d outward = -direction.normalized();
  double margin = 0.5 * M_PI;
  for (const int opposite : edge.opposite) {
    if (opposite < 0) continue;
    const bool is_joined = opposite == other.nodes[0] || opposite == other.nodes[1];
    const double sine = std::clamp(outward.dot(Across(along, Position(opposite) - from)), -1.0, 1.0);
    margin = std::min(margin, std::asin(sine) + (is_joined ? kJoinedMargin : 0.0));
  }
  return margin;
}

// -cos of the angle around the normal cone; of a border as if that were as wide as can be.
double SelfContactSearch::Search::ConeCosine(const Edge& edge) const {
  if (edge.opposite[1] < 0) return 1.0;
  const Vector3d from = Position(edge.nodes[0]), along = Position(edge.nodes[1]) - from;
  const Vector3d inward = Across(along, Position(edge.opposite[0]) - from);
  return inward.dot(Across(along, Position(edge.opposite[1]) - from));
}

SelfContactSearch::SelfContactSearch(const Mesh& mesh, double thickness)
    : reach_((1.0 + kMarginOfReach) * thickness),
      faces_(mesh.faces),
      neighbours_(mesh, 2.0 * thickness),
      node_reach_(mesh.num_nodes(), 0.0),
      normals_(mesh.num_faces()),
      places_(mesh.num_faces()),
      normal_boxes_(mesh.num_faces()),
      face_boxes_(mesh.num_faces()) {
  CollectEdges();
  CollectEdgesOfNodes();
  CollectRings();
  const Eigen::VectorXd positions = mesh.rest_positions.reshaped();
  const Search at_rest = {*this, positions, 0.0, nullptr};
  for (int f = 0; f < mesh.num_faces(); ++f) face_boxes_[f] = at_rest.Box(Eigen::Vector3i(faces_.col(f)));
  for (const Edge& edge : edges_) edge_boxes_.push_back(at_rest.Box(edge.nodes));
  face_tree_ = BoxTree(face_boxes_);
  edge_tree_ = BoxTree(edge_boxes_);
}

void SelfContactSearch::CollectEdges() {
  std::vector<std::array<int, 4>> sides;  // low, high, face, side
  for (int f = 0; f < static_cast<int>(faces_.cols()); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int a = faces_(k, f), b = faces_((k + 1) % 3, f);
      sides.push_back({std::min(a, b), std::max(a, b), f, k});
    }
  }
  std::sort(sides.begin(), sides.end());
  face_edges_.resize(3, faces_.cols());
  for (const auto& [low, high, face, side] : sides) {
    const std::array<int, 2> nodes = {low, high};
    const bool is_second = !edges_.empty() && edges_.back().nodes == nodes;
    if (!is_second) edges_.push_back({nodes});
    edges_.back().opposite[is_second] = faces_((side + 2) % 3, face);
    edges_.back().faces[is_second] = face;
    face_edges_(side, face) = static_cast<int>(edges_.size()) - 1;
  }
}

void SelfContactSearch::CollectEdgesOfNodes() {
  std::vector<std::vector<int>> edges_of(node_reach_.size());
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    for (const int node : edges_[i].nodes) edges_of[node].push_back(static_cast<int>(i));
  }
  first_node_edge_.assign(1, 0);
  for (const std::vector<int>& edges : edges_of) {
    node_edges_.insert(node_edges_.end(), edges.begin(), edges.end());
    first_node_edge_.push_back(static_cast<int>(node_edges_.size()));
  }
  node_faces_.assign(node_reach_.size(), 0);
  for (int f = static_cast<int>(faces_.cols()) - 1; f >= 0; --f) {
    for (const int node : faces_.col(f)) node_faces_[node] = f;
  }
}

void SelfContactSearch::CollectRings() {
  first_ring_.assign(1, 0);
  for (int f = 0; f < static_cast<int>(faces_.cols()); ++f) {
    std::vector<int> ring = {f};
    const auto add = [&ring](const Edge& edge) { ring.insert(ring.end(), edge.faces.begin(), edge.faces.end()); };
    for (int k = 0; k < 3; ++k) {
      const Edge& side = edges_[face_edges_(k, f)];
      if (side.faces[0] == f) add(side);
      const int node = faces_(k, f);
      if (node_faces_[node] != f) continue;
      for (int i = first_node_edge_[node]; i < first_node_edge_[node + 1]; ++i) add(edges_[node_edges_[i]]);
    }
    std::sort(ring.begin(), ring.end());
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    if (ring.front() >= 0) rings_.insert(rings_.end(), ring.begin(), ring.end());
    first_ring_.push_back(static_cast<int>(rings_.size()));
  }
}

void SelfContactSearch::PlaceFaces(const Search& search) {
  for (std::size_t f = 0; f < normals_.size(); ++f) {
    const Eigen::Vector3i nodes = faces_.col(static_cast<Eigen::Index>(f));
    const Vector3d a = search.Position(nodes[0]), b = search.Position(nodes[1]), c = search.Position(nodes[2]);
    normals_[f] = (b - a).cross(c - a).normalized();
    places_[f] = BoxTree::Box(a).extend(b).extend(c);
    face_boxes_[f] = search.Box(nodes);
  }
  for (std::size_t f = 0; f < normals_.size(); ++f) {
    normal_boxes_[f].setEmpty();
    for (int i = first_ring_[f]; i < first_ring_[f + 1]; ++i) normal_boxes_[f].extend(normals_[rings_[i]]);
    if (first_ring_[f] == first_ring_[f + 1]) normal_boxes_[f] = BoxTree::Box(-Vector3d::Ones(), Vector3d::Ones());
  }
  face_tree_.Refit(face_boxes_);
  cones_.Refit(face_tree_, places_, normal_boxes_);
}

void SelfContactSearch::PlaceEdges(const Search& search) {
  sharp_edges_.clear();
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const double cosine = search.ConeCosine(edges_[i]);
    edge_boxes_[i] = cosine >= kLeastConeCosine ? search.Box(edges_[i].nodes) : BoxTree::Box();
    if (cosine >= kConeCosine) sharp_edges_.push_back(static_cast<int>(i));
  }
  edge_tree_.Refit(edge_boxes_);
}

void SelfContactSearch::Find(const Eigen::VectorXd& positions, const Eigen::VectorXd& velocities, double gap_time,
                             double further_reach, std::vector<PairFeatures>* pairs) {
  pairs->clear();
  const Search search = {*this, positions, reach_ + further_reach, pairs};
  for (std::size_t i = 0; i < node_reach_.size(); ++i) {
    node_reach_[i] = gap_time * velocities.segment<3>(3 * static_cast<Eigen::Index>(i)).norm();
  }
  PlaceFaces(search);
  for (int node = 0; node < static_cast<int>(node_reach_.size()); ++node) {
    const Vector3d x = search.Position(node);
    face_tree_.VisitOverlaps(
        search.Box(std::array{node}), [&](int tree_node) { return cones_.MayHoldClosest(tree_node, x); },
        [&](int face) { search.TestFace(node, face); });
  }
  PlaceEdges(search);
  for (const int i : sharp_edges_) {
    edge_tree_.VisitOverlaps(edge_boxes_[i], [&](int other) {
      if (other != i) search.TestEdges(edges_[std::min(i, other)], edges_[std::max(i, other)]);
    });
  }
  std::sort(pairs->begin(), pairs->end());
  pairs->erase(std::unique(pairs->begin(), pairs->end()), pairs->end());
}

double SelfContactSearch::LeastDistance(const Eigen::VectorXd& positions) {
  std::vector<PairFeatures> pairs;
  Find(positions, Eigen::VectorXd::Zero(positions.size()), 0.0, 0.0, &pairs);
  double least = reach_;
  for (const PairFeatures& pair : pairs) least = std::min(least, EvaluatePair(pair, positions).distance);
  return least;
}

}  // namespace clothid
