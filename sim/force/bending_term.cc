#include "sim/force/bending_term.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "sim/scene/material_field.h"
#include "sim/scene/warp.h"
#include "sim/shell/bending_patch.h"

namespace clothid {
namespace {

// Of the law that the scene has.
std::vector<BendingMatrix> MatricesOf(const Scene& scene, const Mesh& chosen_on) {
  if (scene.bending.law == BendingLaw::kEdges) {
    const std::vector<ClampedEdge>& clamped = scene.handles.clamped;
    SlopeBending slopes;
    if (!clamped.empty()) {
      slopes = SumOfSlopes(EdgeBendingElements(scene.mesh, clamped), scene.mesh.num_nodes(),
                           static_cast<int>(clamped.size()), [](const BendingElement&) { return 1.0; });
    }
    return {{ParameterKind::kBendingStiffness, EdgeBendingMatrix(scene.mesh, clamped), {}, std::move(slopes)}};
  }
  const bool orthotropic = scene.bending.orthotropic;
  const BendingPatches patches(scene.mesh,
                               orthotropic ? WarpDirections(scene.warp, scene.mesh) : FirstEdges(scene.mesh),
                               RestOf(scene), chosen_on, scene.handles.clamped);
  const auto term = [&](ParameterKind kind, const FlexuralRigidity& rigidity) -> BendingMatrix {
    return {kind, patches.Matrix(rigidity), patches.Moments(rigidity), patches.Slopes(rigidity)};
  };
  if (!orthotropic) return {term(ParameterKind::kBendingStiffness, IsotropicRigidity(1.0, scene.bending.poisson))};
  const OrthotropicShares shares = SharesOfRigidity(scene.bending.poisson);
  return {term(ParameterKind::kWarpBending, shares.warp), term(ParameterKind::kWeftBending, shares.weft),
          term(ParameterKind::kTwistBending, shares.twist)};
}

bool HasBendingField(const Scene& scene) {
  return std::any_of(scene.fields.begin(), scene.fields.end(),
                     [](const GridField& field) { return RowOf(field.kind).term == ParameterTerm::kBending; });
}

std::shared_ptr<const RestCurvature> MakeCurvature(std::vector<RestMoment> moments, const std::vector<int>& free_index,
                                                   const BlockPattern& pattern) {
  if (moments.empty()) return nullptr;
  return std::make_shared<const RestCurvature>(std::move(moments), free_index, pattern);
}

}  // namespace

BendingMatrices MakeBendingMatrices(const Scene& scene, const Mesh& chosen_on) {
  BendingMatrices parts;
  if (!scene.has_bending()) return parts;
  if (scene.pieces.empty() && !HasBendingField(scene)) {
    parts.matrices = MatricesOf(scene, chosen_on);
    return parts;
  }
  std::vector<ParameterKind> kinds = {ParameterKind::kBendingStiffness};
  if (scene.bending.orthotropic) {
    kinds = {ParameterKind::kWarpBending, ParameterKind::kWeftBending, ParameterKind::kTwistBending};
  }
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(scene.mesh.num_faces());
  for (const ParameterKind kind : kinds) {
    parts.weighted.emplace_back(scene, kind, chosen_on);
    parts.matrices.push_back(parts.weighted.back().Of(ones));
  }
  return parts;
}

std::unique_ptr<BendingTerm> MakeBendingTerm(BendingMatrices* parts, std::size_t place, const Scene& scene,
                                             const std::vector<int>& free_index, const BlockPattern& pattern) {
  std::shared_ptr<const WeightedBending> weighted;
  std::vector<BendingMatrix> pieces;
  if (!parts->weighted.empty()) {
    weighted = std::make_shared<const WeightedBending>(std::move(parts->weighted[place]));
    if (scene.has_of_pieces(weighted->kind())) {
      const int num_pieces = static_cast<int>(scene.mesh.piece_names.size());
      for (int i = 0; i <= num_pieces; ++i) {
        pieces.push_back(weighted->Of(PieceMask(i < num_pieces ? i : kWhole, scene.mesh.face_pieces)));
      }
    }
  }
  return std::make_unique<BendingTerm>(std::move(parts->matrices[place]), std::move(weighted), std::move(pieces),
                                       scene.handles.slopes, free_index, pattern);
}

BendingTerm::BendingTerm(BendingMatrix matrix, std::shared_ptr<const WeightedBending> weighted,
                         std::vector<BendingMatrix> pieces, HandlePath slopes, const std::vector<int>& free_index,
                         const BlockPattern& pattern)
    : kind_(matrix.kind),
      energy_(std::move(matrix.matrix), free_index, pattern),
      curvature_(MakeCurvature(std::move(matrix.moments), free_index, pattern)),
      slopes_(std::move(matrix.slopes)),
      slope_path_(std::move(slopes)),
      weighted_(std::move(weighted)),
      pieces_(std::move(pieces)) {}

double BendingTerm::AddForceTimes(double stiffness, const ForcePoint& point, Eigen::VectorXd* force) const {
  double energy = energy_.AddForce(stiffness, point.positions, force);
  if (curvature_ == nullptr && !HasClamps()) return energy;
  const Eigen::VectorXd slopes = SlopesAt(point.time);
  if (curvature_ != nullptr) energy += curvature_->AddForce(stiffness, point.positions, slopes, force);
  if (HasClamps()) energy += slopes_.AddForce(stiffness, point.positions, slopes, force);
  return energy;
}

void BendingTerm::SetVariation(const ForceVariation& variation) {
  std::optional<Eigen::VectorXd> weights = variation.FieldOf(kind_);
  if (!weights) weights = variation.PiecesOf(kind_);
  if (!weights) return;
  energy_ = BendingEnergy(weighted_->Matrix(*weights), variation.free_index, variation.pattern);
  curvature_ = MakeCurvature(weighted_->Moments(*weights), variation.free_index, variation.pattern);
  slopes_ = weighted_->Slopes(*weights);
}

double BendingTerm::AddForce(const ForcePoint& point, const HeldForce*, Eigen::VectorXd* force) const {
  const double k = stiffness(point.parameters.material);
  return k * AddForceTimes(k, point, force);
}

void BendingTerm::AddPositionHessian(double factor, HessianKind hessian_kind, const ForcePoint& point, const HeldForce*,
                                     BlockMatrix* hessian) const {
  const double k = factor * stiffness(point.parameters.material);
  energy_.AddHessian(k, hessian, point.team);
  if (curvature_ != nullptr) {
    curvature_->AddHessian(k, hessian_kind, point.positions, SlopesAt(point.time), hessian);
  }
}

void BendingTerm::AddSlopeForce(const ForcePoint& point, Eigen::VectorXd* force) const {
  if (!HasClamps()) return;
  const double k = stiffness(point.parameters.material);
  slopes_.AddSlopeForce(k, point.positions, SlopesAt(point.time), force);
  if (curvature_ == nullptr) return;
  for (const RestMoment& moment : curvature_->moments()) AddMomentSlopeForce(moment, k, point.positions, force);
}

void BendingTerm::AddDerivative(ParameterId id, double factor, const ForcePoint& point, const HeldForce*,
                                Eigen::VectorXd* force) const {
  if (id.kind != kind_) return;
  if (pieces_.empty()) {
    AddForceTimes(factor, point, force);
  } else {
    const std::size_t piece = id.part == kWhole ? pieces_.size() - 1 : static_cast<std::size_t>(id.part);
    pieces_[piece].AddForce(factor, point.positions, SlopesAt(point.time), force);
  }
}

void BendingTerm::AddFieldProducts(const FieldFactors& field, double factor, const ForcePoint& point,
                                   const Eigen::MatrixXd& columns, Eigen::Ref<Eigen::MatrixXd> products) const {
  if (field.kind != kind_) return;
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(products.rows(), products.cols());
  weighted_->AddForceProducts(factor * stiffness(point.parameters.material), point.positions, SlopesAt(point.time),
                              columns, unit);
  products += field.log_factors.array().exp().matrix().asDiagonal() * unit;
}

ForceTerm::FieldDirection BendingTerm::AlongField(ParameterKind kind, const Eigen::VectorXd& weights) const {
  if (kind != kind_) return nullptr;
  return [matrix = weighted_->Of(weights), this](double factor, const ForcePoint& point, Eigen::VectorXd* force) {
    matrix.AddForce(factor * point.parameters.material.*RowOf(matrix.kind).constant, point.positions,
                    SlopesAt(point.time), force);
  };
}

std::optional<ForceTerm::ConstantPart> BendingTerm::SystemPart(const Material& material, double time_step) const {
  return ConstantPart{time_step * time_step * stiffness(material), &energy_.matrix(), &energy_.diagonal()};
}

void BendingTerm::VisitCoupled(const std::vector<bool>& is_chosen, const NodeVisitor& visit) const {
  const Eigen::SparseMatrix<double>& matrix = energy_.matrix();
  for (int node = 0; node < matrix.outerSize(); ++node) {
    if (!is_chosen[node]) continue;
    std::vector<int> nodes;
    for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, node); it; ++it) {
      nodes.push_back(static_cast<int>(it.row()));
    }
    visit(std::move(nodes));
  }
  for (int slope = 0; slope < slopes_.by_nodes.outerSize(); ++slope) {
    std::vector<int> nodes;
    bool is_at_chosen = false;
    for (Eigen::SparseMatrix<double>::InnerIterator it(slopes_.by_nodes, slope); it; ++it) {
      nodes.push_back(static_cast<int>(it.row()));
      is_at_chosen = is_at_chosen || is_chosen[nodes.back()];
    }
    if (is_at_chosen) visit(std::move(nodes));
  }
  if (curvature_ == nullptr) return;
  for (const RestMoment& moment : curvature_->moments()) {
    const std::vector<int>& nodes = moment.nodes;
    if (std::any_of(nodes.begin(), nodes.end(), [&](int node) { return is_chosen[node]; })) visit(nodes);
  }
}

std::unique_ptr<ForceTerm> BendingTerm::PartOf(const ForcePart& part) const {
  BendingMatrix matrix{kind_, energy_.matrix(), {}, slopes_};
  if (curvature_ != nullptr) matrix.moments = curvature_->moments();
  std::shared_ptr<const WeightedBending> weighted;
  if (weighted_ != nullptr) weighted = std::make_shared<const WeightedBending>(weighted_->PartOf(part));
  std::vector<BendingMatrix> pieces;
  for (const BendingMatrix& piece : pieces_) pieces.push_back(piece.PartOf(part));
  return std::make_unique<BendingTerm>(matrix.PartOf(part), std::move(weighted), std::move(pieces), slope_path_,
                                       part.blocks, *part.pattern);
}

}  // namespace clothid
