// The ways to solve A^T z = w in a reverse sweep: all give the gradient of LU as exactly as their threshold says, and
// where the iteration of the paper fails, LU steps in and the count says so.
#include <gtest/gtest.h>

#include <string>
#include <tuple>

#include "sim/derivative/adjoint.h"
#include "sim/rollout/simulator.h"
#include "tools/benchmark/derivatives/backprop_case.h"

namespace clothid::adjoint_methods_test {
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

TEST_P(AdjointMethodsTest, LuTakesNoIterations) {
  EXPECT_EQ(reference_.work.iterations, 0);
  EXPECT_EQ(reference_.work.failed_solves, 0);
  EXPECT_EQ(reference_.work.solves, 15);
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
  for (const AdjointMethod method :
       {AdjointMethod::kReduced, AdjointMethod::kLu, AdjointMethod::kFixedPoint, AdjointMethod::kSystemGmres}) {
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

}  // namespace
}  // namespace clothid::adjoint_methods_test
