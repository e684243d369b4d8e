// The ways to solve A^T z = w in a reverse sweep: all give the gradient of LU as exactly as their threshold says, and
// where the iteration of the paper fails, LU steps in and the count says so.
#include <gtest/gtest.h>

#include <string>
#include <tuple>

#include "sim/cloth/cloth_model.h"
#include "sim/cloth/system_matrix.h"
#include "sim/derivative/adjoint.h"
#include "sim/rollout/simulator.h"
#include "sim/step/step_problem.h"
#include "tools/benchmark/derivatives/backprop_case.h"

namespace clothid {
namespace {

constexpr AdjointMethod kIterative[] = {AdjointMethod::kFixedPoint, AdjointMethod::kSystemGmres,
                                        AdjointMethod::kReduced};

// By scene and setting, on 8 x 8 nodes.
class AdjointMethodsTest : public ::testing::TestWithParam<std::tuple<std::string, std::string>> {
 protected:
  AdjointMethodsTest()
      : backprop_({std::get<0>(GetParam()), std::get<1>(GetParam()), 8, 15}),
        reference_(backprop_.Differentiate({AdjointMethod::kLu})) {}

  double Error(AdjointMethod method, double threshold) {
    return backprop_.Compare(backprop_.Differentiate({method, threshold}), reference_).Worst();
  }

  BackpropCase backprop_;
  RolloutGradient reference_;
};

TEST_P(AdjointMethodsTest, DirectSolversAgree) {
  const RolloutGradient gradient = backprop_.Differentiate({AdjointMethod::kSparseLu});
  EXPECT_LE(backprop_.Compare(gradient, reference_).Worst(), 1e-10);
  EXPECT_EQ(gradient.work.iterations, 0);
  EXPECT_EQ(gradient.work.failed_solves, 0);
  EXPECT_EQ(gradient.work.solves, 15);
}

// The error of a gradient is the threshold times a factor of the scene: what a residual amounts to in z, summed over
// the steps. The factor is the same for all thresholds, up to where LU steps in; the largest seen is 1.05e3.
TEST_P(AdjointMethodsTest, TheErrorFollowsTheThreshold) {
  for (const AdjointMethod method : kIterative) {
    for (const double threshold : {1e-4, 1e-6, 1e-10}) {
      EXPECT_LE(Error(method, threshold), 2e3 * threshold) << static_cast<int>(method);
    }
  }
}

TEST_P(AdjointMethodsTest, ColumnsOfABlockAreSolvedAsIfAlone) {
  for (const AdjointMethod method : kIterative) {
    const RolloutGradient block = backprop_.Differentiate({method, 1e-10}, 3);
    const RolloutGradient reference = backprop_.Differentiate({AdjointMethod::kLu}, 3);
    EXPECT_LE((block.initial_positions - reference.initial_positions).norm(), 1e-7 * reference.initial_positions.norm())
        << static_cast<int>(method);
  }
}

TEST_P(AdjointMethodsTest, PhasesArePartsOfTheTotal) {
  for (const AdjointMethod method : {AdjointMethod::kReduced, AdjointMethod::kLu, AdjointMethod::kSparseLu,
                                     AdjointMethod::kFixedPoint, AdjointMethod::kSystemGmres}) {
    const AdjointWork work = backprop_.Differentiate({method, 1e-6, /*use_kept_factors=*/false}).work;
    EXPECT_GT(work.phases.assembly, 0.0);
    EXPECT_GT(work.phases.factorization, 0.0);
    EXPECT_GT(work.phases.solution, 0.0);
    EXPECT_GE(work.other_seconds(), 0.0);
    EXPECT_EQ(work.fallback_seconds > 0.0, work.failed_solves > 0);
  }
}

std::string CaseName(const ::testing::TestParamInfo<std::tuple<std::string, std::string>>& info) {
  return std::get<0>(info.param) + "_" + std::get<1>(info.param);
}

INSTANTIATE_TEST_SUITE_P(Cases, AdjointMethodsTest,
                         ::testing::Combine(::testing::Values("wind", "slope", "sphere"),
                                            ::testing::Values("soft", "realistic")),
                         CaseName);

TEST(FixedPointTest, ConvergesOnSoftCloth) {
  for (const std::string scene : {"wind", "slope", "sphere"}) {
    BackpropCase backprop({scene, "soft", 12, 10});
    const AdjointWork work = backprop.Differentiate({AdjointMethod::kFixedPoint, 1e-6}).work;
    EXPECT_EQ(work.failed_solves, 0) << scene;
    EXPECT_EQ(work.solves, 10) << scene;
    EXPECT_GT(work.iterations, 10) << scene;
    EXPECT_EQ(work.fallback_seconds, 0.0) << scene;
  }
}

TEST(FixedPointTest, FailsOnStiffClothWhereLuStepsIn) {
  BackpropCase backprop({"wind", "realistic", 12, 10});
  const RolloutGradient reference = backprop.Differentiate({AdjointMethod::kLu});
  const RolloutGradient gradient = backprop.Differentiate({AdjointMethod::kFixedPoint, 1e-6});
  EXPECT_EQ(gradient.work.failed_solves, 10);
  EXPECT_GT(gradient.work.fallback_seconds, 0.0);
  EXPECT_LE(backprop.Compare(gradient, reference).Worst(), 1e-10);
  EXPECT_EQ(backprop.Differentiate({AdjointMethod::kSystemGmres, 1e-6}).work.failed_solves, 0);
}

TEST(AdjointThresholdTest, IsThatOfTheSceneUnlessGiven) {
  Scene scene = MakeBenchmarkScene("sphere", 8, 20.0, 0.005);
  scene.solver.adjoint_tolerance = 1e-3;
  Simulator simulator(scene);
  const Rollout rollout = Simulate(scene.nominal_parameters(), 20, &simulator);
  ASSERT_TRUE(rollout.ok()) << rollout.failure->ToString();
  const auto iterations = [&](std::optional<double> threshold) {
    const auto seed = [&](int step, Eigen::MatrixXd* gradient) { gradient->col(0) += rollout.positions(step); };
    return PullBack(rollout, {}, 1, seed, &simulator, {AdjointMethod::kFixedPoint, threshold}).work.iterations;
  };
  EXPECT_EQ(iterations(std::nullopt), iterations(1e-3));
  EXPECT_LT(iterations(std::nullopt), iterations(1e-6));
}

// P of a cloth with every term: its diagonal is the d of the contact law, its rows sum to M + h C, as L and Q do not
// see a shift, and the factor is that of P on each axis.
TEST(SystemMatrixTest, HasTheTermsOfTheStep) {
  Scene scene = MakeBenchmarkScene("sphere", 6, 50.0, 0.01);
  scene.material.drag = 0.3;
  scene.material.damping = 0.2;
  const double h = scene.time_step;
  Simulator simulator(scene);
  const ClothModel& model = simulator.model();
  const Eigen::SparseMatrix<double> matrix = AssembleSystemMatrix(model, scene.material, h);
  const Parameters parameters = scene.nominal_parameters();
  const StepProblem problem(model, parameters, scene.initial_positions, scene.initial_velocities, h, h,
                            &simulator.step_workspace());
  ASSERT_EQ(static_cast<int>(problem.candidates().size()), model.num_nodes());
  for (int i = 0; i < model.num_nodes(); ++i) {
    const double weight = problem.weight(i);
    EXPECT_NEAR(matrix.coeff(problem.free_block(i), problem.free_block(i)), weight, 1e-14 * weight);
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
}  // namespace clothid
