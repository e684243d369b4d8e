// Derivatives of random small scenes, along random directions: adjoint = sensitivity = central differences.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "sim/derivative/adjoint.h"
#include "sim/derivative/sensitivity.h"
#include "sim/mesh/mesh.h"
#include "sim/rollout/simulator.h"
#include "tests/sim/derivative/same_branches.h"
#include "tests/sim/property_seeds.h"
#include "tests/sim/random_numbers.h"
#include "tests/sim/random_scene.h"

namespace clothid::random_gradient_test {
namespace {

// A random linear functional of the trajectory, L = sum over steps of w_n . x_n, and a random direction u in the space
// of a random choice of parameters, x_0 and v_0, in which each is changed by about its own size.
class RandomDerivative {
 public:
  RandomDerivative(std::uint64_t seed, double step_tolerance, Integrator integrator = Integrator::kEuler)
      : random_(seed), scene_(MakeRandomScene(seed)) {
    scene_.scene.integrator = integrator;
    scene_.scene.solver.step_tolerance = step_tolerance;
    const Eigen::Index size = scene().initial_positions.size();
    parameters_ = scene().nominal_parameters();
    ChooseParameters();
    parameter_direction_ = random_.InCube(static_cast<Eigen::Index>(ids_.size()));
    for (std::size_t i = 0; i < ids_.size(); ++i) parameter_direction_[i] *= GetParameter(parameters_, ids_[i]);
    position_direction_ = 0.1 * ClothSize(scene().mesh) * random_.InCube(size);
    velocity_direction_ = random_.InCube(size);
    for (const int handle : scene().handles.nodes) {
      position_direction_.segment<3>(3 * handle).setZero();
      velocity_direction_.segment<3>(3 * handle).setZero();
    }
    for (int step = 0; step <= scene().num_steps(); ++step) weights_.push_back(random_.InCube(size));
  }

  const Scene& scene() const { return scene_.scene; }
  const std::string& description() const { return scene_.description; }

  Rollout Run(double step, Simulator* simulator) const {
    Parameters parameters = parameters_;
    for (std::size_t i = 0; i < ids_.size(); ++i) {
      SetParameter(ids_[i], GetParameter(parameters_, ids_[i]) + step * parameter_direction_[i], &parameters);
    }
    return Simulate(parameters, scene().num_steps(), simulator);
  }

  // (S^T w) . u
  double ByAdjoint(const Rollout& rollout, const AdjointOptions& options, Simulator* simulator) const {
    const auto seeds = [this](int step, Eigen::MatrixXd* gradient) { gradient->col(0) += weights_[step]; };
    const RolloutGradient gradient = PullBack(rollout, ids_, 1, seeds, simulator, options);
    return parameter_direction_.dot(gradient.parameters.col(0)) +
           position_direction_.dot(gradient.initial_positions.col(0)) +
           velocity_direction_.dot(gradient.initial_velocities.col(0));
  }

  // w . (S u), and the sum of the sizes of its terms, against which rounding is to be seen.
  double BySensitivity(Simulator* simulator, double* size) const {
    const SensitivityDirections directions{ids_, position_direction_, velocity_direction_, {}};
    Eigen::VectorXd direction(parameter_direction_.size() + 1);
    direction << parameter_direction_, 1.0;
    return Sweep(directions, direction, simulator, size);
  }

  // Central differences along u where they settle: those of two neighbouring step sizes agree, and both sides of each
  // run through the contacts of `rollout`. NaN where they do not.
  double ByDifferences(const Rollout& rollout) const {
    double settled = std::numeric_limits<double>::quiet_NaN(), smallest_change = kSettled, last = settled;
    for (const double step : {1e-3, 2e-4, 4e-5, 8e-6, 1.6e-6}) {
      const double difference = Difference(rollout, step);
      const double change = std::abs(difference - last) / std::abs(difference);
      if (change < smallest_change) {
        smallest_change = change;
        settled = difference;
      }
      last = difference;
    }
    return settled;
  }

 private:
  static constexpr double kSettled = 2e-7;

  void ChooseParameters() {
    const Material& material = scene().material;
    std::vector<ParameterId> all = {{ParameterKind::kStretchStiffness}, {ParameterKind::kDensity}};
    if (material.bending_stiffness > 0.0) all.push_back({ParameterKind::kBendingStiffness});
    if (material.drag > 0.0) all.push_back({ParameterKind::kDrag});
    if (material.normal_drag > 0.0) all.push_back({ParameterKind::kNormalDrag});
    if (material.tangential_drag > 0.0) all.push_back({ParameterKind::kTangentialDrag});
    if (material.added_mass > 0.0) all.push_back({ParameterKind::kAddedMass});
    if (scene().has_wind()) all.push_back({ParameterKind::kWind, 1});
    if (material.damping > 0.0) all.push_back({ParameterKind::kDamping});
    for (std::size_t i = 0; i < scene().obstacles.size(); ++i) {
      if (scene().obstacles[i].friction_coefficient > 0.0) {
        all.push_back({ParameterKind::kFriction, 0, static_cast<int>(i)});
      }
    }
    for (const int i : random_.Permutation(static_cast<int>(all.size()))) {
      if (ids_.empty() || random_.Chance(0.5)) ids_.push_back(all[i]);
    }
  }

  double Value(const Rollout& rollout) const {
    double value = 0.0;
    for (int step = 0; step <= rollout.num_steps(); ++step) value += weights_[step].dot(rollout.positions(step));
    return value;
  }

  double Sweep(const SensitivityDirections& directions, const Eigen::VectorXd& direction, Simulator* simulator,
               double* size) const {
    double sum = 0.0;
    *size = 0.0;
    const auto visitor = [&](int step, const Eigen::VectorXd&, const Eigen::MatrixXd& derivative) {
      const Eigen::VectorXd terms = weights_[step].cwiseProduct(derivative * direction);
      sum += terms.sum();
      *size += terms.lpNorm<1>();
    };
    const SensitivityResult result = PushForward(parameters_, scene().num_steps(), directions, visitor, simulator);
    EXPECT_FALSE(result.failure.has_value());
    return sum;
  }

  double Difference(const Rollout& rollout, double step) const {
    double sides[2];
    for (const int side : {0, 1}) {
      Scene moved = scene();
      const double signed_step = side == 0 ? -step : step;
      moved.initial_positions += signed_step * position_direction_;
      moved.initial_velocities += signed_step * velocity_direction_;
      Simulator simulator(moved);
      const Rollout perturbed = Run(signed_step, &simulator);
      if (!HaveSameBranches(rollout, perturbed)) return std::numeric_limits<double>::quiet_NaN();
      sides[side] = Value(perturbed);
    }
    return (sides[1] - sides[0]) / (2.0 * step);
  }

  RandomNumbers random_;
  RandomScene scene_;
  Parameters parameters_;
  std::vector<ParameterId> ids_;
  Eigen::VectorXd parameter_direction_, position_direction_, velocity_direction_;
  std::vector<Eigen::VectorXd> weights_;  // per step
};

class IntegratorGradientTest : public ::testing::TestWithParam<Integrator> {
 protected:
  // Scenes with the other integrator are fewer.
  static int NumScenes() { return GetParam() == Integrator::kEuler ? 80 : 40; }
};

INSTANTIATE_TEST_SUITE_P(Integrators, IntegratorGradientTest,
                         ::testing::Values(Integrator::kEuler, Integrator::kSdirk2),
                         [](const auto& test) { return std::string(IntegratorName(test.param)); });

// To rounding and the tolerance of the linear systems, 1e-12, which a step of light and stiff cloth that is about to
// buckle multiplies by its condition: up to 1e4 in a few scenes of a thousand.
TEST_P(IntegratorGradientTest, AdjointEqualsSensitivity) {
  int differentiated = 0, equal = 0;
  for (const std::uint64_t seed : PropertySeeds(NumScenes())) {
    const RandomDerivative derivative(seed, 1e-8, GetParam());
    SCOPED_TRACE(derivative.description());
    Simulator simulator(derivative.scene());
    const Rollout rollout = derivative.Run(0.0, &simulator);
    if (!rollout.ok()) continue;
    ++differentiated;
    double size = 0.0;
    const double sensitivity = derivative.BySensitivity(&simulator, &size);
    const double adjoint = derivative.ByAdjoint(rollout, {}, &simulator);
    EXPECT_NEAR(adjoint, sensitivity, 1e-8 * size);
    equal += std::abs(adjoint - sensitivity) <= 1e-10 * size;
  }
  EXPECT_GE(equal, 0.99 * differentiated);
  EXPECT_GT(differentiated, 0);
}

// The iterations on P end at a residual of 1e-12, which the condition of A makes an error of up to 1e-8.
TEST(RandomGradientTest, EveryMethodGivesTheAdjoint) {
  for (const std::uint64_t seed : PropertySeeds(15)) {
    const RandomDerivative derivative(seed, 1e-8);
    SCOPED_TRACE(derivative.description());
    Simulator simulator(derivative.scene());
    const Rollout rollout = derivative.Run(0.0, &simulator);
    if (!rollout.ok()) continue;
    double size = 0.0;
    const double sensitivity = derivative.BySensitivity(&simulator, &size);
    for (const AdjointMethod method : {AdjointMethod::kReduced, AdjointMethod::kLu}) {
      EXPECT_NEAR(derivative.ByAdjoint(rollout, {method}, &simulator), sensitivity, 1e-10 * size);
    }
    for (const AdjointMethod method : {AdjointMethod::kFixedPoint, AdjointMethod::kSystemGmres}) {
      EXPECT_NEAR(derivative.ByAdjoint(rollout, {method}, &simulator), sensitivity, 1e-8 * size);
    }
  }
}

TEST_P(IntegratorGradientTest, AdjointEqualsCentralDifferencesWhereTheySettle) {
  const std::vector<std::uint64_t> seeds = PropertySeeds(NumScenes());
  int settled = 0;
  for (const std::uint64_t seed : seeds) {
    const RandomDerivative derivative(seed, 1e-12, GetParam());
    SCOPED_TRACE(derivative.description());
    Simulator simulator(derivative.scene());
    const Rollout rollout = derivative.Run(0.0, &simulator);
    if (!rollout.ok()) continue;
    const double difference = derivative.ByDifferences(rollout);
    if (std::isnan(difference)) continue;
    ++settled;
    EXPECT_NEAR(derivative.ByAdjoint(rollout, {}, &simulator), difference, 1e-6 * std::abs(difference));
  }
  RecordProperty("settled", settled);
  EXPECT_GE(settled, 0.8 * static_cast<double>(seeds.size()));
}

}  // namespace
}  // namespace clothid::random_gradient_test
