// Internal damping against differences, and a damped cloth against what is known in closed form.
#include "sim/shell/strain_rate_damping.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "sim/scene/parameters.h"
#include "tests/sim/plain_scenes.h"
#include "tests/sim/shell/strained_grid.h"

namespace clothid::strain_rate_damping_test {
namespace {

// A step from x_n = start_ to positions_, in which the cloth is strained, turned and moved.
class StrainRateDampingTest : public StrainedGridTest {
 protected:
  StrainRateDampingTest() : damping_(triangles_) {
    std::mt19937_64 generator(5);
    std::normal_distribution<double> normal;
    start_ = 1.1 * rest_;
    for (double& x : start_) x += 0.01 * normal(generator);
    start_ = Moved(start_, 1.0);
  }

  std::vector<MetricBatch> Metrics(const Eigen::VectorXd& positions) const {
    std::vector<MetricBatch> metrics;
    damping_.SetMetrics({{&positions, 1.0}}, &metrics);
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

TEST_F(StrainRateDampingTest, ForceIsTheGradientOfTheDissipationPotential) {
  double plus = 0.0, minus = 0.0;
  Force(start_, positions_ + kDifference * direction_, &plus);
  Force(start_, positions_ - kDifference * direction_, &minus);
  const double difference = (plus - minus) / (2.0 * kDifference);
  EXPECT_NEAR(-Force(start_, positions_, nullptr).dot(direction_), difference, 1e-7 * std::abs(difference));
}

TEST_F(StrainRateDampingTest, HessianIsTheSecondDerivative) {
  const Eigen::MatrixXd hessian = Hessian(HessianKind::kExact, start_, positions_);
  EXPECT_LT((hessian - hessian.transpose()).norm(), 1e-13 * hessian.norm());
  const Eigen::VectorXd difference = (Force(start_, positions_ - kDifference * direction_, nullptr) -
                                      Force(start_, positions_ + kDifference * direction_, nullptr)) /
                                     (2.0 * kDifference);
  EXPECT_LT((hessian * direction_ - difference).norm(), 1e-7 * difference.norm());
}

TEST_F(StrainRateDampingTest, MixedProductIsTheDerivativeByTheStart) {
  const Eigen::VectorXd difference = (Force(start_ - kDifference * direction_, positions_, nullptr) -
                                      Force(start_ + kDifference * direction_, positions_, nullptr)) /
                                     (2.0 * kDifference);
  EXPECT_LT((MixedProduct(positions_, start_, direction_) - difference).norm(), 1e-7 * difference.norm());
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(rest_.size(), rest_.size());
  const Eigen::MatrixXd matrix = MixedProduct(positions_, start_, identity);
  EXPECT_GT((matrix - matrix.transpose()).norm(), 1e-3 * matrix.norm());
  EXPECT_LT((MixedProduct(start_, positions_, identity) - matrix.transpose()).norm(), 1e-13 * matrix.norm());
}

TEST_F(StrainRateDampingTest, RigidMotionOfAnySizeIsFree) {
  const double straining = Force(start_, positions_, nullptr).norm();
  for (const double angle : {1e-3, 0.5, 2.0, 3.1}) {
    double potential = 1.0;
    EXPECT_LT(Force(start_, Moved(start_, angle), &potential).norm(), 1e-12 * straining) << angle;
    EXPECT_LT(potential, 1e-24) << angle;
  }
}

TEST_F(StrainRateDampingTest, ClampedHessianIsPositiveSemidefinite) {
  const Eigen::VectorXd shrunk = 0.7 * start_;
  EXPECT_LT(LowestEigenvalue(Hessian(HessianKind::kExact, start_, shrunk)), -1e-3);
  EXPECT_GT(LowestEigenvalue(Hessian(HessianKind::kClamped, start_, shrunk)), -1e-12);
  // Where every strain grows nothing is clamped.
  const Eigen::VectorXd grown = 1.3 * start_;
  const Eigen::MatrixXd exact = Hessian(HessianKind::kExact, start_, grown);
  EXPECT_LT((exact - Hessian(HessianKind::kClamped, start_, grown)).norm(), 1e-12 * exact.norm());
}

// F from diag(1, 1) to diag(1.2, 1) in a step: W/eta = area (1.44 - 1)^2/(8 h).
TEST_F(StrainRateDampingTest, PotentialOfAUniformStretch) {
  double potential = 0.0;
  Force(rest_, StretchedAlongX(rest_, 1.2), &potential);
  EXPECT_NEAR(potential, 0.06 * 0.44 * 0.44 / (8.0 * kTimeStep), 1e-14);
}

// Of a sleeve held by its upper rim that oscillates along its axis in its slowest mode, without gravity. Its rings are
// a chain of equal springs and masses, the last mass half as large: z_j = sin(j theta), theta = pi/(2 n) for n springs,
// omega^2 = 4 k/(rho row_height^2) sin^2(theta/2).
struct SleeveOscillation {
  static constexpr int kRings = 9, kRingSize = 6;
  static constexpr double kRowHeight = 0.02;  // m
  static constexpr double kAmplitude = 1e-7;  // m: strains below 1e-6, so that the viscous force is linear to that
  double theta() const { return kPi / (2.0 * (kRings - 1)); }
  double squared_frequency(const Material& material) const {  // omega^2, 1/s^2
    return 4.0 * material.stretch_stiffness / (material.density * kRowHeight * kRowHeight) *
           std::pow(std::sin(0.5 * theta()), 2);
  }

  // The amplitude of the mode at every step, relative to its start.
  std::vector<double> Simulate(const Material& material, double time_step, int num_steps) const {
    Scene scene = ClothScene(SquareGrid(2, 0.1), time_step);
    scene.gravity.setZero();
    scene.material = material;
    PutSleeve(kRings, kRingSize, 0.05, kRowHeight, &scene);
    for (int node = 0; node < kRingSize; ++node) scene.handles.nodes.push_back(node);
    for (int node = kRingSize; node < scene.mesh.num_nodes(); ++node) {
      scene.initial_positions[3 * node + 2] += kAmplitude * std::sin(node / kRingSize * theta());
    }
    const Rollout rollout = SimulateNominal(scene, num_steps);
    std::vector<double> amplitudes;
    for (int step = 0; step <= num_steps; ++step) {  // of the lowest ring
      amplitudes.push_back((rollout.positions(step)[rollout.initial_positions.size() - 1] -
                            scene.mesh.rest_positions(2, scene.mesh.num_nodes() - 1)) /
                           kAmplitude);
    }
    return amplitudes;
  }
};

// The rate at which the maxima of an oscillation decay, 1/s, from its first to its last one. A maximum lies on the
// parabola through three steps.
double DecayRate(const std::vector<double>& values, double time_step) {
  std::vector<double> heights, times;
  for (size_t i = 1; i + 1 < values.size(); ++i) {
    if (values[i] <= values[i - 1] || values[i] < values[i + 1]) continue;
    const double slope = 0.5 * (values[i + 1] - values[i - 1]);
    const double curvature = values[i + 1] - 2.0 * values[i] + values[i - 1];
    times.push_back((static_cast<double>(i) - slope / curvature) * time_step);
    heights.push_back(values[i] - 0.5 * slope * slope / curvature);
  }
  EXPECT_GE(heights.size(), 3u);
  return std::log(heights.front() / heights.back()) / (times.back() - times.front());
}

Material SleeveMaterial(double damping) {
  Material material;
  material.stretch_stiffness = 20.0;
  material.damping = damping;
  return material;
}

// In a mode of small amplitude z: z_{n+1} - 2 z_n + z_{n-1} = -h^2 omega^2 z_{n+1} - h beta (z_{n+1} - z_n) with
// beta = eta/k omega^2, z_{-1} = z_0.
TEST(DampedSleeveTest, SleeveMeetsTheDiscreteFormula) {
  const SleeveOscillation sleeve;
  constexpr double kTimeStep = 0.005;
  for (const double damping : {0.0, 0.05, 2.0, 40.0}) {  // from undamped to creeping
    const Material material = SleeveMaterial(damping);
    const double squared_frequency = sleeve.squared_frequency(material);
    const double viscous = kTimeStep * damping / material.stretch_stiffness * squared_frequency;
    const std::vector<double> amplitudes = sleeve.Simulate(material, kTimeStep, 60);
    double before = 1.0, expected = 1.0;
    for (size_t step = 0; step < amplitudes.size(); ++step) {
      EXPECT_NEAR(amplitudes[step], expected, 1e-6) << "damping " << damping << ", step " << step;
      const double next =
          ((2.0 + viscous) * expected - before) / (1.0 + kTimeStep * kTimeStep * squared_frequency + viscous);
      before = expected;
      expected = next;
    }
  }
}

// The rate eta omega^2/(2 k) of Kelvin-Voigt damping with h omega^2/2 of backward Euler itself added. Each step divides
// the amplitude by sqrt(1 + x), x = h beta + h^2 omega^2, so the rate falls short of x/(2 h) by nearly the share x/2;
// the tolerance is the share x (0.14 % at the finest h here).
TEST(DampedSleeveTest, DecayTendsToTheRateOfKelvinVoigt) {
  const SleeveOscillation sleeve;
  const Material material = SleeveMaterial(0.02);
  const double squared_frequency = sleeve.squared_frequency(material);
  const double kelvin_voigt = 0.5 * material.damping / material.stretch_stiffness * squared_frequency;
  const double period = 2.0 * kPi / std::sqrt(squared_frequency);
  double last_error = 1.0;
  for (const double time_step : {4e-4, 2e-4, 1e-4}) {
    const int num_steps = static_cast<int>(4.5 * period / time_step);
    const double rate = DecayRate(sleeve.Simulate(material, time_step, num_steps), time_step);
    const double expected = kelvin_voigt + 0.5 * time_step * squared_frequency;
    EXPECT_NEAR(rate, expected, 2.0 * time_step * expected * expected) << "h " << time_step;
    const double error = std::abs(rate / kelvin_voigt - 1.0);
    EXPECT_LT(error, 0.6 * last_error) << "h " << time_step;
    last_error = error;
  }
}

}  // namespace
}  // namespace clothid::strain_rate_damping_test
