// Internal damping against what is known in closed form, and the factor common to all constants.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "sim/scene/parameters.h"
#include "tests/sim/plain_scenes.h"

namespace clothid {
namespace {

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
TEST(InternalDampingTest, SleeveMeetsTheDiscreteFormula) {
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
TEST(InternalDampingTest, DecayTendsToTheRateOfKelvinVoigt) {
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

// Multiplying k, k_b, density, drag and damping by one factor multiplies every term of a step but leaves its root.
// A factor of 4 does so without any rounding.
TEST(ScalingTest, ACommonFactorOfAllConstantsIsInvisibleWithoutContact) {
  GridOptions grid = SquareGrid(6, 0.3);
  Scene scene = ClothScene(grid, 0.01);
  scene.handles.nodes = {0, 5};
  scene.wind.gust = Eigen::Vector3d(0.0, 3.0, 1.0);
  scene.wind.frequency = 9.0;
  scene.material = {0.2, 80.0, 1e-3, 0.3, 0.4};
  constexpr int kNumSteps = 40;
  const Eigen::VectorXd positions = SimulateNominal(scene, kNumSteps).positions(kNumSteps);
  const auto scaled = [&](double factor) {
    Scene heavier = scene;
    Material& material = heavier.material;
    for (double* constant : {&material.density, &material.stretch_stiffness, &material.bending_stiffness,
                             &material.drag, &material.damping}) {
      *constant *= factor;
    }
    return SimulateNominal(heavier, kNumSteps).positions(kNumSteps);
  };
  EXPECT_EQ(scaled(4.0), positions);
  EXPECT_LT((scaled(3.0) - positions).norm(), 1e-9 * positions.norm());
  // It is all of them that must change together.
  scene.material.damping *= 3.0;
  EXPECT_GT((SimulateNominal(scene, kNumSteps).positions(kNumSteps) - positions).norm(), 1e-5 * positions.norm());
}

}  // namespace
}  // namespace clothid
