#include "sim/force/damping_term.h"

#include <optional>
#include <utility>

#include "sim/force/field_terms.h"

namespace clothid {
namespace {

struct HeldMetrics final : HeldForce {
  std::vector<MetricBatch> metrics;
};

const std::vector<MetricBatch>& MetricsOf(const HeldForce* held) {
  return static_cast<const HeldMetrics*>(held)->metrics;
}

}  // namespace

DampingTerm::DampingTerm(std::shared_ptr<const TriangleElements> triangles, std::vector<int> face_pieces)
    : triangles_(std::move(triangles)), face_pieces_(std::move(face_pieces)), damping_(triangles_) {}

void DampingTerm::SetVariation(const ForceVariation& variation) {
  std::optional<Eigen::VectorXd> weights = variation.PiecesOf(ParameterKind::kDamping);
  if (!weights) return;
  weights_ = std::move(*weights);
  damping_ = StrainRateDamping(WeightedTriangles(*triangles_, weights_));
}

void DampingTerm::Hold(const Parameters&, double, const ForceStart& start, std::unique_ptr<HeldForce>* held) const {
  if (*held == nullptr) *held = std::make_unique<HeldMetrics>();
  damping_.SetMetrics(start.origins, &static_cast<HeldMetrics*>(held->get())->metrics);
}

double DampingTerm::AddForce(const ForcePoint& point, const HeldForce* held, Eigen::VectorXd* force) const {
  const double damping = point.parameters.material.damping;
  return damping * damping_.AddForce(damping, point.time_step, MetricsOf(held), point.positions, force);
}

void DampingTerm::AddPositionHessian(double factor, HessianKind kind, const ForcePoint& point, const HeldForce* held,
                                     BlockMatrix* hessian) const {
  damping_.AddHessian(factor * point.parameters.material.damping, point.time_step, kind, MetricsOf(held),
                      point.positions, hessian, point.team);
}

void DampingTerm::AddOriginProduct(double factor, const ForcePoint& point, const Eigen::VectorXd& origin,
                                   const Eigen::MatrixXd& columns, Eigen::MatrixXd* product) const {
  damping_.AddMixedProduct(factor * point.parameters.material.damping, point.time_step, point.positions, origin,
                           columns, product);
}

void DampingTerm::AddOriginProductTransposed(double factor, const ForcePoint& point, const Eigen::VectorXd& origin,
                                             const Eigen::MatrixXd& columns, Eigen::MatrixXd* product) const {
  damping_.AddMixedProduct(factor * point.parameters.material.damping, point.time_step, origin, point.positions,
                           columns, product);
}

void DampingTerm::AddDerivative(ParameterId id, double factor, const ForcePoint& point, const HeldForce* held,
                                Eigen::VectorXd* force) const {
  if (id.kind != ParameterKind::kDamping) return;
  if (face_pieces_.empty()) {
    damping_.AddForce(factor, point.time_step, MetricsOf(held), point.positions, force);
  } else {
    const StrainRateDamping unit(WeightedTriangles(*triangles_, PieceMask(id.part, face_pieces_)));
    unit.AddForce(factor, point.time_step, MetricsOf(held), point.positions, force);
  }
}

double DampingTerm::LaplacianWeight(const Material& material, double time_step) const {
  return time_step * material.damping;
}

std::unique_ptr<ForceTerm> DampingTerm::PartOf(const ForcePart& part) const {
  std::vector<int> face_pieces;
  for (const int face : part.faces) {
    if (!face_pieces_.empty()) face_pieces.push_back(face_pieces_[static_cast<std::size_t>(face)]);
  }
  auto own = std::make_unique<DampingTerm>(part.triangles, std::move(face_pieces));
  if (weights_.size() == 0) return own;
  own->weights_ = weights_(part.faces);
  own->damping_ = StrainRateDamping(WeightedTriangles(*own->triangles_, own->weights_));
  return own;
}

}  // namespace clothid
