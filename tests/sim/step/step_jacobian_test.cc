// The step Jacobian A = (I + S) K - S D: the reduced method against LU, and the transpose against the matrix itself.
#include "sim/step/step_jacobian.h"

#include <gtest/gtest.h>

#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/step/step_problem.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid::step_jacobian_test {
namespace {

// Solves with A at every tenth step of the scene, for random right-hand sides.
class StepJacobianTest : public ::testing::TestWithParam<std::string> {
 protected:
  explicit StepJacobianTest(int nodes = 8, int num_steps = 0) : simulator_(ShippedScene(GetParam(), nodes)) {
    rollout_ = Simulate(simulator_.scene().nominal_parameters(),
                        num_steps == 0 ? simulator_.scene().num_steps() : num_steps, &simulator_);
  }

  // K and the contacts of record i.
  void SetPoint(std::size_t i, BlockMatrix* hessian, StepJacobian* jacobian) {
    const StepRecord& record = rollout_.records[i];
    const Eigen::VectorXd& start = i == 0 ? rollout_.initial_positions : rollout_.records[i - 1].positions;
    const ContactSet contacts = RestoreContacts(record, start, {}, rollout_.parameters, simulator_.model());
    HeldForces held;  // of the start nothing: no force of these scenes needs it
    simulator_.model().forces().Hold(rollout_.parameters, record.time, &held);
    AssembleStepHessian(simulator_.model(), HessianKind::kExact,
                        {rollout_.parameters, record.time_step, record.time, record.positions, record.velocities}, held,
                        hessian);
    jacobian->SetPoint(*hessian, contacts);
  }

  // The same, factored.
  void Factor(StepJacobian::Method method, std::size_t i, BlockMatrix* hessian, StepJacobian* jacobian) {
    SetPoint(i, hessian, jacobian);
    ASSERT_TRUE(jacobian->Factor(method));
  }

  Simulator simulator_;
  Rollout rollout_;
};

TEST_P(StepJacobianTest, ReducedSolvesWhatLuSolves) {
  ASSERT_TRUE(rollout_.ok()) << rollout_.failure->ToString();
  BlockMatrix hessian(simulator_.model().pattern());
  StepJacobian reduced(simulator_.model()), lu(simulator_.model());
  StepColumns dv, dv_lu, z, z_lu;
  Eigen::MatrixXd y, y_lu;
  for (size_t i = 0; i < rollout_.records.size(); i += 10) {
    const StepColumns right{Eigen::MatrixXd::Random(3 * simulator_.model().num_free(), 2)};
    const Eigen::MatrixXd& w = right.velocities;
    Factor(StepJacobian::Method::kReduced, i, &hessian, &reduced);
    Factor(StepJacobian::Method::kLu, i, &hessian, &lu);
    ASSERT_TRUE(reduced.Solve(right, 1e-13, &dv) && lu.Solve(right, 1e-13, &dv_lu));
    EXPECT_LT((dv.velocities - dv_lu.velocities).norm(), 1e-10 * dv_lu.velocities.norm());
    ASSERT_TRUE(reduced.SolveTransposed(right, 1e-13, &z, &y) && lu.SolveTransposed(right, 1e-13, &z_lu, &y_lu));
    EXPECT_LT((z.velocities - z_lu.velocities).norm(), 1e-10 * z_lu.velocities.norm());
    EXPECT_LE((y - y_lu).norm(), 1e-10 * y_lu.norm());
    // w . A^-1 u = A^-T w . u, and w . (S u) = (S^T w) . u in the form ((I + S)^T z) . u = z . ((I + S) u).
    EXPECT_NEAR(w.col(0).dot(dv.velocities.col(1)), z.velocities.col(0).dot(w.col(1)),
                1e-10 * dv.velocities.col(1).norm() * w.col(0).norm());
    Eigen::MatrixXd with_impulse = w;
    reduced.AddImpulse(&with_impulse);
    EXPECT_NEAR(y.col(0).dot(w.col(1)), z.velocities.col(0).dot(with_impulse.col(1)),
                1e-12 * z.velocities.norm() * w.norm());
  }
}

// Large enough that a factor of another point is taken in single precision.
class LargeStepJacobianTest : public StepJacobianTest {
 protected:
  LargeStepJacobianTest() : StepJacobianTest(26, 12) {}
};

TEST_P(LargeStepJacobianTest, AFactorOfAnotherPointSolvesToTheTolerance) {
  ASSERT_TRUE(rollout_.ok()) << rollout_.failure->ToString();
  BlockMatrix hessian(simulator_.model().pattern());
  StepJacobian lagged(simulator_.model()), direct(simulator_.model());
  StepColumns dv, expected, z, z_expected;
  Eigen::MatrixXd y, y_expected;
  for (const std::size_t last : {5u, 11u}) {
    Factor(StepJacobian::Method::kReduced, last, &hessian, &direct);
    Factor(StepJacobian::Method::kReduced, last - 1, &hessian, &lagged);
    ASSERT_GE(lagged.factor()->bytes(), 512u * 1024u);
    SetPoint(last, &hessian, &lagged);
    for (const int num_columns : {1, 3}) {
      const StepColumns right{1e-6 * Eigen::MatrixXd::Random(3 * simulator_.model().num_free(), num_columns)};
      ASSERT_TRUE(lagged.Solve(right, 1e-10, &dv) && direct.Solve(right, 1e-12, &expected));
      EXPECT_GT(lagged.iterations(), 0);
      EXPECT_LT((dv.velocities - expected.velocities).norm(), 1e-7 * expected.velocities.norm()) << num_columns;
      ASSERT_TRUE(lagged.SolveTransposed(right, 1e-10, &z, &y) &&
                  direct.SolveTransposed(right, 1e-12, &z_expected, &y_expected));
      EXPECT_LT((y - y_expected).norm(), 1e-7 * y_expected.norm()) << num_columns;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, LargeStepJacobianTest, ::testing::Values("drape", "slope", "wind"),
                         [](const auto& scene) { return scene.param; });

INSTANTIATE_TEST_SUITE_P(Scenes, StepJacobianTest, ::testing::Values("drape", "slope", "wind"),
                         [](const auto& scene) { return scene.param; });

}  // namespace
}  // namespace clothid::step_jacobian_test
