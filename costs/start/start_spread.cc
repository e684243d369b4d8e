#include "costs/start/start_spread.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "costs/start/smooth_modes.h"
#include "costs/start/start_prior.h"
#include "costs/start/unknown_start.h"
#include "sim/matrix/dense.h"

namespace clothid {
namespace {

// t >= 0 with sum 1/(lambda_i + t) = `variance`, by bisection of log t; 0 where the sum is less without it.
double RidgeFor(const Eigen::VectorXd& lambda, double variance) {
  const auto sum = [&](double t) { return (lambda.array() + t).inverse().sum(); };
  const auto size = static_cast<double>(lambda.size());
  double low = std::log(1e-12 * size / variance), high = std::log(size / variance);
  if (sum(std::exp(low)) <= variance) return 0.0;
  constexpr int kHalvings = 60;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (sum(std::exp(middle)) > variance ? low : high) = middle;
  }
  return std::exp(high);
}

// A of `along` [3N x n] and P [n x n].
Eigen::MatrixXd RootFor(const Eigen::MatrixXd& along, const Eigen::MatrixXd& precision, double deviation) {
  const Eigen::Index size = along.cols();
  if (size == 0 || !(deviation > 0.0)) return Eigen::MatrixXd::Zero(size, size);
  const double num_moving = static_cast<double>((along.rowwise().squaredNorm().array() > 0.0).count());
  const Spectrum mass = SymmetricSpectrum(Eigen::MatrixXd(along.transpose() * along / num_moving));  // M
  if (!(mass.values[0] > 0.0)) throw std::runtime_error("the spread of a start has no modes");
  const Eigen::MatrixXd inverse_root = mass.vectors * mass.values.cwiseSqrt().cwiseInverse().asDiagonal();
  const Spectrum modes = SymmetricSpectrum(Eigen::MatrixXd(inverse_root.transpose() * precision * inverse_root));
  const double variance = deviation * deviation;
  const Eigen::VectorXd lambda = modes.values.cwiseMax(0.0);
  const Eigen::ArrayXd parts = (lambda.array() + RidgeFor(lambda, variance)).inverse();
  return inverse_root * modes.vectors * (parts * (variance / parts.sum())).sqrt().matrix().asDiagonal();
}

}  // namespace

StartSpread::StartSpread(const Scene& scene, double position, double velocity) {
  const ShapePrior shape(scene);
  along_ = AlongAxes(SmoothModes(shape.model(), scene.handles.nodes, kPositionModes));
  const Eigen::Index n = along_.cols(), m = std::min<Eigen::Index>(3 * kVelocityModes, n);
  QuadraticPrior positions{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n)};
  shape.AddPositions(scene.initial_positions, along_, 0, &positions);
  position_root_ = RootFor(along_, positions.precision, position);
  QuadraticPrior velocities{Eigen::MatrixXd::Zero(m, m), Eigen::VectorXd::Zero(m)};
  shape.AddVelocities(scene.initial_positions, scene.initial_velocities, along_.leftCols(m), 0, &velocities);
  velocity_root_ = RootFor(along_.leftCols(m), velocities.precision, velocity);
}

}  // namespace clothid
