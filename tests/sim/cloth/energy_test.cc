// Forces and Hessians of stretch, bending and internal damping against differences of the energies.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include "sim/cloth/bending_energy.h"
#include "sim/cloth/strain_rate_damping.h"
#include "sim/cloth/stretch_energy.h"
#include "sim/cloth/triangle_element.h"
#include "sim/matrix/block_matrix.h"
#include "sim/scene/mesh.h"

namespace clothid {
namespace {

class EnergyTest : public ::testing::Test {
 protected:
  EnergyTest() {
    GridOptions grid;
    grid.nodes = {4, 3};
    grid.size = {0.3, 0.2};
    mesh_ = MakeGrid(grid);
    free_index_.resize(mesh_.num_nodes());
    std::iota(free_index_.begin(), free_index_.end(), 0);
    std::vector<int> everyone = free_index_;
    pattern_ = std::make_shared<BlockPattern>(std::vector<std::vector<int>>(mesh_.num_nodes(), everyone));
    triangles_ = std::make_shared<const TriangleElements>(MakeTriangleElements(mesh_, free_index_, *pattern_));
    std::mt19937_64 generator(3);
    std::normal_distribution<double> normal;
    rest_ = mesh_.rest_positions.reshaped();
    positions_ = rest_;
    for (double& x : positions_) x += 0.01 * normal(generator);
    direction_.resize(positions_.size());
    for (double& x : direction_) x = normal(generator);
  }

  Eigen::MatrixXd StretchHessian(HessianKind kind, const Eigen::VectorXd& positions) {
    const StretchEnergy energy(triangles_);
    BlockMatrix hessian(pattern_);
    energy.AddHessian(1.0, kind, positions, &hessian);
    hessian.CompleteFromLower();
    return Eigen::MatrixXd(hessian.view());
  }

  // E/k.
  double StretchValue(const Eigen::VectorXd& positions) {
    Eigen::VectorXd unused = Eigen::VectorXd::Zero(positions.size());
    return StretchEnergy(triangles_).AddForce(1.0, positions, &unused);
  }

  // Of `mesh`, in a matrix that has every block.
  static BendingEnergy Bending(const Mesh& mesh) {
    std::vector<int> everyone(mesh.num_nodes());
    std::iota(everyone.begin(), everyone.end(), 0);
    const BlockPattern pattern(std::vector<std::vector<int>>(mesh.num_nodes(), everyone));
    return BendingEnergy(BendingMatrix(mesh), everyone, pattern);
  }

  Mesh mesh_;
  std::vector<int> free_index_;
  std::shared_ptr<BlockPattern> pattern_;
  std::shared_ptr<const TriangleElements> triangles_;
  Eigen::VectorXd rest_, positions_, direction_;
};

TEST_F(EnergyTest, StretchForceIsTheGradient) {
  const StretchEnergy energy(triangles_);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(positions_.size());
  const double value = energy.AddForce(2.0, positions_, &force);
  EXPECT_DOUBLE_EQ(value, StretchValue(positions_));
  const double step = 1e-6;
  const double difference =
      (StretchValue(positions_ + step * direction_) - StretchValue(positions_ - step * direction_)) / (2.0 * step);
  EXPECT_NEAR(-force.dot(direction_), 2.0 * difference, 1e-7 * std::abs(difference));
}

TEST_F(EnergyTest, StretchHessianIsTheSecondDerivative) {
  const StretchEnergy energy(triangles_);
  const Eigen::MatrixXd hessian = StretchHessian(HessianKind::kExact, positions_);
  EXPECT_LT((hessian - hessian.transpose()).norm(), 1e-13 * hessian.norm());
  const double step = 1e-6;
  Eigen::VectorXd plus = Eigen::VectorXd::Zero(positions_.size()), minus = plus;
  energy.AddForce(1.0, positions_ + step * direction_, &plus);
  energy.AddForce(1.0, positions_ - step * direction_, &minus);
  const Eigen::VectorXd difference = (minus - plus) / (2.0 * step);
  EXPECT_LT((hessian * direction_ - difference).norm(), 1e-7 * difference.norm());
}

TEST_F(EnergyTest, ClampedHessianIsPositiveSemidefiniteInCompression) {
  const Eigen::VectorXd compressed = 0.8 * positions_;
  const auto lowest = [](const Eigen::MatrixXd& matrix) {
    const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix).eigenvalues();
    return values[0] / values[values.size() - 1];
  };
  EXPECT_LT(lowest(StretchHessian(HessianKind::kExact, compressed)), -1e-3);
  EXPECT_GT(lowest(StretchHessian(HessianKind::kClamped, compressed)), -1e-12);
  // In tension nothing is clamped.
  const Eigen::VectorXd stretched = 1.5 * rest_;
  EXPECT_LT((StretchHessian(HessianKind::kExact, stretched) - StretchHessian(HessianKind::kClamped, stretched)).norm(),
            1e-12);
}

TEST_F(EnergyTest, StretchEnergyOfAUniformStretch) {
  // F = diag(1.2, 1): E/k = area (0.2)^2 / 2.
  Eigen::VectorXd stretched = rest_;
  for (Eigen::Index i = 0; i < stretched.size(); i += 3) stretched[i] *= 1.2;
  EXPECT_NEAR(StretchValue(stretched), 0.06 * 0.5 * 0.04, 1e-15);
}

TEST_F(EnergyTest, BendingIgnoresAffineMapsAndMeetsACylinder) {
  const BendingEnergy energy = Bending(mesh_);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(rest_.size());
  EXPECT_NEAR(energy.AddForce(1.0, 1.3 * rest_, &force), 0.0, 1e-13);
  EXPECT_LT(force.norm(), 1e-10);

  // A strip bent gently to radius R. The edges across the strip, a third of all, carry the whole curvature, three times
  // over: on this mesh E is three times the k_b/2 area/R^2 of the continuum (see bending_energy.h).
  GridOptions grid;
  grid.nodes = {81, 5};
  grid.size = {1.0, 0.05};
  const Mesh strip = MakeGrid(grid);
  const BendingEnergy strip_energy = Bending(strip);
  const double radius = 2.0;
  Eigen::VectorXd bent = strip.rest_positions.reshaped();
  for (int node = 0; node < strip.num_nodes(); ++node) {
    const double angle = strip.rest_positions(0, node) / radius;
    bent[3 * node] = radius * std::sin(angle);
    bent[3 * node + 2] = radius * (1.0 - std::cos(angle));
  }
  Eigen::VectorXd unused = Eigen::VectorXd::Zero(bent.size());
  const double expected = 3.0 * 0.5 * 0.05 / (radius * radius);
  EXPECT_NEAR(strip_energy.AddForce(1.0, bent, &unused), expected, 0.02 * expected);
}

TEST_F(EnergyTest, BendingForceIsTheGradient) {
  const BendingEnergy energy = Bending(mesh_);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(positions_.size()), unused = force;
  energy.AddForce(3.0, positions_, &force);
  const double step = 1e-5;
  const double difference = (energy.AddForce(3.0, positions_ + step * direction_, &unused) -
                             energy.AddForce(3.0, positions_ - step * direction_, &unused)) /
                            (2.0 * step);
  EXPECT_NEAR(-force.dot(direction_), 3.0 * difference, 1e-7 * std::abs(3.0 * difference));
}

// A step from x_n = start_ to positions_, in which the cloth is strained, turned and moved.
class DampingTest : public EnergyTest {
 protected:
  DampingTest() : damping_(triangles_) {
    std::mt19937_64 generator(5);
    std::normal_distribution<double> normal;
    start_ = 1.1 * rest_;
    for (double& x : start_) x += 0.01 * normal(generator);
    start_ = Moved(start_, 1.0);
  }

  // `positions` turned by `angle` (rad) about an axis that lies askew, and shifted.
  static Eigen::VectorXd Moved(const Eigen::VectorXd& positions, double angle) {
    const Eigen::Matrix3d rotation =
        Eigen::AngleAxisd(angle, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
    const Eigen::Matrix3Xd x = positions.reshaped(3, positions.size() / 3);
    return ((rotation * x).colwise() + Eigen::Vector3d(0.3, -5.0, 2.0)).reshaped();
  }

  std::vector<MetricBatch> Metrics(const Eigen::VectorXd& positions) const {
    std::vector<MetricBatch> metrics;
    damping_.SetMetrics(positions, &metrics);
    return metrics;
  }

  // The force at `positions` of a step from `start`, for eta = 1; `potential` may be null.
  Eigen::VectorXd Force(const Eigen::VectorXd& start, const Eigen::VectorXd& positions, double* potential) const {
    Eigen::VectorXd force = Eigen::VectorXd::Zero(positions.size());
    const double value = damping_.AddForce(1.0, kTimeStep, Metrics(start), positions, &force);
    if (potential != nullptr) *potential = value;
    return force;
  }

  Eigen::MatrixXd Hessian(HessianKind kind, const Eigen::VectorXd& start, const Eigen::VectorXd& positions) const {
    BlockMatrix hessian(pattern_);
    damping_.AddHessian(1.0, kTimeStep, kind, Metrics(start), positions, &hessian);
    hessian.CompleteFromLower();
    return Eigen::MatrixXd(hessian.view());
  }

  Eigen::MatrixXd MixedProduct(const Eigen::VectorXd& positions, const Eigen::VectorXd& start,
                               const Eigen::MatrixXd& columns) const {
    Eigen::MatrixXd product = Eigen::MatrixXd::Zero(columns.rows(), columns.cols());
    damping_.AddMixedProduct(1.0, kTimeStep, positions, start, columns, &product);
    return product;
  }

  static constexpr double kTimeStep = 0.01;    // s
  static constexpr double kDifference = 1e-6;  // of a position, relative to direction_
  StrainRateDamping damping_;
  Eigen::VectorXd start_;
};

TEST_F(DampingTest, ForceIsTheGradientOfTheDissipationPotential) {
  double plus = 0.0, minus = 0.0;
  Force(start_, positions_ + kDifference * direction_, &plus);
  Force(start_, positions_ - kDifference * direction_, &minus);
  const double difference = (plus - minus) / (2.0 * kDifference);
  EXPECT_NEAR(-Force(start_, positions_, nullptr).dot(direction_), difference, 1e-7 * std::abs(difference));
}

TEST_F(DampingTest, HessianIsTheSecondDerivative) {
  const Eigen::MatrixXd hessian = Hessian(HessianKind::kExact, start_, positions_);
  EXPECT_LT((hessian - hessian.transpose()).norm(), 1e-13 * hessian.norm());
  const Eigen::VectorXd difference = (Force(start_, positions_ - kDifference * direction_, nullptr) -
                                      Force(start_, positions_ + kDifference * direction_, nullptr)) /
                                     (2.0 * kDifference);
  EXPECT_LT((hessian * direction_ - difference).norm(), 1e-7 * difference.norm());
}

TEST_F(DampingTest, MixedProductIsTheDerivativeByTheStart) {
  const Eigen::VectorXd difference = (Force(start_ - kDifference * direction_, positions_, nullptr) -
                                      Force(start_ + kDifference * direction_, positions_, nullptr)) /
                                     (2.0 * kDifference);
  EXPECT_LT((MixedProduct(positions_, start_, direction_) - difference).norm(), 1e-7 * difference.norm());
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(rest_.size(), rest_.size());
  const Eigen::MatrixXd matrix = MixedProduct(positions_, start_, identity);
  EXPECT_GT((matrix - matrix.transpose()).norm(), 1e-3 * matrix.norm());
  EXPECT_LT((MixedProduct(start_, positions_, identity) - matrix.transpose()).norm(), 1e-13 * matrix.norm());
}

TEST_F(DampingTest, RigidMotionOfAnySizeIsFree) {
  const double straining = Force(start_, positions_, nullptr).norm();
  for (const double angle : {1e-3, 0.5, 2.0, 3.1}) {
    double potential = 1.0;
    EXPECT_LT(Force(start_, Moved(start_, angle), &potential).norm(), 1e-12 * straining) << angle;
    EXPECT_LT(potential, 1e-24) << angle;
  }
}

TEST_F(DampingTest, ClampedHessianIsPositiveSemidefinite) {
  const auto lowest = [](const Eigen::MatrixXd& matrix) {
    const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix).eigenvalues();
    return values[0] / values[values.size() - 1];
  };
  const Eigen::VectorXd shrunk = 0.7 * start_;
  EXPECT_LT(lowest(Hessian(HessianKind::kExact, start_, shrunk)), -1e-3);
  EXPECT_GT(lowest(Hessian(HessianKind::kClamped, start_, shrunk)), -1e-12);
  // Where every strain grows nothing is clamped.
  const Eigen::VectorXd grown = 1.3 * start_;
  const Eigen::MatrixXd exact = Hessian(HessianKind::kExact, start_, grown);
  EXPECT_LT((exact - Hessian(HessianKind::kClamped, start_, grown)).norm(), 1e-12 * exact.norm());
}

// F from diag(1, 1) to diag(1.2, 1) in a step: W/eta = area (1.44 - 1)^2/(8 h).
TEST_F(DampingTest, PotentialOfAUniformStretch) {
  Eigen::VectorXd stretched = rest_;
  for (Eigen::Index i = 0; i < stretched.size(); i += 3) stretched[i] *= 1.2;
  double potential = 0.0;
  Force(rest_, stretched, &potential);
  EXPECT_NEAR(potential, 0.06 * 0.44 * 0.44 / (8.0 * kTimeStep), 1e-14);
}

}  // namespace
}  // namespace clothid
