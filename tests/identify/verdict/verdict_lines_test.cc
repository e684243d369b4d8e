// What the lines of a verdict say beside the overall one: of intervals, minima, the discretisation and priors.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/identify/verdict/judged_fits.h"

namespace clothid::verdict_lines_test {
namespace {

using namespace judged_fits;

TEST(VerdictLinesTest, SaysWhereResidualsAreNotIndependent) {
  FitSummary summary = Converged();
  summary.uncertainty->residual_scale = 1.0;
  summary.error.successive_squares = 1.0;
  summary.error.successive_products = 0.6;
  EXPECT_TRUE(Says(summary, {}, "correlated from frame to frame (0.6)"));
  EXPECT_TRUE(Says(summary, {}, "too narrow by a factor of about 2"));
  EXPECT_EQ(Judge(summary, {}).line, "usable with care: residuals are correlated from frame to frame");
  summary.error.successive_products = 0.1;
  EXPECT_FALSE(Says(summary, {}, "correlated"));
}

TEST(VerdictLinesTest, SaysByHowMuchIntervalsWereWidened) {
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

TEST(VerdictLinesTest, SaysWhereTheCostIsNotQuadratic) {
  FitSummary summary = Converged();
  summary.interval_check = IntervalCheck{0, 3.7, 4.0, {}, {}};
  EXPECT_FALSE(Says(summary, {}, "cannot be relied on"));
  summary.interval_check->rise_above = 120.0;
  EXPECT_TRUE(
      Says(summary, {}, "the interval of mu cannot be relied on: at its ends the cost rises by 3.7 and 1.2e+02"));
}

TEST(VerdictLinesTest, SaysWhereAnEstimateDriftsWithTheMemory) {
  FitSummary summary = Converged();
  summary.assimilation.memory = 0.18;
  for (const double memory : {0.02, 0.06, 0.18}) summary.memory_trials.emplace_back().memory = memory;
  summary.uncertainty->parameters[0].memory_error = 0.019;  // below two standard deviations
  EXPECT_FALSE(Says(summary, {}, "drifts"));
  summary.uncertainty->parameters[0].memory_error = 0.03;
  EXPECT_TRUE(Says(summary, {}, "mu drifts by 10 % between 0.06 and 0.18 s of memory: the model errs otherwise in"));
  EXPECT_EQ(Judge(summary, {}).overall, Usability::kWithCare);
  summary.assimilation = {};  // rollouts without corrections have the last word
  EXPECT_FALSE(Says(summary, {}, "drifts"));
}

TEST(VerdictLinesTest, SaysWhereNoiseDoesNotExplainTheError) {
  RecordingFit recording = Recording(0.04, 1.0);
  recording.noise = 0.02;
  EXPECT_EQ(Judge(Converged(), With(recording)).overall, Usability::kUsable);
  recording.noise = 0.005;
  EXPECT_EQ(Judge(Converged(), With(recording)).line, "usable with care: the error is 8 times the noise");
  EXPECT_TRUE(Says(Converged(), With(recording), "rmse 40 mm against 5 mm"));
  recording.noise = kNaN;
  EXPECT_EQ(Judge(Converged(), With(recording)).overall, Usability::kUsable) << "nobody knows";
}

TEST(VerdictLinesTest, SaysWhereAnIntervalIsThatOfADent) {
  FitSummary summary = Converged();
  summary.dents = {DentCheck{0, 0.003, 1e6, 2e6, 5e5}};
  EXPECT_FALSE(Says(summary, {}, "one dent")) << "not quadratic, but no dent";
  summary.dents[0].rise_above = -40.0;
  EXPECT_EQ(Judge(summary, {}).line, "usable with care: the interval of mu is that of one dent of a rough cost");
  EXPECT_TRUE(Says(summary, {}, "1 % below and above it the cost rises by 2e+06 and -40 instead of 1e+06"));
  EXPECT_NE(ResultTable(summary, {}).find("one dent"), std::string::npos);
  RecordingFit recording = Recording(0.04, 1.0);
  recording.noise = 0.005;
  EXPECT_EQ(Judge(summary, With(recording)).line.find("usable with care: the interval of mu is that of one dent"), 0u)
      << "more than any other doubt";
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

TEST(VerdictLinesTest, SaysWhyTheBetterMinimumIsPreferred) {
  const FitChecks checks = TwoMinima(6.0);
  EXPECT_EQ(FitExitCode(Converged(), checks), 0);
  EXPECT_TRUE(Says(Converged(), checks, "2 of 3 starts ended in the same minimum, rmse 1 mm: the preferred one"));
  EXPECT_TRUE(Says(Converged(), checks, "1 of 3 ended in another minimum, mu 0.7, rmse 2 mm: not preferred"));
  EXPECT_TRUE(Says(Converged(), checks, "4 times the lowest"));
}

TEST(VerdictLinesTest, MinimaThatFitEquallyWellMakeAParameterUnidentifiable) {
  const FitChecks checks = TwoMinima(1.0);
  EXPECT_EQ(IsIdentifiable(Converged(), checks, 0), false);
  EXPECT_EQ(FitExitCode(Converged(), checks), 4);
  EXPECT_TRUE(Says(Converged(), checks, "cannot tell it from the preferred one"));
}

TEST(VerdictLinesTest, SaysWhereContactsJumpBetweenObstacles) {
  FitSummary summary = Converged();
  summary.counts.branch_switches = 7;
  EXPECT_FALSE(Says(summary, {}, "obstacle"));
  summary.counts.obstacle_switches = 1;
  EXPECT_TRUE(Says(summary, {}, "at the estimate 1 contact jumps from one obstacle to another"));
  summary.counts.obstacle_switches = 12;
  EXPECT_TRUE(Says(summary, {}, "at the estimate 12 contacts jump from one obstacle to another: the cost has small"));
  EXPECT_EQ(FitExitCode(summary, {}), 0);
}

// An estimate of 0.3 +- 0.01 whose errors of step and mesh are known.
FitSummary Discretized(double step_error, double mesh_error) {
  FitSummary summary = Converged();
  summary.uncertainty->parameters[0].step_error = step_error;
  summary.uncertainty->parameters[0].mesh_error = mesh_error;
  return summary;
}

FitChecks WithDiscretization(FitStatus half_step, FitStatus fine_mesh) {
  FitChecks checks;
  checks.discretization.emplace();
  checks.discretization->half_step.emplace().status = half_step;
  checks.discretization->fine_mesh.emplace().status = fine_mesh;
  return checks;
}

TEST(VerdictLinesTest, SaysWhatIsTheLargestOfNoiseStepAndMesh) {
  const FitChecks checks = WithDiscretization(FitStatus::kConverged, FitStatus::kConverged);
  FitSummary summary = Discretized(0.03, 0.02);
  EXPECT_TRUE(Says(summary, checks,
                   "mu is 0.3 +- 0.01 from noise, +- 0.03 from the time step (no clear order), +- 0.02 from the mesh; "
                   "halve the step before you collect more data"));
  EXPECT_EQ(Judge(summary, checks).line, "usable with care: the error of the time step exceeds the noise");
  EXPECT_EQ(FitExitCode(summary, checks), 0);
  summary.uncertainty->parameters[0].step_order = 1.52;
  EXPECT_TRUE(Says(summary, checks, "+- 0.03 from the time step (order 1.5), +-"));

  summary = Discretized(0.005, 0.015);
  EXPECT_TRUE(Says(summary, checks, "+- 0.015 from the mesh; refine the mesh before you collect more data"));
  EXPECT_EQ(Judge(summary, checks).overall, Usability::kUsable) << "less than two deviations of the noise";
  EXPECT_FALSE(Says(Discretized(0.005, 0.002), checks, "before you collect more data"));
  EXPECT_FALSE(Says(Discretized(0.005, kNaN), checks, "mesh"));
  EXPECT_FALSE(Says(summary, {}, "from noise")) << "nobody asked";

  summary = Discretized(0.002, kNaN);
  summary.uncertainty->parameters[0].std = 1e-6;
  EXPECT_EQ(Judge(summary, checks).overall, Usability::kUsable) << "below 1 % of the value";
}

// Of one rollout, which nobody asked for: told beside the estimate, and in words where it asks for care.
TEST(VerdictLinesTest, SaysWhatOneRolloutTellsOfTheStep) {
  FitChecks checks;
  checks.step_error.errors = {0.03};
  FitSummary summary = Discretized(0.03, kNaN);
  EXPECT_TRUE(Says(summary, checks, "mu is 0.3 +- 0.01 from noise, +- 0.03 from the time step (no clear order)"));
  EXPECT_EQ(Judge(summary, checks).line, "usable with care: the error of the time step exceeds the noise");
  EXPECT_EQ(FitExitCode(summary, checks), 0);
  EXPECT_EQ(ParameterRemark(summary, checks, 0), "noise +- 0.01, step +- 0.03");
  summary.parameters[0].is_knot = true;
  EXPECT_FALSE(Says(summary, checks, "from noise")) << "knots are many";
  EXPECT_EQ(ParameterRemark(Discretized(0.009, kNaN), checks, 0), "");
  EXPECT_EQ(ParameterRemark(Discretized(0.009, 0.02), checks, 0), "noise +- 0.01, step +- 0.009, mesh +- 0.02");
  EXPECT_FALSE(Says(Discretized(0.015, kNaN), checks, "from noise"));

  checks = WithDiscretization(FitStatus::kConverged, FitStatus::kConverged);
  checks.discretization->half_step->values = Eigen::VectorXd::Constant(1, 0.29);
  checks.step_error.errors = {0.025};
  EXPECT_TRUE(Says(Discretized(0.03, kNaN), checks, "time step (no clear order; one rollout said +- 0.025); halve"));
  checks = WithDiscretization(FitStatus::kFailed, FitStatus::kConverged);
  checks.step_error.errors = {0.03};
  EXPECT_TRUE(Says(Discretized(0.03, kNaN), checks, "intervals count with what one rollout says of the time step"));

  checks = FitChecks();
  checks.step_error.failure = "drape: step 3 failed";
  EXPECT_TRUE(Says(Converged(), checks, "intervals do not count with the time step: at another one, drape: step 3"));
  EXPECT_EQ(Judge(Converged(), checks).overall, Usability::kUsable);
}

TEST(VerdictLinesTest, SaysWhereAFitOfTheDiscretizationFailed) {
  const FitSummary summary = Discretized(kNaN, 0.001);
  FitChecks checks = WithDiscretization(FitStatus::kFailed, FitStatus::kConverged);
  EXPECT_EQ(Judge(summary, checks).line, "usable with care: the fit at half the time step ended as failed");
  EXPECT_TRUE(Says(summary, checks, "intervals do not count with the time step"));
  checks = WithDiscretization(FitStatus::kConverged, FitStatus::kNotConverged);
  checks.discretization->fine_mesh->values = Eigen::VectorXd::Constant(1, 0.3);
  EXPECT_TRUE(Says(summary, checks, "the fit on the finer mesh ended as not_converged: the error of the mesh may be"));
  checks = FitChecks();
  checks.discretization.emplace().double_step.emplace().status = FitStatus::kFailed;
  EXPECT_EQ(Judge(Converged(), checks).overall, Usability::kUsable) << "which tells the order, and nothing else";
}

// Of mu, believed to be 0.3 +- 0.1 beforehand.
FitSummary WithPrior(const ToldBesidePrior& told) {
  FitSummary summary = Converged();
  summary.parameters[0].prior = {0.3, 0.1};
  summary.uncertainty->residual_scale = 1.0;
  summary.uncertainty->parameters[0].beside_prior = told;
  summary.uncertainty->parameters[0].identifiable = told.is_told;
  return summary;
}

TEST(VerdictLinesTest, SaysWhatParametersOweToTheirPriors) {
  ToldBesidePrior told;
  told.share = 0.97;
  FitSummary summary = WithPrior(told);
  summary.uncertainty->parameters[0].visible = false;
  Verdict verdict = Judge(summary, {});
  EXPECT_EQ(verdict.line, "usable with care: the recording adds nothing to what was believed of mu");
  EXPECT_TRUE(Says(summary, {}, "its standard deviation is 0.97 of that of the prior, 0.3 +- 0.1"));
  EXPECT_EQ(verdict.exit_code, kExitSuccess) << "the answer is what was believed, as that of a frozen parameter is";
  EXPECT_EQ(ParameterRemark(summary, {}, 0), "as believed");
  EXPECT_TRUE(HasInterval(summary, {}, 0));
  EXPECT_EQ(PriorRemark(summary, 0),
            "0.3 +- 0.1; the recording adds nothing: the standard deviation is 0.97 of the prior's");
  EXPECT_NE(ResultTable(summary, {}).find("\nprior           mu 0.3 +- 0.1; "), std::string::npos);

  told.share = 0.5;
  summary = WithPrior(told);
  EXPECT_EQ(Judge(summary, {}).line, "usable with care: mu is not identifiable without its prior");
  EXPECT_EQ(ParameterRemark(summary, {}, 0), "by its prior");

  told.is_told = true;
  summary = WithPrior(told);
  EXPECT_EQ(Judge(summary, {}).line, "usable: every fitted parameter is identifiable");
  EXPECT_EQ(ParameterRemark(summary, {}, 0), "");
}

TEST(VerdictLinesTest, SaysWherePriorAndRecordingDisagree) {
  ToldBesidePrior told;
  told.share = 0.1;
  told.is_told = true;
  told.other_value = 0.8;
  told.disagreement = 2.9;
  EXPECT_EQ(Judge(WithPrior(told), {}).overall, Usability::kUsable);
  told.disagreement = 4.2;
  const Verdict verdict = Judge(WithPrior(told), {});
  EXPECT_EQ(verdict.line, "usable with care: the recording contradicts the prior of mu");
  EXPECT_EQ(verdict.reasons.front(),
            "the recording contradicts the prior of mu: without the prior it would be about 0.8, 4.2 joint standard "
            "deviations from 0.3 +- 0.1");
}

TEST(VerdictLinesTest, SaysWherePriorsHaveTheWrongWeight) {
  ToldBesidePrior told;
  told.is_told = true;
  told.share = 0.1;
  FitSummary summary = WithPrior(told);
  summary.uncertainty->residual_scale = 5.0;
  EXPECT_TRUE(Says(summary, {}, "priors count for less than they are worth"));
  summary.uncertainty->residual_scale = 1.9;
  EXPECT_FALSE(Says(summary, {}, "they are worth"));
  summary.uncertainty->residual_scale = 0.01;
  EXPECT_TRUE(Says(summary, {}, "priors count for more than they are worth"));
  summary.parameters[0].prior = {};
  summary.uncertainty->parameters[0].beside_prior.reset();
  EXPECT_FALSE(Says(summary, {}, "they are worth"));
}

}  // namespace
}  // namespace clothid::verdict_lines_test
