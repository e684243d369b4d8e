#include "costs/start/start_prior.h"

#include <Eigen/SparseCholesky>
#include <cmath>
#include <stdexcept>

#include "sim/matrix/block_product.h"
#include "sim/matrix/dense.h"
#include "sim/shell/triangle_element.h"

namespace clothid {
namespace {

// Standard deviations of the strain of a triangle and of the angle between two, and of their rates.
constexpr double kStrain = 0.03, kAngle = 0.1;
constexpr double kStrainRate = 0.6, kAngleRate = 6.0;  // 1/s

Scene WholeCloth(const Scene& scene) {
  Scene whole;
  whole.mesh = scene.mesh;
  whole.initial_positions = scene.initial_positions;
  whole.initial_velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
  whole.material.bending_stiffness = 1.0;
  whole.bending.law = scene.bending.law;
  whole.bending.is_flat_at_rest = true;
  whole.material.drag = 0.0;
  whole.material.damping = 0.0;
  return whole;
}

// The stretch energy has a factor area, so that a sum over triangles has the mean area in its weight.
double StretchWeight(double strain, double mean_area) { return 1.0 / (strain * strain * mean_area); }
// The energy by edges of a bent cloth is three times that by patches.
double BendingWeight(double angle, BendingLaw law) {
  return 1.0 / ((law == BendingLaw::kEdges ? 3.0 : 1.0) * angle * angle);
}

// Of the tracked points, per node: 1/m^2.
Eigen::VectorXd PointWeights(const RecordedMotion& motion) {
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(motion.scene.mesh.num_nodes());
  if (motion.sigma.size() == 0) return weights;
  for (int p = 0; p < motion.num_points(); ++p) {
    if (!std::isfinite(motion.positions(3 * p, 0))) continue;
    const ObservedPoint& point = motion.points[p];
    for (int k = 0; k < point.num_nodes; ++k) {
      weights[point.nodes[k]] += point.weights[k] / (motion.sigma[p] * motion.sigma[p]);
    }
  }
  return weights;
}

}  // namespace

ShapePrior::ShapePrior(const Scene& scene) : scene_(WholeCloth(scene)), model_(scene_) {
  mean_area_ = TriangleAreas(scene.mesh).mean();
}

Eigen::MatrixXd ShapePrior::TimesHessian(double stretch, double bending, const Eigen::VectorXd& positions,
                                         const Eigen::MatrixXd& columns) const {
  BlockMatrix hessian(model_.pattern());
  hessian.values.setZero();
  model_.stretch().AddHessian(stretch, HessianKind::kClamped, positions, &hessian);
  model_.bending()->AddHessian(bending, &hessian);
  hessian.CompleteFromLower();
  return model_.ScatterColumns(MultiplySymmetric(hessian, model_.GatherColumns(columns)));
}

void ShapePrior::AddPositions(const Eigen::VectorXd& base, const Eigen::MatrixXd& directions, Eigen::Index first,
                              QuadraticPrior* prior) const {
  const double stretch = StretchWeight(kStrain, mean_area_), bending = BendingWeight(kAngle, scene_.bending.law);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(base.size());
  model_.stretch().AddForce(stretch, base, &force);
  model_.bending()->AddForce(bending, base, &force);
  const Eigen::Index n = directions.cols();
  prior->precision.block(first, first, n, n) +=
      directions.transpose() * TimesHessian(stretch, bending, base, directions);
  prior->information.segment(first, n) += directions.transpose() * force;
}

void ShapePrior::AddVelocities(const Eigen::VectorXd& base_positions, const Eigen::VectorXd& base,
                               const Eigen::MatrixXd& directions, Eigen::Index first, QuadraticPrior* prior) const {
  const Eigen::MatrixXd product =
      TimesHessian(StretchWeight(kStrainRate, mean_area_), BendingWeight(kAngleRate, scene_.bending.law),
                   base_positions, directions);
  const Eigen::Index n = directions.cols();
  prior->precision.block(first, first, n, n) += directions.transpose() * product;
  prior->information.segment(first, n) -= product.transpose() * base;
}

Eigen::MatrixXd HandleCoupling::SmoothestOffsets(Eigen::Index count) const {
  if (count >= stiffness.rows()) return Eigen::MatrixXd::Identity(stiffness.rows(), stiffness.rows());
  return SymmetricSpectrum(stiffness).vectors.leftCols(count);
}

HandleCoupling ShapePrior::CoupleHandles(const RecordedMotion& motion) const {
  const std::vector<int>& handles = motion.scene.handles.nodes;
  const int num_nodes = model_.num_nodes();
  std::vector<int> place(static_cast<std::size_t>(num_nodes), 0), free;  // of a handle -1 - its number
  for (std::size_t i = 0; i < handles.size(); ++i) place[handles[i]] = -1 - static_cast<int>(i);
  for (int node = 0; node < num_nodes; ++node) {
    if (place[node] < 0) continue;
    place[node] = static_cast<int>(free.size());
    free.push_back(node);
  }
  Eigen::SparseMatrix<double> all = StretchWeight(kStrain, mean_area_) * LaplacianMatrix(model_.triangles(), num_nodes);
  all += BendingWeight(kAngle, scene_.bending.law) * model_.bending()->matrix();
  const Eigen::VectorXd weights = PointWeights(motion);
  const auto num_free = static_cast<Eigen::Index>(free.size()), num_handles = static_cast<Eigen::Index>(handles.size());
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixXd toward = Eigen::MatrixXd::Zero(num_free, num_handles);  // A_fh
  for (Eigen::Index i = 0; i < num_free; ++i) {
    const auto row = static_cast<int>(i);
    entries.emplace_back(row, row, weights[free[row]]);
    for (Eigen::SparseMatrix<double>::InnerIterator it(all, free[row]); it; ++it) {
      const int other = place[it.row()];
      if (other >= 0) {
        entries.emplace_back(other, row, it.value());
      } else {
        toward(row, -1 - other) += it.value();
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(num_free, num_free);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
  if (factor.info() != Eigen::Success) throw std::runtime_error("the handles hold no part of the cloth");
  const Eigen::MatrixXd solution = -factor.solve(toward);
  HandleCoupling coupling;
  coupling.response = Eigen::MatrixXd::Zero(num_nodes, num_handles);
  coupling.response(free, Eigen::all) = solution;
  coupling.stiffness = toward.transpose() * solution;
  for (Eigen::Index i = 0; i < num_handles; ++i) {
    coupling.response(handles[i], i) = 1.0;
    for (Eigen::Index j = 0; j < num_handles; ++j) coupling.stiffness(i, j) += all.coeff(handles[i], handles[j]);
  }
  return coupling;
}

void AddHandleMeasurements(const HandleMeasurements& measured, const Eigen::MatrixXd& weights,
                           const Eigen::MatrixXd& along, Eigen::Index first, QuadraticPrior* prior) {
  const Eigen::Index num_rows = measured.deviations.rows(), num_knots = weights.cols(), n = along.cols();
  for (Eigen::Index row = 0; row < num_rows; ++row) {
    const double sigma = measured.sigma[row / 3];
    const Eigen::MatrixXd values = along(Eigen::seqN(row, num_knots, num_rows), Eigen::all);  // [B x n] of this row
    Eigen::MatrixXd precision = Eigen::MatrixXd::Zero(num_knots, num_knots);
    Eigen::VectorXd information = Eigen::VectorXd::Zero(num_knots);
    for (Eigen::Index k = 0; k < measured.times.size(); ++k) {
      const double deviation = measured.deviations(row, k);
      if (!std::isfinite(deviation)) continue;
      precision += weights.row(k).transpose() * weights.row(k) / (sigma * sigma);
      information += weights.row(k).transpose() * (deviation / (sigma * sigma));
    }
    prior->precision.block(first, first, n, n) += values.transpose() * precision * values;
    prior->information.segment(first, n) += values.transpose() * information;
  }
}

}  // namespace clothid
