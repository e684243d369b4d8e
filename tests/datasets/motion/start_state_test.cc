// A start from noisy frames is a shape that the cloth can have, nearer to the truth than the first frame.
#include "datasets/motion/start_state.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "sim/contact/pair_geometry.h"
#include "sim/contact/self_contact_search.h"
#include "sim/rollout/simulator.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/sim/self_contact_scenes.h"

namespace clothid::start_state_test {
namespace {

constexpr double kNoise = 4e-3;

// 12 x 12 nodes of 0.3 m, hung by an edge over the ball of `SphereScene`, on their way down for 0.2 s.
struct Draped {
  Scene scene;  // its start: where the recording starts
  RecordedMotion motion;
  Eigen::VectorXd positions, velocities;  // the truth
};

Draped MakeDraped(int num_frames, unsigned seed, double noise = kNoise) {
  constexpr int kStart = 20;
  Draped draped;
  Scene scene = ClothScene(12, kStart + num_frames);
  scene.integrator = Integrator::kEuler;  // which is slow on its way
  scene.bending.law = BendingLaw::kEdges;
  scene.solver.step_tolerance = 1e-6;
  for (int i = 0; i < 12; ++i) scene.handles.nodes.push_back(i);
  scene.obstacles = SphereScene().obstacles;
  draped.motion = MakeMotion(scene, {});
  Simulator simulator(scene);
  const Rollout rollout = Simulate(scene.nominal_parameters(), kStart, &simulator);
  draped.positions = rollout.positions(kStart);
  draped.velocities = (draped.motion.positions.col(kStart + 1) - draped.motion.positions.col(kStart)) / scene.time_step;
  draped.motion.times = draped.motion.times.head(num_frames).eval();
  draped.motion.positions = draped.motion.positions.middleCols(kStart, num_frames).eval();
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal(0.0, noise);
  for (double& position : draped.motion.positions.reshaped()) position += normal(generator);
  scene.initial_positions = draped.motion.positions.col(0);
  for (const int handle : scene.handles.nodes) {
    scene.initial_positions.segment<3>(3 * handle) = draped.positions.segment<3>(3 * handle);
  }
  draped.scene = scene;
  return draped;
}

FrameTrend TrendOf(const RecordedMotion& motion, double noise = kNoise) {
  return FitFrameTrend(motion.times, motion.positions, Eigen::VectorXd::Constant(motion.num_points(), noise));
}

// The least distance of two parts of a cloth that meets itself, m.
double LeastDistance(const Scene& scene, const Eigen::VectorXd& positions) {
  SelfContactSearch search(scene.mesh, scene.self_contact->thickness);
  std::vector<PairFeatures> pairs;
  search.Find(positions, Eigen::VectorXd::Zero(positions.size()), 0.0, 0.0, &pairs);
  double least = std::numeric_limits<double>::infinity();
  for (const PairFeatures& pair : pairs) least = std::min(least, EvaluatePair(pair, positions).distance);
  return least;
}

double LeastGap(const Scene& scene, const Eigen::VectorXd& positions) {
  double least = std::numeric_limits<double>::infinity();
  for (int node = 12; node < scene.mesh.num_nodes(); ++node) {
    least = std::min(least, scene.obstacles[0].shape->Closest(positions.segment<3>(3 * node)).gap);
  }
  return least;
}

// The largest change of an edge relative to its length at rest.
double LargestStrain(const Mesh& mesh, const Eigen::VectorXd& positions) {
  double largest = 0.0;
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int i = 0; i < 3; ++i) {
      const int a = mesh.faces(i, f), b = mesh.faces((i + 1) % 3, f);
      const double rest = (mesh.rest_positions.col(a) - mesh.rest_positions.col(b)).norm();
      const double length = (positions.segment<3>(3 * a) - positions.segment<3>(3 * b)).norm();
      largest = std::max(largest, std::abs(length / rest - 1.0));
    }
  }
  return largest;
}

TEST(StartStateTest, IsNearerToTheTruthThanTheFirstFrame) {
  using Case = std::pair<unsigned, BendingLaw>;
  for (const auto& [seed, law] : {Case(1, BendingLaw::kEdges), Case(2, BendingLaw::kEdges), Case(3, BendingLaw::kEdges),
                                  Case(1, BendingLaw::kPatches)}) {
    Draped draped = MakeDraped(8, seed);
    draped.scene.bending.law = law;
    const Eigen::VectorXd start = SmoothStartPositions(draped.scene, draped.motion.points, TrendOf(draped.motion));
    const double first = (draped.scene.initial_positions - draped.positions).norm();
    EXPECT_LT((start - draped.positions).norm(), 0.6 * first) << seed;
    EXPECT_LT(LeastGap(draped.scene, draped.scene.initial_positions), -1e-3) << "the noise penetrates";
    EXPECT_GE(LeastGap(draped.scene, start), 0.0) << seed;
    EXPECT_GT(LargestStrain(draped.scene.mesh, draped.scene.initial_positions), 0.3);
    EXPECT_LT(LargestStrain(draped.scene.mesh, start), 0.06) << seed;
    for (const int handle : draped.scene.handles.nodes) {
      EXPECT_EQ(start.segment<3>(3 * handle), draped.positions.segment<3>(3 * handle));
    }
  }
}

// 0.15 m/s: 1 cm over the frames. Under noise of 4 mm they show none that one could tell.
TEST(StartStateTest, FindsTheVelocityOfAClothThatMoves) {
  EXPECT_EQ(TrendOf(MakeDraped(8, 4).motion).velocities.size(), 0);
  constexpr double kSmallNoise = 5e-4;
  const Draped draped = MakeDraped(8, 4, kSmallNoise);
  const FrameTrend trend = TrendOf(draped.motion, kSmallNoise);
  ASSERT_GT(trend.velocities.size(), 0);
  const Eigen::VectorXd velocities = SmoothStartVelocities(draped.scene, draped.motion.points, trend);
  EXPECT_LT((velocities - draped.velocities).norm(), 0.5 * draped.velocities.norm());
  EXPECT_TRUE(velocities.head(36).isZero()) << "handles that stand still";
}

TEST(StartStateTest, WithoutNoiseItIsTheFirstFrame) {
  Draped draped = MakeDraped(8, 1);
  draped.motion.positions.colwise() = draped.positions;
  draped.scene.initial_positions = draped.positions;
  const FrameTrend trend =
      FitFrameTrend(draped.motion.times, draped.motion.positions, Eigen::VectorXd::Constant(144, 1e-8));
  EXPECT_EQ(trend.velocities.size(), 0);
  const Eigen::VectorXd start = SmoothStartPositions(draped.scene, draped.motion.points, trend);
  const double penetration = std::max(0.0, -LeastGap(draped.scene, draped.positions));  // of loosely solved steps
  EXPECT_LT(penetration, 1e-4);
  EXPECT_LT((start - draped.positions).lpNorm<Eigen::Infinity>(), 1e-6 + penetration);
}

TEST(StartStateTest, AFlippedFrameAndWildPointsDoNotSpoilIt) {
  Draped draped = MakeDraped(8, 5);
  const Eigen::MatrixXd first = draped.motion.positions.col(0).reshaped(3, 144);
  draped.motion.positions.col(0) = first.rowwise().reverse().reshaped();
  draped.motion.positions.middleRows<3>(3 * 70).array() += 0.2;
  draped.motion.positions.middleRows<3>(3 * 100).setConstant(std::numeric_limits<double>::quiet_NaN());
  draped.scene.initial_positions = draped.scene.mesh.rest_positions.reshaped();
  const Eigen::VectorXd start = SmoothStartPositions(draped.scene, draped.motion.points, TrendOf(draped.motion));
  const Eigen::VectorXd error = start - draped.positions;
  EXPECT_LT(error.norm() / 12.0, 8e-3) << "m, root mean square";
  EXPECT_LT(error.segment<3>(3 * 70).norm(), 0.03);
  EXPECT_LT(error.segment<3>(3 * 100).norm(), 0.03);
}

// Every ninth node as a marker: the shape between them comes from the cloth.
TEST(StartStateTest, GoesSmoothlyThroughMarkers) {
  Draped draped = MakeDraped(8, 6);
  std::vector<ObservedPoint> markers;
  Eigen::MatrixXd positions(0, 8);
  for (int node = 13; node < 144; node += 9) {
    markers.push_back(draped.motion.points[node]);
    positions.conservativeResize(positions.rows() + 3, Eigen::NoChange);
    positions.bottomRows<3>() = draped.motion.positions.middleRows<3>(3 * node);
  }
  const FrameTrend trend = FitFrameTrend(draped.motion.times, positions,
                                         Eigen::VectorXd::Constant(static_cast<Eigen::Index>(markers.size()), kNoise));
  draped.scene.initial_positions = draped.scene.mesh.rest_positions.reshaped();
  const Eigen::VectorXd start = SmoothStartPositions(draped.scene, markers, trend);
  const double rigid = (draped.scene.initial_positions - draped.positions).norm();
  EXPECT_LT((start - draped.positions).norm(), 0.3 * rigid);
  EXPECT_GE(LeastGap(draped.scene, start), 0.0);
  EXPECT_LT(LargestStrain(draped.scene.mesh, start), 0.06);
}

// Noise puts layers nearer to each other than they can be.
TEST(StartStateTest, KeepsLayersApart) {
  Scene scene = LayersOnASlope(2, 0.1, 0.5, Integrator::kSdirk2, 0.005);
  scene.duration = 0.02;
  MotionOptions options;
  options.noise = 3e-4;
  const RecordedMotion motion = MakeMotion(scene, options);
  const double thickness = scene.self_contact->thickness;
  ASSERT_LT(LeastDistance(scene, motion.positions.col(0)), 0.9 * thickness);
  const Eigen::VectorXd start = SmoothStartPositions(scene, motion.points, TrendOf(motion, options.noise));
  EXPECT_GE(LeastDistance(scene, start), 0.998 * thickness);
  EXPECT_LE((start - scene.initial_positions).cwiseAbs().maxCoeff(), 5.0 * options.noise);
}

}  // namespace
}  // namespace clothid::start_state_test
