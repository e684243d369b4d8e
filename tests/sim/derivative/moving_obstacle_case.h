// What the derivative tests of obstacles that move and of those that deform have in common.
#ifndef CLOTHID_TESTS_SIM_DERIVATIVE_MOVING_OBSTACLE_CASE_H_
#define CLOTHID_TESTS_SIM_DERIVATIVE_MOVING_OBSTACLE_CASE_H_

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <tuple>

#include "tests/sim/derivative/gradient_case.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid {

using MovingObstacleParam = std::tuple<std::string, ContactMode, Integrator>;  // `drape` or `slope`

// Before its obstacle is made to move.
inline Scene MovingObstacleScene(const MovingObstacleParam& param, int nodes) {
  Scene scene = ShippedScene(std::get<0>(param), nodes);
  scene.contact_mode = std::get<1>(param);
  scene.integrator = std::get<2>(param);
  scene.duration = std::min(scene.duration, 0.4);
  scene.solver.adjoint_tolerance = 1e-14;  // on the plane k_bend moves so little that 1e-12 shows
  return scene;
}

// adjoint = sensitivity = central finite differences, for all seven numbers of the obstacle's placement as well.
inline void ExpectMovingObstacleAgreement(const Scene& scene, const MovingObstacleParam& param) {
  Parameters parameters = scene.nominal_parameters();
  // Away from where placements are zero, so that nothing vanishes by chance.
  parameters.placements = {{0.004, {0.002, -0.003, 0.001}, {0.05, -0.02, 0.03}}};
  const GradientCase gradient(scene, parameters);
  const std::string name = scene.obstacles[0].name;
  for (const char* part : {".time_offset", ".shift.x", ".shift.y", ".shift.z", ".turn.x", ".turn.y", ".turn.z"}) {
    EXPECT_TRUE(gradient.HasInfluence(name + part)) << part;
  }
  EXPECT_TRUE(gradient.HasInfluence("mu"));
  ExpectAgreement(gradient, std::get<0>(param) == "drape" ? 1e-5 : 1e-6);
}

inline auto MovingObstacleParams() {
  return testing::Combine(testing::Values("drape", "slope"), testing::Values(ContactMode::kGap, ContactMode::kVelocity),
                          testing::Values(Integrator::kEuler, Integrator::kSdirk2));
}

inline std::string MovingObstacleName(const testing::TestParamInfo<MovingObstacleParam>& test) {
  return std::get<0>(test.param) + (std::get<1>(test.param) == ContactMode::kGap ? "Gap" : "Velocity") +
         IntegratorName(std::get<2>(test.param));
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_DERIVATIVE_MOVING_OBSTACLE_CASE_H_
