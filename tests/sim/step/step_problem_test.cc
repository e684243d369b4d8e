// The equations of a step: K is the derivative of g, with every term that a scene may have, and the work space is
// neither seen in the results nor allocated twice.
#include "sim/step/step_problem.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <random>

#include "sim/rollout/simulator.h"
#include "tests/sim/woven_scene.h"

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define CLOTHID_COUNTS_ALLOCATIONS
namespace {
int num_allocations = 0;
}
extern "C" void* __libc_malloc(size_t size);
// In front of the library's, for Eigen's vectors as well.
extern "C" void* malloc(size_t size) {
  ++num_allocations;
  return __libc_malloc(size);
}
#endif

namespace clothid::step_problem_test {
namespace {

// A grid with two held corners over a sphere, with bending, drag and damping. Its 30 faces do not fill the last batch.
Scene FullScene(int columns = 6, int rows = 4) {
  GridOptions grid;
  grid.nodes = {columns, rows};
  grid.size = {0.5, 0.3};
  Scene scene;
  scene.mesh = MakeGrid(grid);
  scene.initial_positions = scene.mesh.rest_positions.reshaped();
  scene.initial_velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
  scene.handles.nodes = {23, 5};
  scene.material.bending_stiffness = 1e-3;
  scene.material.drag = 0.1;
  scene.material.damping = 0.5;
  scene.wind.mean = {0.5, 1.0, -0.2};
  SceneObstacle ball;
  ball.name = "ball";
  ball.shape = std::make_shared<Sphere>(Eigen::Vector3d(0.25, 0.15, -0.2), 0.25);
  scene.obstacles.push_back(ball);
  return scene;
}

class StepProblemTest : public ::testing::Test {
 protected:
  StepProblemTest() : simulator_(FullScene()), parameters_(simulator_.scene().nominal_parameters()) {
    x_ = 1.05 * Random(0.005) + simulator_.scene().initial_positions;
    v_ = Random(0.3);
  }

  Eigen::VectorXd Random(double scale) {
    Eigen::VectorXd vector(simulator_.scene().initial_positions.size());
    for (double& value : vector) value = scale * normal_(generator_);
    return vector;
  }

  StepProblem Problem(double time_step, StepWorkspace* workspace) {
    return StepProblem(simulator_.model(), parameters_, {x_, v_}, {time_step, 0.3}, workspace);
  }

  std::mt19937_64 generator_{7};
  std::normal_distribution<double> normal_;
  Simulator simulator_;
  Parameters parameters_;
  Eigen::VectorXd x_, v_;
};

TEST_F(StepProblemTest, HessianIsTheDerivativeOfTheMomentumGradient) {
  const StepProblem problem = Problem(0.01, &simulator_.step_workspace());
  const Eigen::VectorXd velocities = simulator_.model().Gather(v_ + Random(0.1));
  const Eigen::VectorXd direction = simulator_.model().Gather(Random(1.0));
  const double step = 1e-6;
  StepPoint point, plus, minus;
  problem.Evaluate(velocities, &point);
  problem.Evaluate(velocities + step * direction, &plus);
  problem.Evaluate(velocities - step * direction, &minus);
  BlockMatrix hessian(simulator_.model().pattern());
  hessian.values.setConstant(std::nan(""));  // it is overwritten
  problem.AssembleHessian(HessianKind::kExact, point, &hessian);
  const Eigen::VectorXd difference = (plus.momentum_gradient - minus.momentum_gradient) / (2.0 * step);
  EXPECT_LT((hessian.view() * direction - difference).norm(), 1e-7 * difference.norm());
  EXPECT_EQ((Eigen::MatrixXd(hessian.view()) - Eigen::MatrixXd(hessian.view()).transpose()).norm(), 0.0);
  // g is the gradient of the potential.
  EXPECT_NEAR(point.momentum_gradient.dot(direction), (plus.potential - minus.potential) / (2.0 * step),
              1e-7 * point.momentum_gradient.norm() * direction.norm());
}

TEST_F(StepProblemTest, WorkspaceLeavesNoTrace) {
  const Eigen::VectorXd velocities = simulator_.model().Gather(v_);
  StepWorkspace fresh;
  StepPoint expected, point;
  Problem(0.01, &fresh).Evaluate(velocities, &expected);
  StepWorkspace used;
  parameters_.material.stretch_stiffness *= 3.0;
  Problem(0.01, &used).Evaluate(velocities, &point);
  parameters_.material.stretch_stiffness /= 3.0;
  Problem(0.005, &used).Evaluate(velocities, &point);
  Problem(0.01, &used).Evaluate(velocities, &point);
  EXPECT_EQ(point.residual, expected.residual);
  EXPECT_EQ(point.potential, expected.potential);
  EXPECT_EQ(point.relative_residual, expected.relative_residual);
}

#ifdef CLOTHID_COUNTS_ALLOCATIONS
TEST_F(StepProblemTest, SecondStepAllocatesNothing) {
  const Eigen::VectorXd velocities = simulator_.model().Gather(v_);
  BlockMatrix hessian(simulator_.model().pattern());
  ContactSet contacts;
  StepPoint point;
  const auto step = [&] {
    const StepProblem problem = Problem(0.01, &simulator_.step_workspace());
    problem.Evaluate(velocities, &point);
    problem.AssembleHessian(HessianKind::kExact, point, &hessian);
    problem.FindContacts(point, &contacts);
  };
  const int before = num_allocations;
  step();
  EXPECT_GT(num_allocations, before);
  EXPECT_FALSE(contacts.nodes.empty());
  const int after_first = num_allocations;
  step();
  EXPECT_EQ(num_allocations, after_first);
}
#endif

// Of every law of a membrane, with bending and damping, large enough for threads to share.
TEST(SharedAssemblyTest, ThreadsDoNotChangeAByteOfTheHessian) {
  for (const Scene& scene : {FullScene(60, 40), Woven(FullScene(60, 40)), Knitted(FullScene(60, 40))}) {
    Simulator simulator(scene);
    ASSERT_GE(simulator.model().pattern()->num_values(), 1 << 17);
    const Parameters parameters = scene.nominal_parameters();
    const Eigen::VectorXd v = 0.3 * Eigen::VectorXd::Random(scene.initial_positions.size());
    const StepProblem problem(simulator.model(), parameters, {scene.initial_positions, v}, {0.01, 0.3},
                              &simulator.step_workspace());
    StepPoint point;
    problem.Evaluate(simulator.model().Gather(v), &point);
    for (const HessianKind kind : {HessianKind::kExact, HessianKind::kClamped}) {
      BlockMatrix alone(simulator.model().pattern()), shared = alone;
      problem.AssembleHessian(kind, point, &alone);
      for (const int num_threads : {2, 3}) {
        ThreadTeam team(num_threads);
        shared.values.setConstant(std::nan(""));
        problem.AssembleHessian(kind, point, &shared, &team);
        EXPECT_EQ(shared.values, alone.values) << num_threads;
      }
    }
  }
}

}  // namespace
}  // namespace clothid::step_problem_test
