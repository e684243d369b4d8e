// Every block of the linearised step against central differences of the residual of the step's own equations.
#include "sim/derivative/step_derivative.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <random>

#include "sim/cloth/cloth_model.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/step/step_problem.h"
#include "sim/step/step_solver.h"
#include "tests/sim/plain_scenes.h"

namespace clothid::step_derivative_test {
namespace {

// A cloth with two held corners that falls onto a ball: with bending, drag, wind and internal damping.
Scene BallScene() {
  Scene scene = ClothScene(SquareGrid(6, 0.4), 0.01);
  scene.initial_positions.reshaped(3, 36).row(2).array() += 0.01;
  scene.handles.nodes = {0, 5};
  scene.material = {0.2, 40.0, 1e-4, 0.1, 0.2};
  scene.wind.mean = {0.5, 0.2, 0.0};
  SceneObstacle ball;
  ball.name = "ball";
  ball.shape = std::make_shared<Sphere>(Eigen::Vector3d(0.2, 0.25, -0.2), 0.2);
  ball.friction_coefficient = 0.3;
  scene.obstacles.push_back(ball);
  return scene;
}

// One solved step (x_n, v_n) -> v, in which nodes stick, slip and fly.
class StepDerivativeTest : public ::testing::Test {
 protected:
  StepDerivativeTest() : simulator_(BallScene()), parameters_(simulator_.scene().nominal_parameters()) {
    const Rollout rollout = Simulate(parameters_, 60, &simulator_);
    EXPECT_TRUE(rollout.ok()) << rollout.failure->ToString();
    for (std::size_t i = 1; i < rollout.records.size() && !record_.is_kept(); ++i) {
      const StepRecord& record = rollout.records[i];
      if (Count(record, ContactBranch::kStick) < 2 || Count(record, ContactBranch::kSlip) < 2) continue;
      record_ = record;
      x_ = rollout.records[i - 1].positions;
      v_ = rollout.records[i - 1].velocities;
    }
    EXPECT_TRUE(record_.is_kept()) << "no step with enough contacts";
    solution_ = simulator_.model().Gather(record_.velocities);
    derivative_ = std::make_unique<StepDerivative>(record_, SolveStart{x_, v_}, parameters_, &simulator_);
    EXPECT_TRUE(derivative_->Factor(StepJacobian::Method::kLu));
  }

  static std::ptrdiff_t Count(const StepRecord& record, ContactBranch branch) {
    return std::count_if(record.contacts.nodes.begin(), record.contacts.nodes.end(),
                         [branch](const ContactRecord& contact) { return contact.branch == branch; });
  }

  int size() const { return 3 * simulator_.model().num_free(); }

  Eigen::VectorXd Random() {
    std::normal_distribution<double> normal;
    Eigen::VectorXd vector(size());
    for (double& value : vector) value = normal(generator_);
    return vector;
  }

  // Phi at v for another start and other parameters. The contacts stay in their branches.
  Eigen::VectorXd Residual(const Eigen::VectorXd& velocities, const Eigen::VectorXd& start_positions,
                           const Eigen::VectorXd& start_velocities, const Parameters& parameters) {
    const StepProblem problem(simulator_.model(), parameters, {start_positions, start_velocities}, record_.times(),
                              &simulator_.step_workspace());
    StepPoint point;
    problem.Evaluate(velocities, &point);
    EXPECT_EQ(NumDifferences(RecordContacts(problem.ContactsAt(point)), record_.contacts), 0);
    return point.residual;
  }

  // (Phi(s) - Phi(-s))/(2 s) of a residual along a line.
  static Eigen::VectorXd Difference(double s, const std::function<Eigen::VectorXd(double)>& residual) {
    return (residual(s) - residual(-s)) / (2.0 * s);
  }

  Eigen::VectorXd WithImpulse(Eigen::MatrixXd columns) {  // (I + S) y
    derivative_->jacobian().AddImpulse(&columns);
    return columns;
  }

  void ExpectNear(const Eigen::VectorXd& actual, const Eigen::VectorXd& expected) const {
    EXPECT_GT(expected.norm(), 0.0);
    EXPECT_LT((actual - expected).norm(), 1e-6 * expected.norm());
  }

  std::mt19937_64 generator_{5};
  Simulator simulator_;
  Parameters parameters_;
  StepRecord record_;
  Eigen::VectorXd x_, v_;     // of the start [3N]
  Eigen::VectorXd solution_;  // v [3 Nf]
  std::unique_ptr<StepDerivative> derivative_;
};

TEST_F(StepDerivativeTest, TheJacobianIsTheDerivativeByTheVelocity) {
  const Eigen::VectorXd right = Random();
  StepColumns dv;
  ASSERT_TRUE(derivative_->jacobian().Solve({right}, 1e-12, &dv));
  const Eigen::VectorXd direction = dv.velocities.col(0);
  ExpectNear(Difference(1e-6 / direction.norm(),
                        [&](double s) { return Residual(solution_ + s * direction, x_, v_, parameters_); }),
             right);
}

// Phi by x_n is (I + S) h (H + V) + X.
TEST_F(StepDerivativeTest, TheStartBlocksAreTheDerivativeByTheStartPositions) {
  const Eigen::VectorXd direction = Random();
  const Eigen::VectorXd all = simulator_.model().ScatterColumns(direction);
  const Eigen::VectorXd derivative =
      WithImpulse(derivative_->TimesStart(direction)) + derivative_->TimesFrames(direction).velocities.col(0);
  EXPECT_GT(derivative_->TimesFrames(direction).velocities.norm(), 1e-3 * derivative.norm());
  ExpectNear(derivative,
             Difference(1e-8, [&](double s) { return Residual(solution_, x_ + s * all, v_, parameters_); }));
}

TEST_F(StepDerivativeTest, TheMassIsTheDerivativeByTheStartVelocities) {
  const Eigen::VectorXd direction = Random();
  const Eigen::VectorXd all = simulator_.model().ScatterColumns(direction);
  ExpectNear(-WithImpulse(derivative_->TimesMass(direction)),
             Difference(1e-6, [&](double s) { return Residual(solution_, x_, v_ + s * all, parameters_); }));
}

TEST_F(StepDerivativeTest, TransposedBlocksAreTransposed) {
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(size(), size());
  const Eigen::MatrixXd start = derivative_->TimesStart(identity);
  const Eigen::MatrixXd frames = derivative_->TimesFrames(identity).velocities;
  EXPECT_LT((derivative_->TimesStartTransposed(identity) - start.transpose()).norm(), 1e-13 * start.norm());
  EXPECT_LT((derivative_->TimesFramesTransposed({identity}) - frames.transpose()).norm(), 1e-15 * frames.norm());
  EXPECT_GT((start - start.transpose()).norm(), 1e-6 * start.norm());  // by V, of internal damping
}

// Phi by theta is (I + S) dg/dtheta - dr/dtheta.
TEST_F(StepDerivativeTest, ParameterDerivativesAreDifferences) {
  for (const ParameterKind kind :
       {ParameterKind::kFriction, ParameterKind::kStretchStiffness, ParameterKind::kBendingStiffness,
        ParameterKind::kDensity, ParameterKind::kDrag, ParameterKind::kDamping}) {
    const ParameterId id{kind};
    const double value = GetParameter(parameters_, id);
    SCOPED_TRACE(static_cast<int>(kind));
    const auto residual = [&](double s) {
      Parameters changed = parameters_;
      SetParameter(id, value + s, &changed);
      return Residual(solution_, x_, v_, changed);
    };
    ExpectNear(WithImpulse(derivative_->MomentumDerivative(id)) - derivative_->ImpulseDerivative(id).velocities.col(0),
               Difference(1e-5 * value, residual));
  }
}

}  // namespace
}  // namespace clothid::step_derivative_test
