// Whether an answer can be used: the overall line, exit codes in their order, and what must not be used.
#include "identify/verdict/verdict.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "sim/fabric/fabric.h"
#include "tests/identify/verdict/judged_fits.h"

namespace clothid::verdict_test {
namespace {

using namespace judged_fits;

TEST(VerdictTest, TheOverallLineLeads) {
  const Verdict verdict = Judge(Converged(), {});
  EXPECT_EQ(verdict.overall, Usability::kUsable);
  EXPECT_EQ(verdict.line, "usable: every fitted parameter is identifiable");
  EXPECT_EQ(verdict.Lines(), (std::vector<std::string>{verdict.line}));
  EXPECT_EQ(Judge(FitSummary(), {}).line, "do not use: failed: the fit was not run");
  FitSummary interrupted = Converged();
  interrupted.status = FitStatus::kInterrupted;
  interrupted.message = "interrupted";
  EXPECT_EQ(Judge(interrupted, {}).Lines(), (std::vector<std::string>{"do not use: interrupted"}));
  interrupted.status = FitStatus::kNotConverged;
  interrupted.message = "stopped at max_iterations";
  EXPECT_EQ(Judge(interrupted, {}).line, "do not use: not converged: stopped at max_iterations");
}

TEST(VerdictTest, EnergyFromNowhereIsNamed) {
  FitChecks checks = With(Recording(0.001, 0.1));
  checks.energy = {{0.05, 0.2, 100.0}};
  EXPECT_EQ(Judge(Converged(), checks).line, "usable: every fitted parameter is identifiable");
  checks.energy = {{2.0, 0.2, 100.0}};
  EXPECT_EQ(Judge(Converged(), checks).overall, Usability::kWithCare);
  EXPECT_TRUE(Says(Converged(), checks, "gains energy that no work pays for, 2 J by 0.2 s, 2 % of the largest"));
  checks.energy = {{20.0, 0.2, 100.0}};
  EXPECT_EQ(Judge(Converged(), checks).overall, Usability::kDoNotUse);
  EXPECT_EQ(Judge(Converged(), checks).exit_code, kExitDoNotUse);
}

TEST(VerdictTest, AClothThatMeetsItselfIsNamed) {
  FitChecks checks = With(Recording(0.001, 0.1));
  SelfContactAudit audit;
  audit.num_states = 81;
  audit.violation = 1.2e-4;
  checks.self_contact = {audit};
  EXPECT_EQ(Judge(Converged(), checks).line, "usable: every fitted parameter is identifiable");
  EXPECT_TRUE(Says(Converged(), checks, "stays out of itself, and comes nearer than its thickness by 0.12 mm at most"));
  checks.self_contact[0].dependent_steps = 3;
  EXPECT_EQ(Judge(Converged(), checks).line,
            "usable with care: derivatives are not promised in 3 of 80 steps at the estimate");
  EXPECT_TRUE(Says(Converged(), checks, "contacts of the cloth with itself depend on each other"));
  checks.jacobian = JacobianMethod::kNumeric;
  EXPECT_FALSE(Says(Converged(), checks, "not promised")) << "differences are none of the derivatives meant";
  checks.self_contact[0].num_cut = 7;
  checks.self_contact[0].first_cut = 12;
  checks.self_contact[0].intersections = 40;
  EXPECT_EQ(Judge(Converged(), checks).line, "usable with care: the simulated cloth passes through itself");
  EXPECT_TRUE(Says(Converged(), checks,
                   "40 pairs of triangles cut each other, in 7 of 80 steps at the estimate, from "
                   "step 12 on"));
}

TEST(VerdictTest, SaysWhichParametersCanBeUsed) {
  FitSummary summary = ThreeParameters();
  summary.parameters[1].at_bound = true;
  Verdict verdict = Judge(summary, {});
  EXPECT_EQ(verdict.line, "do not use k_stretch (at its bound); usable: mu and drag");
  EXPECT_EQ(verdict.overall, Usability::kWithCare) << "some of it can be used";
  EXPECT_EQ(verdict.parameters, (std::vector<Usability>{Usability::kUsable, Usability::kDoNotUse, Usability::kUsable}));
  summary.uncertainty->parameters[2].factor = 7.0;
  EXPECT_EQ(Judge(summary, {}).line,
            "do not use k_stretch (at its bound); usable: mu; with care: drag (the interval of drag is wide)");
  summary.parameters[1].at_bound = false;
  EXPECT_EQ(Judge(summary, {}).line, "usable with care: the interval of drag is wide");
  EXPECT_EQ(FitExitCode(summary, {}), 0);
  for (FittedParameter& parameter : summary.parameters) parameter.at_bound = true;
  verdict = Judge(summary, {});
  EXPECT_EQ(verdict.line, "do not use mu, k_stretch and drag (at its bound)");
  EXPECT_EQ(verdict.overall, Usability::kDoNotUse);
  summary.parameters[0].frozen = true;
  EXPECT_EQ(Judge(summary, {}).line, "do not use k_stretch and drag (at its bound)");
}

TEST(VerdictTest, TheGravestReasonComesFirst) {
  FitSummary summary = ThreeParameters();
  summary.counts.obstacle_switches = 3;
  summary.parameters[1].at_bound = true;
  summary.interval_check = IntervalCheck{0, 3.7, 120.0, {}, {}};
  const FitChecks checks = With(Recording(2.0, 0.1));
  const std::vector<std::string> reasons = Judge(summary, checks).reasons;
  const std::vector<std::string> expected = {"the fit is negative", "the error is of the size of the cloth",
                                             "k_stretch stands at its bound", "the interval of mu cannot be relied on",
                                             "at the estimate 3 contacts jump"};
  ASSERT_EQ(reasons.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(reasons[i].rfind(expected[i], 0), 0u) << reasons[i];
}

TEST(VerdictTest, ANegativeFitMustNotBeUsed) {
  const Verdict bad = Judge(Converged(), With(Recording(0.09, 0.05)));
  EXPECT_EQ(bad.exit_code, 6);
  EXPECT_EQ(bad.line, "do not use: the fit is negative (-80 %)");
  EXPECT_TRUE(Says(Converged(), With(Recording(0.09, 0.05)),
                   "every point at rest at its mean place would be nearer to the recording, rmse 50 mm against 90 mm"));
  EXPECT_EQ(Judge(Converged(), With(Recording(0.03, 0.05))).overall, Usability::kUsable) << "40 %";
  EXPECT_EQ(Judge(Converged(), With(Recording(0.045, 0.05))).line, "usable with care: the fit is low (10 %)");
  // A cloth that hangs still has no motion to compare with.
  const Verdict still = Judge(Converged(), With(Recording(0.03, 0.01)));
  EXPECT_EQ(still.exit_code, 0);
  EXPECT_EQ(still.line, "usable with care: the fit is negative (-200 %)");
  EXPECT_EQ(Judge(Converged(), With(Recording(0.005, 0.004))).overall, Usability::kUsable) << "half a percent of it";
  RecordingFit noisy = Recording(0.03, 0.025);
  noisy.noise = 0.025;
  EXPECT_EQ(Judge(Converged(), With(noisy)).overall, Usability::kUsable) << "the noise explains it";
}

TEST(VerdictTest, AnErrorOfTheSizeOfTheClothMustNotBeUsed) {
  const Verdict bad = Judge(Converged(), With(Recording(0.3, 2.0)));
  EXPECT_EQ(bad.exit_code, 6);
  EXPECT_EQ(bad.line, "do not use: the error is of the size of the cloth");
  EXPECT_EQ(bad.reasons[0], "the error is of the size of the cloth: rmse 300 mm, 30 % of the 1000 mm of the cloth");
  EXPECT_EQ(Judge(Converged(), With(Recording(0.15, 2.0))).line, "usable with care: the error is large");
  FitChecks two = With(Recording(0.01, 2.0));
  two.recordings.push_back(Recording(0.3, 2.0));
  two.recordings[1].name = "b.bin";
  EXPECT_EQ(Judge(Converged(), two).line, "do not use: b.bin: the error is of the size of the cloth");
}

TEST(VerdictTest, AStartThatIsElsewhereMustNotBeUsed) {
  RecordingFit recording = Recording(0.01, 2.0);
  recording.start = StartDifference{0.01, 0.001, 1.0};
  EXPECT_EQ(Judge(Converged(), With(recording)).overall, Usability::kUsable);
  recording.start->rms = 0.05;
  EXPECT_EQ(Judge(Converged(), With(recording)).exit_code, 0);
  EXPECT_EQ(Judge(Converged(), With(recording)).line,
            "usable with care: the scene's start is not where the first frame shows the cloth");
  recording.start->rms = 0.12;
  EXPECT_EQ(Judge(Converged(), With(recording)).exit_code, 6);
  EXPECT_TRUE(Says(Converged(), With(recording), "120 mm off (root mean square), 12 % of the cloth's size"));
}

TEST(VerdictTest, AStartTakenFromNoiseAsksForCare) {
  RecordingFit recording = Recording(0.01, 2.0);
  recording.starts_at_noise = true;
  EXPECT_EQ(Judge(Converged(), With(recording)).line, "usable with care: noisy frames were taken for the start");
  EXPECT_EQ(Judge(Converged(), With(recording)).exit_code, 0);
  EXPECT_TRUE(Says(Converged(), With(recording), "intervals do not count with that; --initial estimated does"));
}

TEST(VerdictTest, AnIntervalFromBoundToBoundTellsNothing) {
  FitSummary summary = Converged();
  ParameterUncertainty& mu = summary.uncertainty->parameters[0];
  mu.identifiable = false;
  mu.reaches_lower = mu.reaches_upper = true;
  Verdict verdict = Judge(summary, {});
  EXPECT_EQ(verdict.exit_code, 4);
  EXPECT_EQ(verdict.line, "do not use mu (hardly told by the recording)");
  EXPECT_TRUE(Says(summary, {}, "mu is hardly told by the recording: its 95 % interval reaches from bound to bound"));
  EXPECT_EQ(ParameterRemark(summary, {}, 0), "hardly told");
  EXPECT_TRUE(HasInterval(summary, {}, 0)) << "that it is wide is the answer";
  mu.reaches_upper = false;
  mu.share_of_belief = 0.5;
  EXPECT_TRUE(Says(summary, {}, "its 95 % interval is 0.5 of what was believed before, and reaches a bound"));
  // Narrow, at one bound.
  mu.share_of_belief = 0.1;
  verdict = Judge(summary, {});
  EXPECT_EQ(verdict.exit_code, 4) << "never called identifiable";
  EXPECT_EQ(verdict.line, "usable with care: the interval of mu reaches its lower bound");
  EXPECT_EQ(ParameterRemark(summary, {}, 0), "reaches a bound");
}

TEST(VerdictTest, WhatNoClothCanBeLeads) {
  FitSummary summary = ThreeParameters();
  FittedParameter& stretch = summary.parameters[1];
  stretch.measured = AnyFabric().k_stretch;
  stretch.value = 40334.0;
  EXPECT_EQ(Judge(summary, {}).line, "usable with care: k_stretch is 9.9 times beyond what was measured of any cloth");
  EXPECT_EQ(FitExitCode(summary, {}), 0);
  EXPECT_TRUE(Says(summary, {},
                   "any cloth: 40334 N/m against 6.54 to 4070 N/m; where the density is in g/m^2, not "
                   "kg/m^2, it is 40.33"));
  summary.forces = {Eigen::MatrixXd::Ones(3, 5)};
  EXPECT_TRUE(Says(summary, {}, "; where forces are in grams-force, not N, it is 395.5 and where forces are in mN, "));
  summary.error.successive_squares = summary.error.successive_products = 1.0;
  summary.uncertainty->residual_scale = 1.0;
  EXPECT_NE(Judge(summary, {}).line.find("care: k_stretch is 9.9 times"), std::string::npos) << "first";
  stretch.value = 0.5;
  EXPECT_TRUE(Says(summary, {}, "k_stretch is 13 times beyond what was measured of any cloth"));
  EXPECT_TRUE(Says(summary, {}, "where forces are in kN, not N, it is 500, where the mesh is in mm, not m, it is 500"));
  stretch.value = 1e9;
  EXPECT_TRUE(Says(summary, {}, "; check forces, density and size"));
  stretch.value = 10000.0;
  EXPECT_FALSE(Says(summary, {}, "beyond what was measured")) << "ten fabrics are not all";
  stretch.value = 1e9;
  stretch.frozen = true;
  EXPECT_FALSE(Says(summary, {}, "beyond what was measured"));
}

TEST(VerdictTest, ADerivativeThatIsLostTellsNothing) {
  FitSummary summary = Converged();
  DentCheck check;
  check.step = 0.01;
  check.expected_rise = 1e4;
  check.rise_below = check.rise_above = 50.0;
  const auto exit_code_of = [&](double expected) {
    check.expected_rise = expected;
    summary.dents = {check};
    return FitExitCode(summary, {});
  };
  EXPECT_EQ(exit_code_of(1e4), 0) << "one dent";
  EXPECT_EQ(ParameterRemark(summary, {}, 0), "one dent");
  for (const double expected : {1e9, -2.5e23, kNaN}) {
    EXPECT_EQ(exit_code_of(expected), 4) << expected;
    EXPECT_TRUE(check.is_dent());
    EXPECT_EQ(Judge(summary, {}).line, "do not use mu (lost in a rough cost)");
    EXPECT_EQ(ParameterRemark(summary, {}, 0), "lost in a rough cost");
  }
}

TEST(VerdictTest, AnEstimateThatHangsOnTheWeightsOfFramesMustNotBeUsed) {
  FitSummary summary = Converged();
  FittedParameter& stretch = summary.parameters[0];
  stretch.name = "k_stretch";
  stretch.scale = ParameterScale::kLog;
  stretch.value = 325.3;
  summary.uncertainty->parameters[0].lower95 = 228.0;
  summary.uncertainty->parameters[0].upper95 = 465.0;
  const auto exit_code_from = [&](double unweighed) {
    summary.unweighed_values = Eigen::VectorXd::Constant(1, unweighed);
    return FitExitCode(summary, {});
  };
  EXPECT_EQ(exit_code_from(1021.76), 6);
  EXPECT_EQ(Judge(summary, {}).line, "do not use: k_stretch hangs on how frames are weighed");
  EXPECT_TRUE(Says(summary, {}, "1022 where all count alike, 325.3 where they count for less as the model errs"));
  EXPECT_EQ(exit_code_from(200.0), 0) << "within one and a half half-widths";
  EXPECT_EQ(exit_code_from(100.0), 6);
  summary.uncertainty->parameters[0].lower95 = 324.0;
  summary.uncertainty->parameters[0].upper95 = 326.0;
  EXPECT_EQ(exit_code_from(300.0), 0) << "a small move, if a sure one";
  summary.unweighed_values.resize(0);
  EXPECT_EQ(FitExitCode(summary, {}), 0);
}

TEST(VerdictTest, ALowerPointThatIsLeftMustNotBeUsed) {
  FitSummary summary = Converged();
  summary.interval_check = IntervalCheck{0, -7.2, 4.0, Eigen::VectorXd::Ones(1), {}};
  EXPECT_EQ(FitExitCode(summary, {}), 6);
  EXPECT_EQ(Judge(summary, {}).line, "do not use: a point of lower cost was met");
  EXPECT_TRUE(Says(summary, {}, "at an end of it the cost \"rises\" by -7.2 instead of 3.84"));
  summary.num_continuations = 3;
  EXPECT_TRUE(Says(summary, {}, "after the fit had gone on from such a point 3 times"));
  summary.interval_check->rise_below = -0.1;
  EXPECT_EQ(FitExitCode(summary, {}), 0) << "a tenth of what a standard deviation costs";
  EXPECT_EQ(Judge(summary, {}).overall, Usability::kWithCare);
  summary.interval_check = IntervalCheck{0, 3.7, 4.0, {}, {}};
  summary.num_continuations = 1;
  EXPECT_EQ(Judge(summary, {}).line, "usable with care: the cost has more than one minimum");
  EXPECT_TRUE(Says(summary, {}, "the fit went on 1 time from a point of lower cost"));
}

TEST(VerdictTest, AStalledFitHasNoInterval) {
  FitSummary summary = ThreeParameters();
  summary.uncertainty->predicted_decrease = 2.1;
  for (const int i : {0, 2}) {
    summary.uncertainty->parameters[i].stalled = true;
    summary.uncertainty->parameters[i].identifiable = false;
    summary.uncertainty->parameters[i].std = kNaN;
    summary.uncertainty->parameters[i].distance = 1.2 + 0.2 * i;
  }
  EXPECT_EQ(FitExitCode(summary, {}), 4);
  EXPECT_EQ(Judge(summary, {}).line, "do not use mu and drag (the fit stalled); usable: k_stretch");
  EXPECT_TRUE(Says(summary, {},
                   "mu is 1.2 and drag 1.6 standard deviations from the minimum of the quadratic model at "
                   "the estimate, which promises a cost lower by 2.1 s^2"));
  EXPECT_FALSE(HasInterval(summary, {}, 0));
  EXPECT_EQ(ParameterRemark(summary, {}, 0), "stalled");
}

TEST(VerdictTest, AFitThatStalledNearItsMinimumIsUsableWithCare) {
  FitSummary summary = ThreeParameters();
  summary.uncertainty->predicted_decrease = 0.6;
  summary.uncertainty->parameters[0].distance = 1.1;
  summary.uncertainty->parameters[0].stall_error = 1.1 * summary.uncertainty->parameters[0].std;
  EXPECT_EQ(FitExitCode(summary, {}), 0);
  EXPECT_EQ(Judge(summary, {}).parameters[0], Usability::kWithCare);
  EXPECT_EQ(Judge(summary, {}).parameters[1], Usability::kUsable);
  EXPECT_TRUE(Says(summary, {}, "the interval counts with that distance"));
  EXPECT_TRUE(HasInterval(summary, {}, 0));
}

TEST(VerdictTest, AnOpenProfileTellsNothing) {
  FitChecks checks;
  Profile profile;
  profile.parameter = "mu";
  profile.points = {{0.3, 0.0, Eigen::VectorXd::Constant(1, 0.3)}};
  profile.lower95 = 0.1;
  checks.profiles = {profile};
  EXPECT_EQ(Judge(Converged(), checks).line, "usable with care: the profile of mu is open on one side");
  checks.profiles[0].lower95 = kNaN;
  EXPECT_EQ(FitExitCode(Converged(), checks), 4);
  checks.profiles[0].lower95 = 0.1;
  checks.profiles[0].upper95 = 0.5;
  checks.profiles[0].points.push_back({0.4, -5.0, Eigen::VectorXd::Constant(1, 0.4)});
  EXPECT_EQ(FitExitCode(Converged(), checks), 6) << "the estimate is not the minimum";
  EXPECT_TRUE(Says(Converged(), checks, "a lower cost was found at mu 0.4: fit again from there"));
}

TEST(VerdictTest, ExitCodesInTheirOrder) {
  FitChecks checks;
  FitSummary summary = Converged();
  EXPECT_EQ(FitExitCode(summary, checks), 0);
  checks.holdout = Holdout{0.2, 0.1, ""};
  EXPECT_EQ(FitExitCode(summary, checks), 5);
  EXPECT_EQ(Judge(summary, checks).overall, Usability::kDoNotUse);
  summary.parameters[0].at_bound = true;
  EXPECT_EQ(FitExitCode(summary, checks), 4);
  summary.parameters[0].at_bound = false;
  summary.uncertainty->parameters[0].visible = summary.uncertainty->parameters[0].identifiable = false;
  EXPECT_EQ(FitExitCode(summary, checks), 4);
  summary.uncertainty.reset();
  EXPECT_EQ(FitExitCode(summary, checks), 4) << "nothing vouches for the estimate";
  checks.recordings = {Recording(2.0, 0.1)};
  EXPECT_EQ(FitExitCode(summary, checks), 6);
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
  summary.uncertainty->parameters[0].visible = summary.uncertainty->parameters[0].identifiable = false;
  summary.uncertainty->hidden_directions.push_back({Eigen::VectorXd::Ones(1), 0.5, "mu"});
  EXPECT_TRUE(
      Says(summary, {},
           "not identifiable: mu: by its derivative, moved from bound to bound, the prediction changes by 0.5"));
  EXPECT_NE(ResultTable(summary, {}).find("not identifiable"), std::string::npos);
}

}  // namespace
}  // namespace clothid::verdict_test
