// Which blocks a fit has, and what they share.
#include "identify/problem/problem.h"

#include <gtest/gtest.h>

#include "identify/fit/stage_rows.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"

namespace clothid::problem_test {
namespace {

std::vector<std::string> Names(const FitProblem& problem) {
  std::vector<std::string> names;
  for (const ParameterBlock& block : problem.blocks()) names.push_back(block.name);
  return names;
}

TEST(FitProblemTest, FitsWhatTheSceneSuggests) {
  EXPECT_EQ(Names(FitProblem({MakeMotion(SphereScene(), {})}, {})), (std::vector<std::string>{"mu", "k_stretch"}));
  EXPECT_EQ(Names(FitProblem({MakeMotion(SwingScene(), {})}, {})), (std::vector<std::string>{"k_stretch"}));
}

TEST(FitProblemTest, SharesBlocksBetweenRecordings) {
  FitOptions options;
  options.parameters = {"k_stretch", "mu.ball"};
  FitProblem problem({MakeMotion(SwingScene(), {}), MakeMotion(SphereScene(), {})}, options);
  EXPECT_EQ(problem.block_indices(0), std::vector<int>{0});
  EXPECT_EQ(problem.block_indices(1), (std::vector<int>{0, 1}));
  Eigen::VectorXd coordinates = problem.StartCoordinates();
  FitEvaluator evaluator(&problem, 1);
  const UnknownBasis basis = MakeBasis(problem, false, 0);
  FreshRows rows(problem, basis, coordinates, Precision::kFull, false, &evaluator);
  Eigen::VectorXd free = rows.FreeCoordinates(coordinates);
  const auto ceres_problem = rows.MakeCeresProblem(free.data());
  EXPECT_EQ(ceres_problem->NumParameters(), 2);
  EXPECT_EQ(ceres_problem->NumResiduals(), problem.cost(0).num_residuals() + problem.cost(1).num_residuals());
  EXPECT_DOUBLE_EQ(ceres_problem->GetParameterUpperBound(free.data(), 1), 2.0);
  EXPECT_NEAR(problem.Values(coordinates)[0], 50.0, 1e-12);
}

TEST(FitProblemTest, FrozenBlocksAreConstant) {
  RecordedMotion motion = MakeMotion(SphereScene(), {});
  motion.scene.parameters["mu"].frozen = true;
  FitProblem problem({motion}, {});
  Eigen::VectorXd coordinates = problem.StartCoordinates();
  FitEvaluator evaluator(&problem, 1);
  const UnknownBasis basis = MakeBasis(problem, false, 0);
  const FreshRows rows(problem, basis, coordinates, Precision::kFull, false, &evaluator);
  EXPECT_EQ(rows.free(), std::vector<int>{1});
}

TEST(FitProblemTest, RefusesContradictions) {
  const std::vector<RecordedMotion> motions = {MakeMotion(SphereScene(), {})};
  const auto expect = [&](const FitOptions& options, const char* culprit) {
    ExpectError([&] { FitProblem(motions, options); }, ErrorKind::kUsage, {culprit});
  };
  ExpectError([] { FitProblem({}, {}); }, ErrorKind::kUsage, {"--target"});
  FitOptions options;
  options.parameters = {"mu", "mu.ball"};
  expect(options, "mu.ball");
  options.parameters = {"mu.ghost"};
  expect(options, "mu.ghost");
  options.parameters = {"mu"};
  options.overrides.start["k_stretch"] = 1.0;
  expect(options, "--start: 'k_stretch'");
  std::vector<RecordedMotion> frozen = motions;
  frozen[0].scene.parameters["mu"].frozen = true;
  options.overrides.start.clear();
  ExpectError([&] { FitProblem(frozen, options); }, ErrorKind::kUsage, {"frozen"});
}

}  // namespace
}  // namespace clothid::problem_test
