#include "sim/shell/bending_patch.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>
#include <utility>

#include "sim/geometry/quadratic_fit.h"
#include "sim/shell/mesh_unfolding.h"

namespace clothid {
namespace {

constexpr double kWorstFit = 0.15;      // of `QuadraticFit::quality`: below, more nodes are taken
constexpr double kSameDistance = 1e-9;  // of triangles from the middle of the cloth, relative to its size
constexpr double kExact = 1e-12;        // of the error of a slope, relative to the length of the edge
constexpr double kCancelled = 1e-13;    // of an entry of Q, relative to what it is a sum of

// Of the middles of triangles from that of the cloth [F], relative to its size: with a rest place per corner those of
// the nodes' positions, in which pieces lie as they are sewn.
Eigen::VectorXd DistancesFromCentre(const Mesh& mesh, const Eigen::VectorXd& areas) {
  Eigen::Matrix3Xd middles(3, mesh.num_faces());
  for (int face = 0; face < mesh.num_faces(); ++face) {
    middles.col(face).setZero();
    for (int i = 0; i < 3; ++i) middles.col(face) += mesh.rest_positions.col(mesh.faces(i, face)) / 3.0;
  }
  const Eigen::Vector3d centre = middles * areas / areas.sum();
  return (middles.colwise() - centre).colwise().norm() / std::sqrt(areas.sum());
}

// A linear function of the nodes and, at a clamped edge, of the slope there.
struct NodeWeights {
  std::vector<int> nodes;
  Eigen::VectorXd weights;
  int slope = -1;  // the number of the edge, -1: none
  double slope_weight = 0.0;
};

// The slope at the middle of an edge, across it and towards its first triangle. Nodes of that side tell what the slopes
// of the two triangles miss, where `both` is true those of either side.
class EdgeSlope {
 public:
  EdgeSlope(const Mesh& mesh, const Eigen::Matrix3Xi& opposite, int face, int side, bool both)
      : around_(mesh, opposite, face, side), both_(both) {}

  NodeWeights Compute() {
    const Eigen::Matrix2Xd p = around_.Positions();
    Eigen::VectorXd slope = TriangleSlope(p, 2);
    if (p.cols() == 4) {  // else a border, or the back of the same three nodes
      const double height = p(1, 2), depth = -p(1, 3);
      slope = (depth * slope + height * TriangleSlope(p, 3)) / (height + depth);
    }
    const double length = p(0, 1) - p(0, 0);
    const Eigen::Vector3d missed = QuadraticTerms(p) * slope;  // the slope of each term at the origin is 0
    if (missed.lpNorm<Eigen::Infinity>() <= kExact * length) return {around_.nodes(), slope};
    const Eigen::Matrix3Xd derivatives = FitAround();
    Eigen::VectorXd all = -derivatives.transpose() * missed;
    all.head(slope.size()) += slope;
    return {around_.nodes(), all};
  }

 private:
  // Of the triangle over the edge with its apex at node `apex`.
  static Eigen::VectorXd TriangleSlope(const Eigen::Matrix2Xd& p, Eigen::Index apex) {
    Eigen::VectorXd slope = Eigen::VectorXd::Zero(p.cols());
    const double share = (p(0, apex) - p(0, 0)) / (p(0, 1) - p(0, 0));
    slope[apex] = 1.0 / p(1, apex);
    slope[0] = -(1.0 - share) / p(1, apex);
    slope[1] = -share / p(1, apex);
    return slope;
  }

  // [3 x n] x^2/2, y^2/2, x y.
  static Eigen::Matrix3Xd QuadraticTerms(const Eigen::Matrix2Xd& p) {
    Eigen::Matrix3Xd terms(3, p.cols());
    terms.row(0) = 0.5 * p.row(0).cwiseAbs2();
    terms.row(1) = 0.5 * p.row(1).cwiseAbs2();
    terms.row(2) = p.row(0).cwiseProduct(p.row(1));
    return terms;
  }

  // Of the second derivatives, from the nodes around [3 x n]. Where those of the neighbours leave one open, as at a
  // border, they are joined by the nodes that tell most.
  Eigen::Matrix3Xd FitAround() {
    around_.AddNeighboursOf(0);
    if (both_ || Quality(AllNumbers()) < kWorstFit) around_.AddNeighboursOf(1);
    std::vector<int> chosen = AllNumbers();
    if (Quality(chosen) < kWorstFit) {
      around_.AddTouching();
      while (Quality(chosen) < kWorstFit && AddMostTelling(&chosen)) continue;
    }
    const Eigen::Matrix2Xd p = around_.Positions();
    Eigen::Matrix3Xd weights = Eigen::Matrix3Xd::Zero(3, p.cols());
    weights(Eigen::all, chosen) = QuadraticFit(p(Eigen::all, chosen)).Weights();
    return weights;
  }

  std::vector<int> AllNumbers() const {
    std::vector<int> numbers(around_.nodes().size());
    std::iota(numbers.begin(), numbers.end(), 0);
    return numbers;
  }

  // Of a fit to the nodes with these numbers in `around_`.
  double Quality(const std::vector<int>& numbers) const {
    constexpr std::size_t kTerms = 6;  // of a quadratic
    return numbers.size() < kTerms ? 0.0 : QuadraticFit(around_.Positions()(Eigen::all, numbers)).quality();
  }

  // One node, or several that tell as much. False where all are there.
  bool AddMostTelling(std::vector<int>* chosen) const {
    constexpr double kAsMuch = 1e-6;
    std::vector<int> best;
    double most = -1.0;
    for (const int number : AllNumbers()) {
      if (std::find(chosen->begin(), chosen->end(), number) != chosen->end()) continue;
      std::vector<int> with = *chosen;
      with.push_back(number);
      const double quality = Quality(with);
      if (quality > most + kAsMuch) best.clear();
      if (quality >= most - kAsMuch) best.push_back(number);
      most = std::max(most, quality);
    }
    chosen->insert(chosen->end(), best.begin(), best.end());
    return !best.empty();
  }

  MeshUnfolding around_;
  const bool both_;
};

// Along `warp` in the plane of a triangle, and a right angle further [3 x 2].
Eigen::Matrix<double, 3, 2> TriangleAxes(const Mesh& mesh, int face, const Eigen::Vector3d& warp) {
  const auto corner = [&](int k) { return RestCorner(mesh, face, k); };
  const Eigen::Vector3d normal = (corner(1) - corner(0)).cross(corner(2) - corner(1)).normalized();
  Eigen::Matrix<double, 3, 2> axes;
  axes.col(0) = (warp - warp.dot(normal) * normal).normalized();
  axes.col(1) = normal.cross(axes.col(0));
  return axes;
}

// Two edges of a triangle in axes of it [2 x 2].
Eigen::Matrix2d EdgesIn(const Eigen::Matrix<double, 3, 2>& axes, const Mesh& mesh, int face) {
  const Eigen::Vector3d corner = RestCorner(mesh, face, 0);
  Eigen::Matrix2d edges;
  for (int k = 0; k < 2; ++k) edges.col(k) = axes.transpose() * (RestCorner(mesh, face, k + 1) - corner);
  return edges;
}

// The slopes at clamped edges, on one mesh as they are given on another: A takes the direction across the edge there to
// alpha of that across it here, and beta along it.
class GivenSlopes {
 public:
  GivenSlopes(const std::vector<ClampedEdge>& clamped, const Mesh& chosen_on, const Mesh& mesh)
      : clamped_(clamped), chosen_on_(chosen_on), mesh_(mesh) {
    for (std::size_t i = 0; i < clamped.size(); ++i) {
      numbers_[std::minmax(clamped[i].nodes[0], clamped[i].nodes[1])] = static_cast<int>(i);
    }
  }

  // Of the edge `side` of `face`; -1: it is not clamped.
  int Find(int face, int side) const {
    if (numbers_.empty()) return -1;
    const auto found = numbers_.find(std::minmax(mesh_.faces(side, face), mesh_.faces((side + 1) % 3, face)));
    return found == numbers_.end() ? -1 : found->second;
  }
  int face(int number) const { return clamped_[static_cast<std::size_t>(number)].face; }

  // Into the triangle of the edge.
  NodeWeights Of(int number, int side) const {
    if (&mesh_ == &chosen_on_) return {{}, {}, number, 1.0};
    const auto edge = [&](const Mesh& mesh) {
      return (RestCorner(mesh, face(number), (side + 1) % 3) - RestCorner(mesh, face(number), side)).eval();
    };
    const auto edges = [&](const Mesh& mesh) {
      return EdgesIn(TriangleAxes(mesh, face(number), edge(mesh)), mesh, face(number));
    };
    const Eigen::Vector2d across = edges(mesh_) * edges(chosen_on_).inverse().col(1);
    const double along = across[0] / edge(mesh_).norm();
    return {{mesh_.faces((side + 1) % 3, face(number)), mesh_.faces(side, face(number))},
            Eigen::Vector2d(along, -along),
            number,
            across[1]};
  }

 private:
  const std::vector<ClampedEdge>& clamped_;
  const Mesh &chosen_on_, &mesh_;
  std::map<std::pair<int, int>, int> numbers_;  // of edges (low, high)
};

// The slopes of all edges. Which triangle of an edge is the first depends neither on numbers nor on axes: the one
// nearer to the middle of the cloth. Of a clamped edge it is the one that leaves the clamp.
class EdgeSlopes {
 public:
  EdgeSlopes(const Mesh& mesh, const Eigen::VectorXd& areas, const GivenSlopes& given) : place_(3, mesh.num_faces()) {
    const Eigen::Matrix3Xi opposite = OppositeFaces(mesh);
    const Eigen::VectorXd distances = DistancesFromCentre(mesh, areas);
    for (int face = 0; face < mesh.num_faces(); ++face) {
      for (int side = 0; side < 3; ++side) {
        const int other = opposite(side, face), clamped = given.Find(face, side);
        const double difference = other < 0 ? -1.0 : distances[face] - distances[other];
        const bool both = std::abs(difference) <= kSameDistance;
        const bool is_second = clamped >= 0 ? face != given.face(clamped) : both ? face > other : difference > 0.0;
        if (is_second) continue;
        place_(side, face) = static_cast<int>(slopes_.size());
        if (other >= 0) {
          int other_side = 0;  // the one that ends where this one starts
          while (mesh.faces((other_side + 1) % 3, other) != mesh.faces(side, face)) ++other_side;
          place_(other_side, other) = -1 - place_(side, face);
        }
        slopes_.push_back(clamped >= 0 ? given.Of(clamped, side)
                                       : EdgeSlope(mesh, opposite, face, side, both).Compute());
      }
    }
  }

  // The slope out of the face is `sign` times `slope`.
  const NodeWeights& slope(int face, int side) const {
    const int place = place_(side, face);
    return slopes_[static_cast<std::size_t>(place >= 0 ? place : -1 - place)];
  }
  double sign(int face, int side) const { return place_(side, face) >= 0 ? -1.0 : 1.0; }

 private:
  Eigen::Matrix3Xi place_;  // [3 x F] in slopes_; of the second triangle -1 - place
  std::vector<NodeWeights> slopes_;
};

// Sums rows over nodes.
class PatchBuilder {
 public:
  explicit PatchBuilder(const Eigen::Vector3i& nodes) : nodes_(nodes.begin(), nodes.end()) {}

  void Add(int node, const Eigen::Vector3d& weights) {
    if (weights.isZero(0.0)) return;
    const auto place = static_cast<std::size_t>(std::find(nodes_.begin(), nodes_.end(), node) - nodes_.begin());
    if (place == nodes_.size()) nodes_.push_back(node);
    columns_.resize(nodes_.size(), Eigen::Vector3d::Zero());
    columns_[place] += weights;
  }

  // At most once for each.
  void AddSlope(int slope, const Eigen::Vector3d& weights) {
    slopes_.push_back(slope);
    slope_columns_.push_back(weights);
  }

  BendingPatch Build(double area) const {
    BendingPatch patch;
    patch.area = area;
    patch.nodes = nodes_;
    patch.weights.setZero(3, static_cast<Eigen::Index>(nodes_.size()));
    for (std::size_t i = 0; i < columns_.size(); ++i) patch.weights.col(static_cast<Eigen::Index>(i)) = columns_[i];
    patch.slopes = slopes_;
    patch.slope_weights.resize(3, static_cast<Eigen::Index>(slopes_.size()));
    for (std::size_t i = 0; i < slopes_.size(); ++i) {
      patch.slope_weights.col(static_cast<Eigen::Index>(i)) = slope_columns_[i];
    }
    return patch;
  }

 private:
  std::vector<int> nodes_, slopes_;
  std::vector<Eigen::Vector3d> columns_, slope_columns_;
};

// (11, 22, 12) of the symmetric part of a b^T.
Eigen::Vector3d SymmetricProduct(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return {a[0] * b[0], a[1] * b[1], 0.5 * (a[0] * b[1] + a[1] * b[0])};
}

// Takes a patch along from one mesh to another: with y = A x in the triangle, d2/dy2 = A^-T d2/dx2 A^-1.
void TakeAlong(const Mesh& from, const Eigen::Vector3d& from_axis, const Mesh& to, const Eigen::Vector3d& to_axis,
               int face, BendingPatch* patch) {
  const Eigen::Matrix2d edges = EdgesIn(TriangleAxes(to, face, to_axis), to, face);
  const Eigen::Matrix2d before = EdgesIn(TriangleAxes(from, face, from_axis), from, face);
  const Eigen::Matrix2d inverse = before * edges.inverse();  // A^-1
  Eigen::Matrix3d change;                                    // of (11, 22, 12)
  for (int k = 0; k < 3; ++k) {
    const int a = k == 1 ? 1 : 0, b = k == 0 ? 0 : 1;
    change.row(k) << inverse(0, a) * inverse(0, b), inverse(1, a) * inverse(1, b),
        inverse(0, a) * inverse(1, b) + inverse(1, a) * inverse(0, b);
  }
  patch->weights = (change * patch->weights).eval();
  patch->slope_weights = (change * patch->slope_weights).eval();
  patch->area *= std::abs(edges.determinant() / before.determinant());
}

// The mean second derivatives over a triangle: a sum over its edges of length (normal out) (gradient)^T over the area.
BendingPatch MakePatch(const Mesh& mesh, int face, double area, const Eigen::Vector3d& warp, const EdgeSlopes& slopes) {
  const Eigen::Vector3i nodes = mesh.faces.col(face);
  const auto edge = [&](int side) -> Eigen::Vector3d {
    return RestCorner(mesh, face, (side + 1) % 3) - RestCorner(mesh, face, side);
  };
  const Eigen::Matrix<double, 3, 2> axes = TriangleAxes(mesh, face, warp);
  PatchBuilder builder(nodes);
  for (int side = 0; side < 3; ++side) {
    const Eigen::Vector2d along(axes.col(0).dot(edge(side)), axes.col(1).dot(edge(side)));
    const Eigen::Vector2d tangent = along.normalized(), out(tangent.y(), -tangent.x());
    const Eigen::Vector3d of_tangent = SymmetricProduct(out, tangent) / area;
    builder.Add(nodes[(side + 1) % 3], of_tangent);
    builder.Add(nodes[side], -of_tangent);
    const Eigen::Vector3d of_slope = slopes.sign(face, side) * along.norm() / area * SymmetricProduct(out, out);
    const NodeWeights& slope = slopes.slope(face, side);
    for (std::size_t i = 0; i < slope.nodes.size(); ++i) {
      builder.Add(slope.nodes[i], slope.weights[static_cast<Eigen::Index>(i)] * of_slope);
    }
    if (slope.slope >= 0) builder.AddSlope(slope.slope, slope.slope_weight * of_slope);
  }
  return builder.Build(area);
}

// Gives the patch the curvature at rest, with its slopes there [3 x C], and takes the part of h along the triangle off
// its weights.
void KeepCurvature(const Mesh& mesh, const Eigen::Matrix3Xd& slopes, BendingPatch* patch) {
  const Eigen::Matrix3Xd positions = mesh.rest_positions(Eigen::all, patch->nodes);
  Eigen::Matrix3d at_rest = patch->weights * positions.transpose();  // rows h_ab
  if (!patch->slopes.empty()) at_rest += patch->slope_weights * slopes(Eigen::all, patch->slopes).transpose();
  const auto edge = [&](int side) { return positions.col((side + 1) % 3) - positions.col(side); };
  const Eigen::Vector3d normal = edge(0).cross(edge(1)).normalized();
  patch->curvature = at_rest * normal;
  const Eigen::Matrix3d along = at_rest - patch->curvature * normal.transpose();
  for (int k = 0; k < 3; ++k) {
    patch->weights.col(k) -= along * normal.cross(edge((k + 1) % 3)) / (2.0 * patch->area);
  }
}

// The energy is a/2 times this between (h11, h22, h12) and itself.
Eigen::Matrix3d RigidityMatrix(const FlexuralRigidity& rigidity) {
  return Eigen::Matrix3d{
      {rigidity.d11, rigidity.d12, 0.0}, {rigidity.d12, rigidity.d22, 0.0}, {0.0, 0.0, 4.0 * rigidity.d66}};
}

// Of its nodes, and of its slopes if it has some.
Eigen::MatrixXd PatchBlock(const BendingPatch& patch, const Eigen::Matrix3d& rigidity) {
  if (patch.slopes.empty()) return patch.area * patch.weights.transpose() * rigidity * patch.weights;
  Eigen::Matrix3Xd all(3, patch.weights.cols() + patch.slope_weights.cols());
  all << patch.weights, patch.slope_weights;
  return patch.area * all.transpose() * rigidity * all;
}

}  // namespace

OrthotropicShares SharesOfRigidity(double poisson) {
  return {{1.0, 0.0, 0.5 * poisson, 0.0}, {0.0, 1.0, 0.5 * poisson, 0.0}, {0.0, 0.0, 0.0, 1.0}};
}

FlexuralRigidity IsotropicRigidity(double rigidity, double poisson) {
  return {rigidity, rigidity, poisson * rigidity, 0.5 * (1.0 - poisson) * rigidity};
}

BendingPatches::BendingPatches(const Mesh& mesh, const Eigen::Matrix3Xd& warp, BendingRest rest)
    : BendingPatches(mesh, warp, rest, mesh) {}

BendingPatches::BendingPatches(const Mesh& mesh, const Eigen::Matrix3Xd& warp, BendingRest rest, const Mesh& chosen_on,
                               const std::vector<ClampedEdge>& clamped)
    : num_nodes_(mesh.num_nodes()), num_slopes_(static_cast<int>(clamped.size())), rest_(rest) {
  const Eigen::VectorXd areas = TriangleAreas(chosen_on);
  const EdgeSlopes slopes(chosen_on, areas, GivenSlopes(clamped, chosen_on, mesh));
  const Eigen::Matrix3Xd rest_slopes = RestSlopes(mesh, clamped);
  const bool is_other = chosen_on.rest_positions != mesh.rest_positions || chosen_on.corner_rest != mesh.corner_rest;
  const Eigen::Matrix3Xd axes = is_other ? FirstEdges(chosen_on) : warp;
  patches_.reserve(static_cast<std::size_t>(mesh.num_faces()));
  for (int face = 0; face < mesh.num_faces(); ++face) {
    patches_.push_back(MakePatch(chosen_on, face, areas[face], axes.col(face), slopes));
    if (is_other) TakeAlong(chosen_on, axes.col(face), mesh, warp.col(face), face, &patches_.back());
    if (rest == BendingRest::kMesh) KeepCurvature(mesh, rest_slopes, &patches_.back());
  }
}

Eigen::SparseMatrix<double> BendingPatches::Matrix(const FlexuralRigidity& rigidity) const {
  const Eigen::Matrix3d d = RigidityMatrix(rigidity);
  const double largest = d.lpNorm<Eigen::Infinity>();
  Eigen::VectorXd bounds = Eigen::VectorXd::Zero(num_nodes_);  // of the diagonal, as a sum of positive terms
  std::vector<Eigen::Triplet<double>> triplets;
  for (const BendingPatch& patch : patches_) {
    const Eigen::MatrixXd block = PatchBlock(patch, d);
    for (std::size_t i = 0; i < patch.nodes.size(); ++i) {
      bounds[patch.nodes[i]] += largest * patch.area * patch.weights.col(i).squaredNorm();
      for (std::size_t j = 0; j < patch.nodes.size(); ++j) {
        if (patch.nodes[i] >= patch.nodes[j]) triplets.emplace_back(patch.nodes[i], patch.nodes[j], block(i, j));
      }
    }
  }
  Eigen::SparseMatrix<double> lower(num_nodes_, num_nodes_);
  lower.setFromTriplets(triplets.begin(), triplets.end());
  lower.prune([&](Eigen::Index row, Eigen::Index column, double value) {
    return row == column || std::abs(value) > kCancelled * std::sqrt(bounds[row] * bounds[column]);
  });
  return lower.selfadjointView<Eigen::Lower>();
}

std::vector<BendingElement> BendingPatches::Elements(const FlexuralRigidity& rigidity) const {
  const Eigen::Matrix3d d = RigidityMatrix(rigidity);
  std::vector<BendingElement> elements;
  for (const BendingPatch& patch : patches_) {
    elements.push_back({patch.nodes, {static_cast<int>(elements.size())}, patch.slopes, PatchBlock(patch, d)});
  }
  return elements;
}

SlopeBending BendingPatches::Slopes(const FlexuralRigidity& rigidity) const {
  if (num_slopes_ == 0) return {};
  return SumOfSlopes(Elements(rigidity), num_nodes_, num_slopes_, [](const BendingElement&) { return 1.0; });
}

std::vector<RestMoment> BendingPatches::Moments(const FlexuralRigidity& rigidity) const {
  const Eigen::Matrix3d d = RigidityMatrix(rigidity);
  std::vector<RestMoment> moments;
  if (rest_ == BendingRest::kFlat) return moments;
  for (const BendingPatch& patch : patches_) {
    const Eigen::Vector3d moment = patch.area * d * patch.curvature;
    const int face = static_cast<int>(moments.size());
    moments.push_back({face, patch.nodes, patch.weights.transpose() * moment, patch.curvature.dot(moment), patch.slopes,
                       patch.slope_weights.transpose() * moment});
  }
  return moments;
}

BendingRest RestOf(const Scene& scene) {
  const bool is_flat = scene.bending.law == BendingLaw::kEdges || scene.bending.is_flat_at_rest ||
                       scene.mesh.has_corner_rest() || IsFlat(scene.mesh);
  return is_flat ? BendingRest::kFlat : BendingRest::kMesh;
}

Eigen::Matrix3Xd FirstEdges(const Mesh& mesh) {
  Eigen::Matrix3Xd edges(3, mesh.num_faces());
  for (int f = 0; f < mesh.num_faces(); ++f) {
    edges.col(f) = RestCorner(mesh, f, 1) - RestCorner(mesh, f, 0);
  }
  return edges;
}

}  // namespace clothid
