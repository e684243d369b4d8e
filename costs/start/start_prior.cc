#include "costs/start/start_prior.h"

#include <Eigen/SparseCholesky>
#include <cmath>
#include <stdexcept>

#include "sim/cloth/triangle_element.h"
#include "sim/matrix/block_product.h"

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
  whole.material.drag = 0.0;
  whole.material.damping = 0.0;
  return whole;
}

// The stretch energy has a factor area, so that a sum over triangles has the mean area in its weight.
double StretchWeight(double strain, double mean_area) { return 1.0 / (strain * strain * mean_area); }
double BendingWeight(double angle) { return 1.0 / (3.0 * angle * angle); }

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
  const double stretch = StretchWeight(kStrain, mean_area_), bending = BendingWeight(kAngle);
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
      TimesHessian(StretchWeight(kStrainRate, mean_area_), BendingWeight(kAngleRate), base_positions, directions);
  const Eigen::Index n = directions.cols();
  prior->precision.block(first, first, n, n) += directions.transpose() * product;
  prior->information.segment(first, n) -= product.transpose() * base;
}

Eigen::MatrixXd ShapePrior::HandleResponse(const RecordedMotion& motion) const {
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
  all += BendingWeight(kAngle) * model_.bending()->matrix();
  const Eigen::VectorXd weights = PointWeights(motion);
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixXd right =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(free.size()), static_cast<Eigen::Index>(handles.size()));
  for (std::size_t i = 0; i < free.size(); ++i) {
    const auto row = static_cast<int>(i);
    entries.emplace_back(row, row, weights[free[i]]);
    for (Eigen::SparseMatrix<double>::InnerIterator it(all, free[i]); it; ++it) {
      const int other = place[it.row()];
      if (other >= 0) {
        entries.emplace_back(other, row, it.value());
      } else {
        right(row, -1 - other) -= it.value();
      }
    }
  }
  const auto size = static_cast<Eigen::Index>(free.size());
  Eigen::SparseMatrix<double> matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
  if (factor.info() != Eigen::Success) throw std::runtime_error("the handles hold no part of the cloth");
  const Eigen::MatrixXd solution = factor.solve(right);
  Eigen::MatrixXd response = Eigen::MatrixXd::Zero(num_nodes, right.cols());
  for (std::size_t i = 0; i < free.size(); ++i) response.row(free[i]) = solution.row(static_cast<Eigen::Index>(i));
  for (std::size_t i = 0; i < handles.size(); ++i) response(handles[i], static_cast<Eigen::Index>(i)) = 1.0;
  return response;
}

void AddHandleMeasurements(const HandleMeasurements& measured, const Eigen::MatrixXd& weights, Eigen::Index first,
                           QuadraticPrior* prior) {
  const Eigen::Index num_rows = measured.deviations.rows(), num_knots = weights.cols();
  for (Eigen::Index row = 0; row < num_rows; ++row) {
    const double sigma = measured.sigma[row / 3];
    for (Eigen::Index k = 0; k < measured.times.size(); ++k) {
      const double deviation = measured.deviations(row, k);
      if (!std::isfinite(deviation)) continue;
      for (Eigen::Index a = 0; a < num_knots; ++a) {
        const Eigen::Index place = first + a * num_rows + row;
        const double share = weights(k, a) / (sigma * sigma);
        prior->information[place] += share * deviation;
        for (Eigen::Index b = 0; b < num_knots; ++b) {
          prior->precision(place, first + b * num_rows + row) += share * weights(k, b);
        }
      }
    }
  }
}

}  // namespace clothid
