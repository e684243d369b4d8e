// A scene built by hand around an obstacle of the user's own: its derivatives, the gradient of a rollout, a fit.
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <memory>
#include <stdexcept>
#include <utility>

#include "costs/rollout_cost.h"
#include "sim/derivative/adjoint.h"
#include "sim/rollout/simulator.h"
#include "torus.h"

namespace {

// Largest differences of n and dn/dx from central differences of phi and n, at points around the ring.
void CheckDerivatives(const clothid::Obstacle& obstacle, const Eigen::Vector3d& center) {
  const double step = 1e-5;  // m
  double normal_error = 0.0, gradient_error = 0.0;
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d x =
        center + Eigen::Vector3d(0.13 * std::cos(i), 0.11 * std::sin(i), 0.06 * std::cos(3.0 * i));
    const clothid::SurfacePoint point = obstacle.Closest(x);
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d shift = step * Eigen::Vector3d::Unit(axis);
      const clothid::SurfacePoint plus = obstacle.Closest(x + shift), minus = obstacle.Closest(x - shift);
      normal_error = std::max(normal_error, std::abs((plus.gap - minus.gap) / (2.0 * step) - point.normal[axis]));
      const Eigen::Vector3d column = (plus.normal - minus.normal) / (2.0 * step);
      gradient_error = std::max(gradient_error, (column - point.normal_gradient.col(axis)).norm());
    }
  }
  std::printf("normal_error %.3g\nnormal_gradient_error %.3g\n", normal_error, gradient_error);
}

//! [scene]
// A square of cloth, hung by one edge, swings down on the ring and slides over it.
clothid::Scene MakeScene(std::shared_ptr<const clothid::Obstacle> ring) {
  clothid::Scene scene;
  clothid::GridOptions grid;
  grid.nodes = {10, 10};
  scene.mesh = clothid::MakeGrid(grid);
  scene.initial_positions = scene.mesh.rest_positions.reshaped();
  scene.initial_velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
  for (int i = 0; i < grid.nodes[0]; ++i) scene.handles.nodes.push_back(i);
  scene.time_step = 0.01;
  scene.duration = 0.4;
  scene.material.density = 0.2;
  scene.material.stretch_stiffness = 60.0;
  scene.material.bending_stiffness = 2e-3;
  scene.material.drag = 0.1;
  scene.solver.step_tolerance = 1e-10;
  scene.obstacles = {{"ring", std::move(ring), /*friction_coefficient=*/0.5, /*contact_distance=*/0.002}};
  return scene;
}
//! [scene]

clothid::Rollout RolloutAt(double mu, clothid::Simulator* simulator) {
  const clothid::Scene& scene = simulator->scene();
  clothid::Parameters parameters = scene.nominal_parameters();
  parameters.friction_coefficients = {mu};
  clothid::Rollout rollout = clothid::Simulate(parameters, scene.num_steps(), simulator);
  if (!rollout.ok()) throw std::runtime_error(rollout.failure->ToString());
  return rollout;
}

// C = w . x with x the last positions: dC/dmu by the adjoint sweep and by central differences.
void CheckGradient(double mu, clothid::Simulator* simulator) {
  const clothid::Scene& scene = simulator->scene();
  const Eigen::VectorXd weights = Eigen::VectorXd::LinSpaced(scene.initial_positions.size(), -1.0, 2.0);
  const clothid::Rollout rollout = RolloutAt(mu, simulator);
  const int last = rollout.num_steps();
  const auto add_gradient = [&](int step, Eigen::MatrixXd* gradient) {
    if (step == last) gradient->col(0) += weights;
  };
  const clothid::ParameterId friction = clothid::ParseParameter("mu", scene.obstacle_names());
  const double adjoint = clothid::PullBack(rollout, {friction}, 1, add_gradient, simulator).parameters(0, 0);
  const double step = 1e-5;
  const double plus = weights.dot(RolloutAt(mu + step, simulator).positions(last));
  const double minus = weights.dot(RolloutAt(mu - step, simulator).positions(last));
  std::printf("contacts_in_last_step %zu\nadjoint %.9g\ncentral_difference %.9g\n",
              rollout.records.back().contacts.nodes.size(), adjoint, (plus - minus) / (2.0 * step));
}

//! [recording]
// What a perfect sensor would see of the cloth at friction `true_mu`: every node at every step.
clothid::RecordedMotion Record(double true_mu, clothid::Simulator* simulator) {
  const clothid::Scene& scene = simulator->scene();
  const clothid::Rollout rollout = RolloutAt(true_mu, simulator);
  clothid::RecordedMotion motion;
  motion.name = "ring";
  motion.scene = scene;
  motion.times = Eigen::VectorXd::LinSpaced(rollout.num_steps() + 1, 0.0, rollout.num_steps() * scene.time_step);
  motion.positions.resize(scene.initial_positions.size(), motion.times.size());
  for (int step = 0; step <= rollout.num_steps(); ++step) motion.positions.col(step) = rollout.positions(step);
  motion.points.resize(scene.mesh.num_nodes());
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) motion.points[node].nodes[0] = node;
  return motion;
}
//! [recording]

//! [fit]
double FitFriction(const clothid::RecordedMotion& motion) {
  const clothid::ParameterBlock block = clothid::MakeParameterBlock("mu", motion.scene, {});
  double mu = block.start;  // friction is its own coordinate
  ceres::Problem problem;
  problem.AddResidualBlock(new clothid::RolloutCost(motion, {block}, {}), nullptr, &mu);
  problem.SetParameterLowerBound(&mu, 0, block.lower_bound);
  problem.SetParameterUpperBound(&mu, 0, block.upper_bound);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) throw std::runtime_error(summary.message);
  return mu;
}
//! [fit]

void Run() {
  const Eigen::Vector3d center(0.15, 0.2, -0.08);
  const auto ring = std::make_shared<Torus>(center, 0.08, 0.03);
  CheckDerivatives(*ring, center);
  clothid::Simulator simulator(MakeScene(ring));
  const double true_mu = 0.2;
  CheckGradient(true_mu, &simulator);
  std::printf("true_mu %.9g\nmu %.9g\n", true_mu, FitFriction(Record(true_mu, &simulator)));
}

}  // namespace

int main() {
  try {
    Run();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "obstacle: %s\n", error.what());
    return 1;
  }
  return 0;
}
