#include "sim/shell/edge_slopes.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "sim/geometry/quadratic_fit.h"
#include "sim/shell/mesh_unfolding.h"

namespace clothid {
namespace {

constexpr double kWorstFit = 0.15;      // of `QuadraticFit::quality`: below, more nodes are taken
constexpr double kSameDistance = 1e-9;  // of triangles from the middle of the cloth, relative to its size
constexpr double kExact = 1e-12;        // of the error of a slope, relative to the length of the edge

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

}  // namespace

Eigen::Matrix<double, 3, 2> TriangleAxes(const Mesh& mesh, int face, const Eigen::Vector3d& warp) {
  const auto corner = [&](int k) { return RestCorner(mesh, face, k); };
  const Eigen::Vector3d normal = (corner(1) - corner(0)).cross(corner(2) - corner(1)).normalized();
  Eigen::Matrix<double, 3, 2> axes;
  axes.col(0) = (warp - warp.dot(normal) * normal).normalized();
  axes.col(1) = normal.cross(axes.col(0));
  return axes;
}

Eigen::Matrix2d EdgesIn(const Eigen::Matrix<double, 3, 2>& axes, const Mesh& mesh, int face) {
  const Eigen::Vector3d corner = RestCorner(mesh, face, 0);
  Eigen::Matrix2d edges;
  for (int k = 0; k < 2; ++k) edges.col(k) = axes.transpose() * (RestCorner(mesh, face, k + 1) - corner);
  return edges;
}

GivenSlopes::GivenSlopes(const std::vector<ClampedEdge>& clamped, const Mesh& chosen_on, const Mesh& mesh)
    : clamped_(clamped), chosen_on_(chosen_on), mesh_(mesh) {
  for (std::size_t i = 0; i < clamped.size(); ++i) {
    numbers_[std::minmax(clamped[i].nodes[0], clamped[i].nodes[1])] = static_cast<int>(i);
  }
}

int GivenSlopes::Find(int face, int side) const {
  if (numbers_.empty()) return -1;
  const auto found = numbers_.find(std::minmax(mesh_.faces(side, face), mesh_.faces((side + 1) % 3, face)));
  return found == numbers_.end() ? -1 : found->second;
}

NodeWeights GivenSlopes::Of(int number, int side) const {
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

EdgeSlopes::EdgeSlopes(const Mesh& mesh, const Eigen::VectorXd& areas, const GivenSlopes& given)
    : place_(3, mesh.num_faces()) {
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
      slopes_.push_back(clamped >= 0 ? given.Of(clamped, side) : EdgeSlope(mesh, opposite, face, side, both).Compute());
    }
  }
}

}  // namespace clothid
