// Momentum of random cloths that nothing holds or touches.
//
// A step solves M (v_{n+1} - v_n) - h f_ext - h f_int(x_{n+1}) = e with |e| at most the tolerance. The internal forces
// of stretch, bending and damping come from potentials that no rigid motion of x_{n+1} changes, so their sum and their
// torque about any point vanish at x_{n+1}. Hence exactly, for any c,
//   sum M (v_{n+1} - v_n) - h f_ext = sum e,   sum (x_{n+1} - c) x [M (v_{n+1} - v_n) - h f_ext] = sum (x_{n+1} - c) x
//   e.
// The angular momentum itself changes by h sum v_{n+1} x M v_n besides: implicit Euler's defect.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "sim/cloth/cloth_model.h"
#include "sim/rollout/simulator.h"
#include "tests/sim/property_seeds.h"
#include "tests/sim/random_scene.h"
#include "tests/sim/step/step_residual.h"

namespace clothid::momentum_test {
namespace {

TEST(MomentumTest, OfFreeClothChangesByItsWeightAlone) {
  RandomSceneOptions options;
  options.handles = options.obstacles = options.air = false;
  for (const std::uint64_t seed : PropertySeeds(100)) {
    RandomScene random = MakeRandomScene(seed, options);
    SCOPED_TRACE(random.description);
    random.scene.solver.step_tolerance = 1e-12;
    const Scene& scene = random.scene;
    Simulator simulator(scene);
    const Rollout rollout = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator);
    ASSERT_TRUE(rollout.ok()) << rollout.failure->ToString();
    const Eigen::RowVectorXd masses = scene.material.density * simulator.model().node_areas().transpose();
    Eigen::Matrix3Xd before = rollout.initial_velocities.reshaped(3, masses.size());
    for (std::size_t i = 0; i < rollout.records.size(); ++i) {
      const StepRecord& record = rollout.records[i];
      const Eigen::Matrix3Xd after = record.velocities.reshaped(3, masses.size());
      const Eigen::Matrix3Xd positions = record.positions.reshaped(3, masses.size());
      const Eigen::Matrix3Xd arms = positions.colwise() - positions * masses.transpose() / masses.sum();
      Eigen::Vector3d momentum = Eigen::Vector3d::Zero(), angular_momentum = momentum;
      for (Eigen::Index node = 0; node < masses.size(); ++node) {
        const Eigen::Vector3d external = masses[node] * scene.gravity + scene.node_force;
        const Eigen::Vector3d change =
            masses[node] * (after.col(node) - before.col(node)) - record.time_step * external;
        momentum += change;
        angular_momentum += Eigen::Vector3d(arms.col(node)).cross(change);
      }
      const StepResidual bound = ResidualOf(rollout, i, &simulator);
      const double residual = bound.tolerance * bound.scale;
      EXPECT_LE(momentum.norm(), std::sqrt(static_cast<double>(masses.size())) * residual) << "solve " << i;
      EXPECT_LE(angular_momentum.norm(), arms.norm() * residual) << "solve " << i;
      before = after;
    }
  }
}

}  // namespace
}  // namespace clothid::momentum_test
