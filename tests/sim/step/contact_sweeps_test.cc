// The sweeps against the equations of the nodes, put together here from whole products.
#include "sim/step/contact_sweeps.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "sim/matrix/block_product.h"
#include "sim/rollout/simulator.h"

namespace clothid::contact_sweeps_test {
namespace {

// A soft sheet one millimetre above a tilted plane.
Scene SheetOverPlane() {
  GridOptions grid;
  grid.nodes = {9, 7};
  grid.size = {0.4, 0.3};
  Scene scene;
  scene.mesh = MakeGrid(grid);
  scene.initial_positions = scene.mesh.rest_positions.reshaped();
  scene.initial_velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
  scene.material.stretch_stiffness = 10.0;
  scene.material.bending_stiffness = 1e-4;
  SceneObstacle plane;
  plane.name = "plane";
  plane.friction_coefficient = 0.3;
  plane.shape = std::make_shared<Plane>(Eigen::Vector3d(0.0, 0.0, -0.001), Eigen::Vector3d(0.1, 0.0, 1.0).normalized());
  scene.obstacles.push_back(plane);
  return scene;
}

class ContactSweepsTest : public ::testing::Test {
 protected:
  // A step that starts at mean velocity `normal_speed` off the plane, and any other by the node.
  explicit ContactSweepsTest(double normal_speed = -1.0) : simulator_(SheetOverPlane()) { Start(normal_speed); }

  void Start(double normal_speed) {
    std::mt19937_64 generator(5);
    std::normal_distribution<double> normal;
    velocities_.resize(simulator_.scene().initial_positions.size());
    for (double& value : velocities_) value = 0.3 * normal(generator);
    for (Eigen::Index i = 2; i < velocities_.size(); i += 3) velocities_[i] += normal_speed;
    problem_ = std::make_unique<StepProblem>(simulator_.model(), parameters_,
                                             SolveStart{simulator_.scene().initial_positions, velocities_},
                                             SolveTimes{0.01, 0.01}, &simulator_.step_workspace());
    problem_->Evaluate(problem_->start_velocities(), &point_);
    problem_->AssembleHessian(HessianKind::kExact, point_, &hessian_);
  }

  // |g + K dv - r| over the nodes that are in contact at the start.
  double ModelResidual(const Eigen::VectorXd& direction) const {
    const Eigen::VectorXd momentum = point_.momentum_gradient + MultiplySymmetric(hessian_, direction).col(0);
    double square = 0.0;
    for (size_t i = 0; i < problem_->contacts().candidates().size(); ++i) {
      if (point_.responses[i].branch == ContactBranch::kTakeOff) continue;
      const ContactCandidate& candidate = problem_->contacts().candidates()[i];
      const int index = static_cast<int>(i), row = 3 * problem_->contacts().free_block(index);
      const Eigen::Vector3d g = momentum.segment<3>(row);
      const Eigen::Vector3d v = (point_.velocities + direction).segment<3>(row);
      const Eigen::Vector3d force =
          problem_->contacts().weight(index) * (v + candidate.gap_speed * candidate.normal) - g;
      const double mu = problem_->friction_coefficient(index);
      square += (g - EvaluateContactLaw(force, candidate.normal, mu).impulse).squaredNorm();
    }
    return std::sqrt(square);
  }

  Simulator simulator_;
  Parameters parameters_ = simulator_.scene().nominal_parameters();
  Eigen::VectorXd velocities_;
  std::unique_ptr<StepProblem> problem_;
  BlockMatrix hessian_{simulator_.model().pattern()};
  StepPoint point_;
  ContactSweeps sweeps_;
};

TEST_F(ContactSweepsTest, SolveTheEquationsOfNodesInContact) {
  Eigen::VectorXd direction = Eigen::VectorXd::Zero(point_.velocities.size());
  const double before = ModelResidual(direction);
  ASSERT_TRUE(sweeps_.Correct(*problem_, hessian_, point_, 0.1, &direction));
  EXPECT_LT(ModelResidual(direction), 0.1 * before);
}

// What holds already stays, to the last bit.
TEST_F(ContactSweepsTest, KeepASolution) {
  Eigen::VectorXd direction = Eigen::VectorXd::Zero(point_.velocities.size());
  int num_corrections = 0;
  while (num_corrections < 60 && sweeps_.Correct(*problem_, hessian_, point_, 1e-9, &direction)) ++num_corrections;
  EXPECT_GT(num_corrections, 1);
  EXPECT_LT(num_corrections, 60);
  EXPECT_LT(ModelResidual(direction), 1e-9 * point_.residual.norm());
  Eigen::VectorXd further = direction;
  EXPECT_FALSE(sweeps_.Correct(*problem_, hessian_, point_, 1e-9, &further));
  EXPECT_EQ(further, direction);
}

TEST_F(ContactSweepsTest, LeaveADirectionAloneThatTouchesNothing) {
  Start(5.0);
  const Eigen::VectorXd direction = Eigen::VectorXd::Constant(point_.velocities.size(), 1e-3);
  Eigen::VectorXd corrected = direction;
  EXPECT_FALSE(sweeps_.Correct(*problem_, hessian_, point_, 0.1, &corrected));
  EXPECT_EQ(corrected, direction);
}

}  // namespace
}  // namespace clothid::contact_sweeps_test
