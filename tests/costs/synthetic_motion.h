// Small scenes, and recordings of them with known parameters, made in memory.
#ifndef CLOTHID_TESTS_COSTS_SYNTHETIC_MOTION_H_
#define CLOTHID_TESTS_COSTS_SYNTHETIC_MOTION_H_

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <atomic>
#include <cmath>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "datasets/motion/recorded_motion.h"
#include "datasets/observation/observation.h"
#include "sim/mesh/mesh.h"
#include "sim/obstacle/obstacle.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/scene.h"

namespace clothid {

inline Scene ClothScene(int nodes_per_side, int num_steps) {
  Scene scene;
  GridOptions grid;
  grid.nodes = {nodes_per_side, nodes_per_side};
  grid.size = {0.3, 0.3};
  scene.time_step = 0.01;
  scene.duration = num_steps * scene.time_step;
  scene.mesh = MakeGrid(grid);
  scene.initial_positions = scene.mesh.rest_positions.reshaped();
  scene.initial_velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
  scene.material.density = 0.2;
  scene.material.stretch_stiffness = 50.0;
  scene.material.bending_stiffness = 2e-3;
  scene.material.drag = 0.1;
  scene.solver.step_tolerance = 1e-10;
  return scene;
}

// 5 x 5 nodes, flat at the start, swinging down from two fixed corners; no contact.
inline Scene SwingScene() {
  Scene scene = ClothScene(5, 20);
  scene.handles.nodes = {0, 4};
  return scene;
}

// The same cloth hung by one edge, its free half sliding down on a sphere named "ball".
inline Scene SphereScene() {
  Scene scene = ClothScene(5, 20);
  scene.handles.nodes = {0, 1, 2, 3, 4};
  SceneObstacle ball;
  ball.name = "ball";
  ball.shape = std::make_shared<Sphere>(Eigen::Vector3d(0.15, 0.2, -0.12), 0.1);
  ball.friction_coefficient = 0.2;
  scene.obstacles = {ball};
  return scene;
}

// A sphere that somebody presses Ctrl-C at, the one of `SphereScene`: sets `cancel` when it is asked for the `count`th
// time.
class InterruptingSphere : public Sphere {
 public:
  InterruptingSphere(int count, std::atomic<bool>* cancel)
      : Sphere(Eigen::Vector3d(0.15, 0.2, -0.12), 0.1), left_(count), cancel_(cancel) {}
  SurfacePoint Closest(const Eigen::Vector3d& position) const override {
    if (--left_ == 0) *cancel_ = true;
    return Sphere::Closest(position);
  }

 private:
  mutable int left_;
  std::atomic<bool>* cancel_;
};

struct MotionOptions {
  std::map<std::string, double> true_values;  // by parameter name; the others are the scene's nominal values
  double noise = 0.0;                         // m
  double frame_interval = 0.0;                // s; 0: every step
  double sigma = 0.0;                         // m; 0: not known
};

// Every node of `scene`, seen at every frame.
inline RecordedMotion MakeMotion(const Scene& scene, const MotionOptions& options) {
  Parameters parameters = scene.nominal_parameters();
  for (const auto& [name, value] : options.true_values) {
    SetParameter(ParseParameter(name, scene), value, &parameters);
  }
  const double interval = options.frame_interval > 0.0 ? options.frame_interval : scene.time_step;
  const int num_frames = static_cast<int>(scene.duration / interval + 1e-9) + 1;
  RecordedMotion motion;
  motion.name = "synthetic";
  motion.scene = scene;
  motion.scene_text = "{}";
  motion.sha256 = "0123";
  motion.times = Eigen::VectorXd::LinSpaced(num_frames, 0.0, (num_frames - 1) * interval);
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
    ObservedPoint point;
    point.nodes[0] = node;
    motion.points.push_back(point);
  }
  motion.positions = Eigen::MatrixXd::Zero(3 * motion.num_points(), num_frames);
  if (options.sigma > 0.0) motion.sigma = Eigen::VectorXd::Constant(motion.num_points(), options.sigma);

  Simulator simulator(scene);
  const Observation observation(motion);
  const Rollout rollout = Simulate(parameters, observation.num_steps(), &simulator);
  EXPECT_TRUE(rollout.ok()) << rollout.failure->ToString();
  motion.positions = observation.Predict(rollout);
  std::mt19937_64 generator(7);
  std::normal_distribution<double> normal(0.0, 1.0);
  for (double& position : motion.positions.reshaped()) position += options.noise * normal(generator);
  return motion;
}

// Seven points on triangles in place of the nodes; one frame and one coordinate of them is not seen.
inline RecordedMotion WithMarkers(RecordedMotion motion) {
  const Eigen::Matrix3Xi& faces = motion.scene.mesh.faces;
  motion.points.clear();
  const int num_markers = 7;
  Eigen::MatrixXd positions(3 * num_markers, motion.num_frames());
  for (int p = 0; p < num_markers; ++p) {
    ObservedPoint point;
    point.num_nodes = 3;
    for (int k = 0; k < 3; ++k) point.nodes[k] = faces(k, (5 * p + 3) % static_cast<int>(faces.cols()));
    point.weights[0] = 0.2;
    point.weights[1] = 0.5;
    point.weights[2] = 0.3;
    positions.middleRows<3>(3 * p).setZero();
    for (int k = 0; k < 3; ++k) {
      positions.middleRows<3>(3 * p) += point.weights[k] * motion.positions.middleRows<3>(3 * point.nodes[k]);
    }
    motion.points.push_back(point);
  }
  positions(4, 2) = positions(9, 7) = std::nan("");
  motion.positions = positions;
  motion.sigma = Eigen::VectorXd::LinSpaced(num_markers, 5e-4, 2e-3);
  return motion;
}

// Adds noise that lasts: of the standard deviation `sigma` m, with the correlation `in_time` from frame to frame.
inline void AddLastingNoise(double sigma, double in_time, unsigned seed, RecordedMotion* motion) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal(0.0, sigma);
  Eigen::VectorXd noise(motion->positions.rows());
  for (double& value : noise) value = normal(generator);
  for (int i = 0; i < motion->num_frames(); ++i) {
    motion->positions.col(i) += noise;
    for (double& value : noise) value = in_time * value + std::sqrt(1.0 - in_time * in_time) * normal(generator);
  }
}

inline std::vector<ParameterBlock> MakeBlocks(const Scene& scene, const std::vector<std::string>& names) {
  std::vector<ParameterBlock> blocks;
  for (const std::string& name : names) blocks.push_back(MakeParameterBlock(name, scene, {}));
  return blocks;
}

inline Eigen::VectorXd StartOf(const std::vector<ParameterBlock>& blocks) {
  Eigen::VectorXd start(static_cast<Eigen::Index>(blocks.size()));
  for (std::size_t i = 0; i < blocks.size(); ++i) start[i] = blocks[i].ToCoordinate(blocks[i].start);
  return start;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_COSTS_SYNTHETIC_MOTION_H_
