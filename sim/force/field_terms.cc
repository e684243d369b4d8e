#include "sim/force/field_terms.h"

#include <cstddef>
#include <utility>

#include "sim/scene/warp.h"
#include "sim/shell/bending_patch.h"

namespace clothid {
namespace {

// The vectors that `all` has with these numbers [n x 3].
Eigen::MatrixX3d RowsOf(const std::vector<int>& numbers, const double* all) {
  Eigen::MatrixX3d rows(numbers.size(), 3);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    rows.row(static_cast<Eigen::Index>(i)) =
        Eigen::Map<const Eigen::RowVector3d>(all + 3 * static_cast<Eigen::Index>(numbers[i]));
  }
  return rows;
}

// Of an element's nodes, and of its slopes behind them.
Eigen::MatrixX3d ElementRows(const BendingElement& element, const Eigen::VectorXd& positions,
                             const Eigen::VectorXd& slopes) {
  if (element.slopes.empty()) return RowsOf(element.nodes, positions.data());
  Eigen::MatrixX3d rows(element.block.rows(), 3);
  rows << RowsOf(element.nodes, positions.data()), RowsOf(element.slopes, slopes.data());
  return rows;
}

// Per unit of the constant `kind`.
FlexuralRigidity UnitRigidity(ParameterKind kind, double poisson) {
  const OrthotropicShares shares = SharesOfRigidity(poisson);
  if (kind == ParameterKind::kWarpBending) return shares.warp;
  if (kind == ParameterKind::kWeftBending) return shares.weft;
  return kind == ParameterKind::kTwistBending ? shares.twist : IsotropicRigidity(1.0, poisson);
}

// Those of chosen nodes, with the nodes of the part.
std::vector<RestMoment> PartOfMoments(const std::vector<RestMoment>& moments, const ForcePart& part) {
  std::vector<RestMoment> near;
  for (const RestMoment& moment : moments) {
    if (part.Touches(moment.nodes)) near.push_back(moment);
  }
  for (RestMoment& moment : near) {
    for (int& node : moment.nodes) node = part.index[node];
  }
  return near;
}

}  // namespace

std::shared_ptr<const TriangleElements> WeightedTriangles(const TriangleElements& triangles,
                                                          const Eigen::VectorXd& weights) {
  auto weighted = std::make_shared<TriangleElements>(triangles);
  for (Eigen::Index f = 0; f < weights.size(); ++f) {
    (*weighted)[static_cast<std::size_t>(f / kLanes)].area[f % kLanes] *= weights[f];
  }
  return weighted;
}

TriangleElements SelectTriangles(const TriangleElements& triangles, const std::vector<int>& faces) {
  TriangleElements selected((faces.size() + kLanes - 1) / kLanes);
  for (std::size_t i = 0; i < selected.size() * kLanes; ++i) {
    const bool fills = i >= faces.size();
    const auto face = static_cast<std::size_t>(fills ? faces.back() : faces[i]);
    const TriangleBatch& from = triangles[face / kLanes];
    TriangleBatch& batch = selected[i / kLanes];
    const std::size_t source = face % kLanes, lane = i % kLanes;
    batch.area[lane] = fills ? 0.0 : from.area[source];
    for (int corner = 0; corner < 3; ++corner) {
      batch.rows[corner][lane] = from.rows[corner][source];
      if (!fills) batch.blocks[corner][lane] = from.blocks[corner][source];
    }
    for (int k = 0; k < 2; ++k) {
      for (int axis = 0; axis < 2; ++axis) {
        batch.shape_gradients[k][axis][lane] = from.shape_gradients[k][axis][source];
      }
    }
  }
  return selected;
}

Eigen::VectorXd PieceMask(int piece, const std::vector<int>& face_pieces) {
  Eigen::VectorXd mask(static_cast<Eigen::Index>(face_pieces.size()));
  for (std::size_t f = 0; f < face_pieces.size(); ++f) {
    mask[static_cast<Eigen::Index>(f)] = piece == kWhole || face_pieces[f] == piece ? 1.0 : 0.0;
  }
  return mask;
}

Eigen::VectorXd WeightedNodeAreas(const Mesh& mesh, const Eigen::VectorXd& weights) {
  const Eigen::VectorXd thirds = TriangleAreas(mesh).cwiseProduct(weights) / 3.0;
  Eigen::VectorXd areas = Eigen::VectorXd::Zero(mesh.num_nodes());
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int i = 0; i < 3; ++i) areas[mesh.faces(i, f)] += thirds[f];
  }
  return areas;
}

void BendingMatrix::AddForce(double stiffness, const Eigen::VectorXd& positions, const Eigen::VectorXd& slopes_now,
                             Eigen::VectorXd* force) const {
  const Eigen::Index num_nodes = positions.size() / 3;
  // Q is symmetric.
  force->reshaped(3, num_nodes) -= stiffness * (positions.reshaped(3, num_nodes) * matrix);
  for (const RestMoment& moment : moments) AddMomentForce(moment, stiffness, positions, slopes_now, force);
  if (!slopes.is_empty()) slopes.AddForce(stiffness, positions, slopes_now, force);
}

BendingMatrix BendingMatrix::PartOf(const ForcePart& part) const {
  BendingMatrix own{kind, PartOfMatrix(matrix, part), PartOfMoments(moments, part), {}};
  if (slopes.is_empty()) return own;
  std::vector<Eigen::Triplet<double>> entries;
  for (int slope = 0; slope < slopes.by_nodes.outerSize(); ++slope) {
    for (Eigen::SparseMatrix<double>::InnerIterator it(slopes.by_nodes, slope); it; ++it) {
      if (const int node = part.index[it.row()]; node >= 0) entries.emplace_back(node, slope, it.value());
    }
  }
  own.slopes.by_nodes.resize(static_cast<Eigen::Index>(part.nodes.size()), slopes.by_nodes.cols());
  own.slopes.by_nodes.setFromTriplets(entries.begin(), entries.end());
  own.slopes.own = slopes.own;
  return own;
}

WeightedBending WeightedBending::PartOf(const ForcePart& part) const {
  WeightedBending own = *this;
  own.num_nodes_ = static_cast<int>(part.nodes.size());
  own.moments_ = PartOfMoments(moments_, part);
  own.elements_.clear();
  for (const BendingElement& element : elements_) {
    if (!part.Touches(element.nodes)) continue;
    own.elements_.push_back(element);
    for (int& node : own.elements_.back().nodes) node = part.index[node];
  }
  return own;
}

WeightedBending::WeightedBending(const Scene& scene, ParameterKind kind, const Mesh& chosen_on)
    : num_nodes_(scene.mesh.num_nodes()), num_slopes_(static_cast<int>(scene.handles.clamped.size())), kind_(kind) {
  if (scene.bending.law == BendingLaw::kEdges) {
    elements_ = EdgeBendingElements(scene.mesh, scene.handles.clamped);
    return;
  }
  const bool orthotropic = scene.bending.orthotropic;
  const BendingPatches patches(scene.mesh,
                               orthotropic ? WarpDirections(scene.warp, scene.mesh) : FirstEdges(scene.mesh),
                               RestOf(scene), chosen_on, scene.handles.clamped);
  const FlexuralRigidity rigidity = UnitRigidity(kind, scene.bending.poisson);
  elements_ = patches.Elements(rigidity);
  moments_ = patches.Moments(rigidity);
}

Eigen::SparseMatrix<double> WeightedBending::Matrix(const Eigen::VectorXd& weights) const {
  std::vector<Eigen::Triplet<double>> triplets;
  for (const BendingElement& element : elements_) {
    const double weight = weights(element.faces).mean();
    const std::vector<int>& nodes = element.nodes;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      for (std::size_t j = 0; j < nodes.size(); ++j) {
        const auto row = static_cast<Eigen::Index>(i), column = static_cast<Eigen::Index>(j);
        // Both triangles to the last bit the same.
        triplets.emplace_back(nodes[i], nodes[j], weight * element.block(std::max(row, column), std::min(row, column)));
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(num_nodes_, num_nodes_);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

std::vector<RestMoment> WeightedBending::Moments(const Eigen::VectorXd& weights) const {
  std::vector<RestMoment> moments;
  for (const RestMoment& moment : moments_) moments.push_back(moment.Times(weights[moment.face]));
  return moments;
}

SlopeBending WeightedBending::Slopes(const Eigen::VectorXd& weights) const {
  if (num_slopes_ == 0) return {};
  return SumOfSlopes(elements_, num_nodes_, num_slopes_,
                     [&](const BendingElement& element) { return weights(element.faces).mean(); });
}

void WeightedBending::AddForceProducts(double stiffness, const Eigen::VectorXd& positions,
                                       const Eigen::VectorXd& slopes, const Eigen::MatrixXd& columns,
                                       Eigen::Ref<Eigen::MatrixXd> products) const {
  for (const BendingElement& element : elements_) {
    const double share = stiffness / static_cast<double>(element.faces.size());
    const auto num_nodes = static_cast<Eigen::Index>(element.nodes.size());
    const Eigen::MatrixX3d force =
        -share * (element.block.topRows(num_nodes) * ElementRows(element, positions, slopes));
    for (Eigen::Index c = 0; c < columns.cols(); ++c) {
      const double product = force.cwiseProduct(RowsOf(element.nodes, columns.col(c).data())).sum();
      for (const int face : element.faces) products(face, c) += product;
    }
  }
  Eigen::VectorXd force = Eigen::VectorXd::Zero(moments_.empty() ? 0 : positions.size());
  for (const RestMoment& moment : moments_) {
    AddMomentForce(moment, stiffness, positions, slopes, &force);
    for (const int node : moment.nodes) {
      products.row(moment.face) += force.segment<3>(3 * node).transpose() * columns.middleRows<3>(3 * node);
      force.segment<3>(3 * node).setZero();
    }
  }
}

}  // namespace clothid
