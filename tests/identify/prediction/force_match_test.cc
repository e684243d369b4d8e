// Forces are found that make rollouts miss recordings as they do.
#include "identify/prediction/force_match.h"

#include <gtest/gtest.h>

#include <cmath>

#include "costs/prediction/recording_model.h"
#include "identify/prediction/random_force.h"
#include "sim/rollout/simulator.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::force_match_test {
namespace {

TEST(NonNegativeLeastSquaresTest, AnswersAreOfTheLeastThatIsNotNegative) {
  const Eigen::Matrix2d a = (Eigen::Matrix2d() << 1.0, 1.0, 0.0, 1.0).finished();
  const Eigen::VectorXd inside = NonNegativeLeastSquares(a, Eigen::Vector2d(3.0, 2.0));
  EXPECT_NEAR(inside[0], 1.0, 1e-12);
  EXPECT_NEAR(inside[1], 2.0, 1e-12);
  // Without the bound (-1, 2): along the second alone the least is at 3/2.
  const Eigen::VectorXd cut = NonNegativeLeastSquares(a, Eigen::Vector2d(1.0, 2.0));
  EXPECT_EQ(cut[0], 0.0);
  EXPECT_NEAR(cut[1], 1.5, 1e-12);
  EXPECT_EQ(NonNegativeLeastSquares(a, Eigen::Vector2d(-1.0, -1.0)).norm(), 0.0);
}

// A sheet of .6 s that hangs by two corners.
Scene Hung() {
  Scene scene = ClothScene(6, 60);
  scene.handles.nodes = {0, 5};
  return scene;
}

// Recordings of it that are pushed by draws of `force`, and what is found; nothing but that is wrong.
std::vector<LastingForce> Found(const LastingForce& force, int num_recordings,
                                const std::optional<LastingForce>& told = {}) {
  const Scene scene = Hung();
  MotionOptions made;
  made.noise = made.sigma = 1e-4;
  const Simulator simulator(scene);
  const ForceSource source({force}, simulator.model());
  std::vector<RecordedMotion> motions;
  for (int r = 0; r < num_recordings; ++r) {
    RecordedMotion motion = MakeMotion(scene, made);
    RecordingModel model(motion, {});
    Eigen::MatrixXd still, pushed;
    model.Simulate(Eigen::VectorXd(), {}, {}, &still);
    model.Correct(source.Draw(1.0, model.cloth(), scene.nominal_parameters().material, model.num_steps(), 99, r));
    model.Simulate(Eigen::VectorXd(), {}, {}, &pushed);
    motion.positions += pushed - still;
    motions.push_back(motion);
  }
  ForceMatchOptions options;
  options.num_draws = 24;
  options.num_threads = 2;
  return MatchForces(motions, {}, Eigen::VectorXd(), std::vector<HeldOutStart>(motions.size()), told, options);
}

TEST(ForceMatchTest, ASlowForceIsFoundAsLargeAsItIs) {
  const LastingForce truth = {0.2, 0.3, 0.1};
  const std::vector<LastingForce> found = Found(truth, 12);
  double square = 0.0;
  for (const LastingForce& force : found) square += force.size * force.size;
  EXPECT_NEAR(std::log(std::sqrt(square) / truth.size), 0.0, 0.3);
}

TEST(ForceMatchTest, WhatCorrectionsToldIsKeptAndNoMoreIsFoundWhereThatIsAll) {
  const LastingForce truth = {0.2, 0.05, 0.1};
  const std::vector<LastingForce> found = Found(truth, 12, truth);
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found[0].size, truth.size);
  for (std::size_t i = 1; i < found.size(); ++i) EXPECT_LT(found[i].size, 0.3 * truth.size);
}

TEST(ForceMatchTest, NothingIsLackingWhereNothingIsMissed) {
  for (const LastingForce& force : Found({1e-9, 0.3, 0.1}, 4)) EXPECT_LT(force.size, 2e-3);
}

}  // namespace
}  // namespace clothid::force_match_test
