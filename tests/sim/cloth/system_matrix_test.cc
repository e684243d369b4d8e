// PD's constant matrix against the terms of a step.
#include "sim/cloth/system_matrix.h"

#include <gtest/gtest.h>

#include <memory>

#include "sim/cloth/cloth_model.h"
#include "sim/obstacle/obstacle.h"
#include "sim/step/step_problem.h"
#include "tests/sim/plain_scenes.h"

namespace clothid::system_matrix_test {
namespace {

// P of a cloth with every term: its diagonal is the d of the contact law, its rows sum to M + h C, as L and Q do not
// see a shift, and the factor is that of P on each axis.
TEST(SystemMatrixTest, HasTheTermsOfTheStep) {
  Scene scene = ClothScene(SquareGrid(6, 0.4), 0.01);
  scene.material = {0.2, 50.0, 1e-3, 0.3, 0.2};
  SceneObstacle ball;
  ball.name = "ball";
  ball.shape = std::make_shared<Sphere>(Eigen::Vector3d(0.2, 0.2, -0.25), 0.2);
  scene.obstacles.push_back(ball);
  const double h = scene.time_step;
  Simulator simulator(scene);
  const ClothModel& model = simulator.model();
  const Eigen::SparseMatrix<double> matrix = AssembleSystemMatrix(model, scene.material, h);
  const Parameters parameters = scene.nominal_parameters();
  const StepProblem problem(model, parameters, {scene.initial_positions, scene.initial_velocities}, {h, h},
                            &simulator.step_workspace());
  ASSERT_EQ(static_cast<int>(problem.contacts().candidates().size()), model.num_nodes());
  for (int i = 0; i < model.num_nodes(); ++i) {
    const double weight = problem.contacts().weight(i);
    EXPECT_NEAR(matrix.coeff(problem.contacts().free_block(i), problem.contacts().free_block(i)), weight,
                1e-14 * weight);
  }
  const Eigen::VectorXd row_sums = matrix * Eigen::VectorXd::Ones(model.num_free());
  const double areal_mass = scene.material.density + h * scene.material.drag;
  EXPECT_LE((row_sums - areal_mass * model.node_areas()(model.free_nodes())).norm(), 1e-12 * row_sums.norm());

  const SystemMatrixFactor factor(model, scene.material, h);
  const Eigen::MatrixXd right = Eigen::MatrixXd::Random(3 * model.num_free(), 2);
  const Eigen::MatrixXd solution = factor.Solve(right);
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::MatrixXd of_axis = solution(Eigen::seqN(axis, model.num_free(), 3), Eigen::all);
    EXPECT_LE((matrix * of_axis - right(Eigen::seqN(axis, model.num_free(), 3), Eigen::all)).norm(),
              1e-12 * right.norm());
  }
}

}  // namespace
}  // namespace clothid::system_matrix_test
