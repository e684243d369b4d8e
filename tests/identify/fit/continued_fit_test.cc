// A fit that ended beside its minimum goes on from the lower point that the check of its interval meets.
#include "identify/fit/continued_fit.h"

#include "datasets/motion/motion_file.h"
#include "identify/fit/fit.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::continued_fit_test {
namespace {

RecordedMotion NoisySwing() {
  MotionOptions options;
  options.true_values = {{"k_stretch", 150.0}};
  options.noise = options.sigma = 1e-3;
  return MakeMotion(SwingScene(), options);
}

FitOptions Options() {
  FitOptions options;
  options.parameters = {"k_stretch"};
  options.jacobian = JacobianMethod::kSensitivity;
  return options;
}

// As if a dent in the cost had held it: a fit that calls itself converged, so many standard deviations above the
// minimum at `estimate`.
FitSummary Dented(const FitSummary& fit, double stds, FitProblem* problem) {
  FitOptions options = Options();
  options.max_iterations = 0;
  options.precision = FitPrecision::kFull;
  const Eigen::VectorXd start = problem->StartCoordinates();
  problem->SetStart(fit.coordinates.array() + stds * fit.uncertainty->parameters[0].coordinate_std);
  FitSummary dented = Fit(options, problem);
  problem->SetStart(start);
  dented.status = FitStatus::kConverged;
  return dented;
}

TEST(ContinuedFitTest, AGoodFitIsLeftAlone) {
  FitProblem problem({NoisySwing()}, Options());
  const FitSummary summary = Fit(Options(), &problem);
  ASSERT_TRUE(summary.interval_check.has_value());
  EXPECT_EQ(summary.interval_check->better.size(), 0);
  EXPECT_GT(summary.interval_check->lowest_rise(), 3.0);
  EXPECT_EQ(summary.num_continuations, 0);
}

TEST(ContinuedFitTest, GoesOnFromALowerPoint) {
  FitProblem problem({NoisySwing()}, Options());
  const FitSummary good = Fit(Options(), &problem);
  FitSummary summary = Dented(good, 3.0, &problem);
  ASSERT_TRUE(summary.interval_check.has_value());
  ASSERT_EQ(summary.interval_check->better.size(), 1);
  EXPECT_LT(summary.interval_check->better[0], summary.coordinates[0]);
  EXPECT_LT(summary.interval_check->lowest_rise(), -0.2);
  const FitSummary before = summary;
  const Eigen::VectorXd start = problem.StartCoordinates();
  FitOptions options = Options();
  std::vector<int> told;
  options.on_iteration = [&](const FitIteration& row) { told.push_back(row.iteration); };
  ContinueFromLowerPoints(options, &problem, &summary);
  EXPECT_EQ(problem.StartCoordinates(), start);
  EXPECT_EQ(summary.status, FitStatus::kConverged);
  EXPECT_EQ(summary.num_continuations, 1);
  EXPECT_NEAR(summary.parameters[0].value, good.parameters[0].value, 1e-4 * good.parameters[0].value);
  EXPECT_TRUE(summary.interval_check->is_quadratic());
  EXPECT_EQ(summary.interval_check->better.size(), 0);
  // The start is that of the first fit, the work that of both, and the iterations are counted on.
  EXPECT_EQ(summary.parameters[0].start, before.parameters[0].start);
  EXPECT_EQ(summary.start_predicted[0], before.start_predicted[0]);
  EXPECT_GT(summary.statistics.rollouts, before.statistics.rollouts);
  EXPECT_GE(summary.total_seconds, before.total_seconds);
  for (std::size_t i = 1; i < summary.iterations.size(); ++i) {
    EXPECT_GT(summary.iterations[i].iteration, summary.iterations[i - 1].iteration);
    EXPECT_GE(summary.iterations[i].seconds, summary.iterations[i - 1].seconds);
    EXPECT_LE(summary.iterations[i].cost, summary.iterations[i - 1].cost);
  }
  ASSERT_FALSE(told.empty());
  EXPECT_EQ(told.front(), before.num_iterations() + 1);
}

// Frame 0 and the last four of `drape` alone: a hill of the cost lies between its minimum, where it is zero, and
// another one, and the interval of that reaches across.
TEST(ContinuedFitTest, GoesOnFromBehindAHill) {
  RecordedMotion motion = ReadMotion(std::string(CLOTHID_SOURCE_DIR) + "/datasets/drape.motion.bin", {});
  const std::vector<int> frames = {0, 77, 78, 79, 80};
  motion.times = motion.times(frames).eval();
  motion.positions = motion.positions(Eigen::all, frames).eval();
  FitOptions options;
  options.parameters = {"mu", "k_stretch"};
  options.overrides.start = {{"mu", 0.234}, {"k_stretch", 95.0}};
  options.jacobian = JacobianMethod::kSensitivity;
  options.function_tolerance = 1e-4;
  FitProblem problem({motion}, options);
  const FitSummary summary = Fit(options, &problem);
  ASSERT_EQ(summary.status, FitStatus::kConverged) << summary.message;
  EXPECT_EQ(summary.num_continuations, 1);
  EXPECT_NEAR(summary.parameters[0].value, 0.24, 1e-4);
  EXPECT_NEAR(summary.parameters[1].value, 70.0, 0.02);
}

TEST(ContinuedFitTest, NotMoreOftenThanItMay) {
  FitProblem problem({NoisySwing()}, Options());
  FitSummary summary = Dented(Fit(Options(), &problem), 3.0, &problem);
  const double cost = summary.cost;
  FitOptions options = Options();
  options.max_continuations = 0;
  ContinueFromLowerPoints(options, &problem, &summary);
  EXPECT_EQ(summary.cost, cost);
  EXPECT_EQ(summary.num_continuations, 0);
  options = Options();
  options.max_iterations = summary.num_iterations();
  ContinueFromLowerPoints(options, &problem, &summary);
  EXPECT_EQ(summary.cost, cost);
}

}  // namespace
}  // namespace clothid::continued_fit_test
