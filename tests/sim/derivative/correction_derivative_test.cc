// Rollouts that a recording corrects: adjoint = sensitivity = central finite differences, at several rates, with both
// integrators and contact modes, obstacles that move and a cloth that touches itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <tuple>

#include "sim/obstacle/obstacle.h"
#include "tests/sim/derivative/gradient_case.h"
#include "tests/sim/derivative/moving_obstacle_case.h"
#include "tests/sim/moving_paths.h"
#include "tests/sim/nodal_correction.h"
#include "tests/sim/self_contact_scenes.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid::correction_derivative_test {
namespace {

constexpr int kInterval = 4;  // steps

// What the recording was made with.
Parameters TrueParameters(const Scene& scene) {
  Parameters parameters = scene.nominal_parameters();
  for (double& mu : parameters.friction_coefficients) mu *= 0.7;
  parameters.material.stretch_stiffness *= 0.6;
  parameters.material.bending_stiffness *= 1.5;
  return parameters;
}

void ExpectCorrectedAgreement(const Scene& scene, const Parameters& parameters, const NodalCorrection::Gains& gains,
                              double difference_tolerance) {
  const auto correction = CorrectionTowards(scene, TrueParameters(scene), kInterval, gains);
  const GradientCase gradient(scene, parameters, AdjointMethod::kReduced, correction);
  ExpectAgreement(gradient, difference_tolerance);
  // It is corrected, and by a lot.
  double largest = 0.0;
  for (const StepRecord& record : gradient.rollout().records) {
    if (record.correction == nullptr) continue;
    largest = std::max(largest, (record.correction->positions - record.positions).lpNorm<Eigen::Infinity>());
  }
  EXPECT_GT(largest, 1e-6);
}

// Whether there are nodes that touch an obstacle, or such that stop at one.
bool HasLimits(const Rollout& rollout, bool touching) {
  for (const StepRecord& record : rollout.records) {
    if (record.correction == nullptr) continue;
    for (const CorrectionLimit& limit : record.correction->limits) {
      if (limit.touches == touching && (touching || limit.is_outside)) return true;
    }
  }
  return false;
}

using SceneParam = std::tuple<std::string, ContactMode, Integrator, double>;

class CorrectionDerivativeTest : public testing::TestWithParam<SceneParam> {};

TEST_P(CorrectionDerivativeTest, AdjointEqualsSensitivityEqualsDifferences) {
  const auto [name, mode, integrator, alpha] = GetParam();
  Scene scene = ShippedScene(name, 8);
  scene.contact_mode = mode;
  scene.integrator = integrator;
  scene.solver.adjoint_tolerance = 1e-14;
  // With two stages the folds into which a sheet on a plane is drawn are so sharp that differences lose their digits.
  const bool has_folds = name == "slope" && integrator == Integrator::kSdirk2;
  scene.duration = std::min(scene.duration, has_folds ? 0.25 : 0.5);
  if (has_folds) Land(&scene);
  NodalCorrection::Gains gains;
  gains.alpha = alpha;
  gains.beta = 0.5 * alpha * alpha;
  ExpectCorrectedAgreement(scene, scene.nominal_parameters(), gains, name == "drape" ? 1e-5 : 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Scenes, CorrectionDerivativeTest,
                         testing::Combine(testing::Values("drape", "slope", "wind"),
                                          testing::Values(ContactMode::kGap, ContactMode::kVelocity),
                                          testing::Values(Integrator::kEuler, Integrator::kSdirk2),
                                          testing::Values(0.8, 0.3, 0.03)),
                         [](const auto& test) {
                           return std::get<0>(test.param) +
                                  (std::get<1>(test.param) == ContactMode::kGap ? "Gap" : "Velocity") +
                                  IntegratorName(std::get<2>(test.param)) + "Rate" +
                                  std::to_string(std::lround(100 * std::get<3>(test.param)));
                         });

// A ball that wanders and tumbles, all seven numbers of its placement as well.
TEST(CorrectionOnMovingObstaclesTest, AdjointEqualsSensitivityEqualsDifferences) {
  for (const Integrator integrator : {Integrator::kEuler, Integrator::kSdirk2}) {
    Scene scene = MovingObstacleScene({"drape", ContactMode::kGap, integrator}, 8);
    SceneObstacle& obstacle = scene.obstacles[0];
    const auto& ball = dynamic_cast<const Sphere&>(*obstacle.shape);
    const Eigen::Vector3d centre = ball.center();
    obstacle.shape =
        std::make_shared<Capsule>(Eigen::Vector3d(-0.05, 0.0, 0.0), Eigen::Vector3d(0.05, 0.02, 0.0), ball.radius());
    obstacle.path = PathThrough(
        0.0, 1.0, 51,
        [=](double t) { return Eigen::Vector3d(centre + Eigen::Vector3d(0.1 * std::sin(5.0 * t), 0.05 * t, 0.1 * t)); },
        [](double t) { return Eigen::Vector3d(0.8 * std::sin(4.0 * t), 2.0 * t, -0.5 * t); });
    Parameters parameters = scene.nominal_parameters();
    parameters.placements = {{0.004, {0.002, -0.003, 0.001}, {0.05, -0.02, 0.03}}};
    ExpectCorrectedAgreement(scene, parameters, {}, 1e-5);
  }
}

// A recording that falls faster: nodes are drawn into the obstacle, and stop at its surface.
TEST(CorrectionIntoObstaclesTest, AdjointEqualsSensitivityEqualsDifferences) {
  for (const char* name : {"drape", "slope"}) {
    Scene scene = ShippedScene(name, 8);
    if (name == std::string("slope")) {
      scene.initial_positions.reshaped(3, scene.mesh.num_nodes()).colwise() +=
          0.01 * scene.obstacles[0].shape->Closest(Eigen::Vector3d::Zero()).normal;
    }
    scene.duration = std::min(scene.duration, 0.4);
    scene.solver.adjoint_tolerance = 1e-14;
    Scene measured = scene;
    measured.gravity *= 2.0;
    measured.obstacles.clear();
    NodalCorrection::Gains gains;
    gains.alpha = 0.9;
    const auto correction = CorrectionTowards(measured, measured.nominal_parameters(), kInterval, gains);
    const GradientCase gradient(scene, scene.nominal_parameters(), AdjointMethod::kReduced, correction);
    EXPECT_TRUE(HasLimits(gradient.rollout(), /*touching=*/true)) << name;
    EXPECT_TRUE(HasLimits(gradient.rollout(), /*touching=*/false)) << name;
    ExpectAgreement(gradient, 1e-5);
  }
}

// A layer that falls on another one, which is free in between: what touches goes together.
TEST(CorrectionOfTouchingLayersTest, AdjointEqualsSensitivityEqualsDifferences) {
  for (const Integrator integrator : {Integrator::kEuler, Integrator::kSdirk2}) {
    Scene scene = LayersOnASlope(2, 0.44, 0.3, integrator, 0.005);
    const int num_lower = static_cast<int>(scene.handles.nodes.size());
    scene.handles.nodes.clear();
    for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
      const double x = scene.initial_positions[3 * node];
      if (node < num_lower && (x < 0.011 || x > 0.211)) scene.handles.nodes.push_back(node);
      if (node < num_lower) continue;
      scene.initial_positions[3 * node + 2] += 0.001;
      scene.initial_velocities[3 * node] = 0.05;
    }
    scene.duration = 0.06;
    scene.solver.adjoint_tolerance = 1e-14;
    Scene measured = scene;
    measured.gravity *= 1.1;
    const auto correction = CorrectionTowards(measured, TrueParameters(measured), kInterval, {});
    const GradientCase gradient(scene, scene.nominal_parameters(), AdjointMethod::kReduced, correction);
    bool moves_together = false;
    for (const StepRecord& record : gradient.rollout().records) {
      if (record.correction == nullptr) continue;
      for (const CorrectionGroup& group : record.correction->groups) moves_together |= group.moves;
    }
    EXPECT_TRUE(moves_together);
    EXPECT_EQ(gradient.rollout().cut_corrections, 0);
    ExpectAgreement(gradient, 1e-5);
  }
}

}  // namespace
}  // namespace clothid::correction_derivative_test
