// Exit codes in their order, and what the words say.
#include "identify/verdict/verdict.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "identify/report/report.h"

namespace clothid {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

FitSummary Converged() {
  FitSummary summary;
  summary.status = FitStatus::kConverged;
  FittedParameter parameter;
  parameter.name = "mu";
  parameter.value = 0.3;
  summary.parameters = {parameter};
  summary.uncertainty.emplace();
  summary.uncertainty->parameters.resize(1);
  summary.uncertainty->parameters[0].identifiable = true;
  summary.uncertainty->parameters[0].std = 0.01;
  return summary;
}

bool Says(const FitSummary& summary, const FitChecks& checks, const std::string& words) {
  const std::vector<std::string> lines = Verdict(summary, checks);
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(words) != std::string::npos; });
}

TEST(VerdictTest, ExitCodesInTheirOrder) {
  FitChecks checks;
  FitSummary summary = Converged();
  EXPECT_EQ(FitExitCode(summary, checks), 0);
  checks.holdout = Holdout{0.2, 0.1, ""};
  EXPECT_EQ(FitExitCode(summary, checks), 5);
  summary.parameters[0].at_bound = true;
  EXPECT_EQ(FitExitCode(summary, checks), 4);
  summary.parameters[0].at_bound = false;
  summary.uncertainty->parameters[0].identifiable = false;
  EXPECT_EQ(FitExitCode(summary, checks), 4);
  summary.uncertainty.reset();
  EXPECT_EQ(FitExitCode(summary, checks), 4) << "nothing vouches for the estimate";
  summary.status = FitStatus::kNotConverged;
  EXPECT_EQ(FitExitCode(summary, checks), 3);
  summary.status = FitStatus::kInterrupted;
  EXPECT_EQ(FitExitCode(summary, checks), 130);
  EXPECT_EQ(FitExitCode(FitSummary(), FitChecks()), 3) << "a summary starts as a failure";
}

TEST(VerdictTest, HoldoutFailsWhereItIsWorseThanNominalOrCannotBePredicted) {
  EXPECT_FALSE((Holdout{0.1, 0.2, ""}).has_failed());
  EXPECT_TRUE((Holdout{0.2, 0.1, ""}).has_failed());
  EXPECT_TRUE((Holdout{kNaN, 0.1, "failed"}).has_failed());
  EXPECT_FALSE((Holdout{0.1, kNaN, "failed"}).has_failed()) << "better than a rollout that does not work";
  FitChecks checks;
  checks.holdout = Holdout{0.2, 0.1, ""};
  EXPECT_TRUE(Says(Converged(), checks, "worse than the nominal parameters, rmse 200 mm against 100 mm"));
}

TEST(VerdictTest, SaysWhatIsHiddenAndWhatStandsAtItsBound) {
  FitSummary summary = Converged();
  EXPECT_TRUE(Says(summary, {}, "every fitted parameter is identifiable"));
  summary.parameters[0].at_bound = true;
  EXPECT_TRUE(Says(summary, {}, "mu stands at its bound"));
  EXPECT_FALSE(Says(summary, {}, "every fitted parameter is identifiable"));
  summary = Converged();
  summary.uncertainty->parameters[0].identifiable = false;
  summary.uncertainty->hidden_directions.push_back({Eigen::VectorXd::Ones(1), 0.5, "mu"});
  EXPECT_TRUE(Says(summary, {}, "not identifiable: mu: moved from bound to bound, the prediction changes by 0.5"));
  EXPECT_NE(ResultTable(summary, {}).find("not identifiable"), std::string::npos);
}

TEST(VerdictTest, SaysWhereResidualsAreNotIndependent) {
  FitSummary summary = Converged();
  summary.uncertainty->residual_scale = 1.0;
  summary.error.successive_squares = 1.0;
  summary.error.successive_products = 0.6;
  EXPECT_TRUE(Says(summary, {}, "correlated from frame to frame (0.6)"));
  EXPECT_TRUE(Says(summary, {}, "too narrow by a factor of about 2"));
  summary.error.successive_products = 0.1;
  EXPECT_FALSE(Says(summary, {}, "correlated"));
}

TEST(VerdictTest, SaysByHowMuchIntervalsWereWidened) {
  FitSummary summary = Converged();
  summary.uncertainty->residual_scale = 1.0;
  summary.uncertainty->is_widened = true;
  summary.uncertainty->parameters[0].std = 0.1;
  summary.uncertainty->parameters[0].widening = 2.5;
  summary.error.successive_squares = 1.0;
  summary.error.successive_products = 0.6;
  EXPECT_TRUE(Says(summary, {}, "correlated from frame to frame (0.6)"));
  EXPECT_TRUE(Says(summary, {}, "wider than those of independent residuals by mu 2.5"));
  EXPECT_FALSE(Says(summary, {}, "too narrow"));
  summary.error.successive_products = 0.1;
  EXPECT_TRUE(Says(summary, {}, "residuals of one frame are correlated"));
}

TEST(VerdictTest, SaysWhereTheCostIsNotQuadratic) {
  FitSummary summary = Converged();
  summary.interval_check = IntervalCheck{0, 3.7, 4.0};
  EXPECT_FALSE(Says(summary, {}, "cannot be relied on"));
  summary.interval_check->rise_above = 120.0;
  EXPECT_TRUE(
      Says(summary, {}, "the interval of mu cannot be relied on: at its ends the cost rises by 3.7 and 1.2e+02"));
}

TEST(VerdictTest, SaysWhereAFitStoppedEarly) {
  FitSummary summary = Converged();
  summary.uncertainty->parameters[0].distance = 0.1;
  EXPECT_FALSE(Says(summary, {}, "stopped early"));
  summary.uncertainty->parameters[0].distance = 25.0;
  EXPECT_TRUE(Says(summary, {}, "mu is 25 standard deviations from the minimum of the quadratic model"));
}

FitChecks TwoMinima(double cost_rise) {
  FitChecks checks;
  checks.starts.emplace();
  StartResult start;
  start.status = FitStatus::kConverged;
  start.minimum = 0;
  checks.starts->starts = {start, start, start};
  checks.starts->starts[2].minimum = 1;
  checks.starts->minima = {{Eigen::VectorXd::Constant(1, 0.3), 1.0, 0.001, 2, 0.0},
                           {Eigen::VectorXd::Constant(1, 0.7), 4.0, 0.002, 1, cost_rise}};
  checks.starts->ambiguous = {!checks.starts->minima[1].is_distinguishable()};
  return checks;
}

TEST(VerdictTest, SaysWhyTheBetterMinimumIsPreferred) {
  const FitChecks checks = TwoMinima(6.0);
  EXPECT_EQ(FitExitCode(Converged(), checks), 0);
  EXPECT_TRUE(Says(Converged(), checks, "2 of 3 starts ended in the same minimum, rmse 1 mm: the preferred one"));
  EXPECT_TRUE(Says(Converged(), checks, "1 of 3 ended in another minimum, mu 0.7, rmse 2 mm: not preferred"));
  EXPECT_TRUE(Says(Converged(), checks, "4 times the lowest"));
}

TEST(VerdictTest, MinimaThatFitEquallyWellMakeAParameterUnidentifiable) {
  const FitChecks checks = TwoMinima(1.0);
  EXPECT_EQ(IsIdentifiable(Converged(), checks, 0), false);
  EXPECT_EQ(FitExitCode(Converged(), checks), 4);
  EXPECT_TRUE(Says(Converged(), checks, "cannot tell it from the preferred one"));
}

TEST(VerdictTest, SaysWhereContactsJumpBetweenObstacles) {
  FitSummary summary = Converged();
  summary.counts.branch_switches = 7;
  EXPECT_FALSE(Says(summary, {}, "obstacle"));
  summary.counts.obstacle_switches = 1;
  EXPECT_TRUE(Says(summary, {}, "at the estimate 1 contact jumps from one obstacle to another"));
  summary.counts.obstacle_switches = 12;
  EXPECT_TRUE(Says(summary, {}, "at the estimate 12 contacts jump from one obstacle to another: the cost has small"));
  EXPECT_EQ(FitExitCode(summary, {}), 0);
}

TEST(VerdictTest, SaysHowFarHalfTheStepMovesIt) {
  FitChecks checks;
  checks.step_check.emplace();
  checks.step_check->status = FitStatus::kConverged;
  checks.step_check->values = Eigen::VectorXd::Constant(1, 0.33);
  checks.step_check->changes = Eigen::VectorXd::Constant(1, 0.03);
  EXPECT_TRUE(Says(Converged(), checks, "at half the time step mu moves by 0.03 (10 %), 3 standard deviations"));
}

}  // namespace
}  // namespace clothid
