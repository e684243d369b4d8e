#include "sim/shell/bending_patch.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "sim/shell/edge_slopes.h"

namespace clothid {
namespace {

constexpr double kCancelled = 1e-13;  // of an entry of Q, relative to what it is a sum of

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
