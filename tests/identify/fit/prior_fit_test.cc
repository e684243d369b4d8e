// Fits with priors end where the linear-Gaussian theory says, whoever minimises and whatever is fitted beside them.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "identify/base/fingerprint.h"
#include "identify/checks/profile.h"
#include "identify/fit/fit.h"
#include "tests/costs/start/forget_start.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid::prior_fit_test {
namespace {

constexpr double kNoise = 1e-3;

RecordedMotion NoisySwing() {
  return MakeMotion(SwingScene(), {{{"k_stretch", 150.0}, {"k_bend", 4e-3}}, kNoise, 0.0, kNoise});
}

// The same where everything but k_stretch is known.
RecordedMotion NoisyStretch() {
  RecordedMotion motion = NoisySwing();
  motion.scene.parameters["k_bend"].nominal = 4e-3;
  return motion;
}

FitOptions OptionsFor(const std::vector<std::string>& names, const std::map<std::string, ParameterPrior>& priors) {
  FitOptions options;
  options.parameters = names;
  options.overrides.priors = priors;
  return options;
}

FitSummary RunFit(const std::vector<RecordedMotion>& motions, const FitOptions& options) {
  FitProblem problem(motions, options);
  FitSummary summary = Fit(options, &problem);
  EXPECT_EQ(summary.status, FitStatus::kConverged) << summary.message;
  EXPECT_TRUE(summary.uncertainty.has_value());
  return summary;
}

Eigen::MatrixXd CovarianceOf(const FitSummary& summary) {
  Eigen::MatrixXd covariance = summary.uncertainty->correlation;
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    covariance.row(i) *= summary.uncertainty->parameters[i].coordinate_std;
    covariance.col(i) *= summary.uncertainty->parameters[i].coordinate_std;
  }
  return covariance;
}

double StdOf(const FitSummary& summary, int index) { return summary.uncertainty->parameters[index].coordinate_std; }

// A prior of the first parameter as wide as what `alone` leaves of it, `stds` of that above its estimate.
ParameterPrior PriorBeside(const FitSummary& alone, double stds) {
  const double std = StdOf(alone, 0);
  return {std::exp(alone.coordinates[0] + stds * std), std::exp(std)};
}

// That `summary`, a fit to as many copies of a recording, is the product of what `alone` tells of it and of the prior.
void ExpectProduct(const FitSummary& alone, double copies, double stds, const FitSummary& summary) {
  Eigen::MatrixXd precision = copies * CovarianceOf(alone).inverse();
  const double prior = std::pow(StdOf(alone, 0), -2);
  precision(0, 0) += prior;
  const Eigen::MatrixXd covariance = precision.inverse();
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    const double expected = alone.coordinates[i] + covariance(i, 0) * prior * stds * StdOf(alone, 0);
    EXPECT_NEAR(summary.coordinates[i], expected, 0.05 * StdOf(alone, static_cast<int>(i))) << i;
    EXPECT_NEAR(StdOf(summary, static_cast<int>(i)), std::sqrt(covariance(i, i)), 0.03 * std::sqrt(covariance(i, i)));
  }
}

TEST(PriorFitTest, EndsAtTheProductOfPriorAndRecording) {
  const RecordedMotion motion = NoisySwing();
  const std::vector<std::string> names = {"k_stretch", "k_bend"};
  const FitSummary alone = RunFit({motion}, OptionsFor(names, {}));
  ASSERT_FALSE(alone.uncertainty->is_widened);
  const FitOptions options = OptionsFor(names, {{"k_stretch", PriorBeside(alone, 2.0)}});
  const FitSummary both = RunFit({motion}, options);
  ExpectProduct(alone, 1.0, 2.0, both);
  EXPECT_NEAR(both.uncertainty->parameters[0].beside_prior->disagreement, 2.0 / std::sqrt(2.0), 0.05);
  EXPECT_NEAR(both.uncertainty->parameters[0].beside_prior->other_value, alone.parameters[0].value,
              0.05 * StdOf(alone, 0) * alone.parameters[0].value);
  EXPECT_TRUE(both.interval_check->is_quadratic()) << both.interval_check->rise_below;
  ExpectProduct(alone, 2.0, 2.0, RunFit({motion, motion}, options));  // the prior counts once
}

TEST(PriorFitTest, ProfilesCountWithThePrior) {
  const RecordedMotion motion = NoisyStretch();
  const FitSummary alone = RunFit({motion}, OptionsFor({"k_stretch"}, {}));
  const FitOptions options = OptionsFor({"k_stretch"}, {{"k_stretch", PriorBeside(alone, 1.0)}});
  FitProblem problem({motion}, options);
  const FitSummary summary = Fit(options, &problem);
  CostStatistics statistics;
  const Profile profile = ProfileParameter(options, summary, "k_stretch", &problem, &statistics);
  const double half_width = kNormal95 * StdOf(alone, 0) / std::sqrt(2.0);
  EXPECT_NEAR(std::log(profile.upper95) - summary.coordinates[0], half_width, 0.03 * half_width);
  EXPECT_NEAR(summary.coordinates[0] - std::log(profile.lower95), half_width, 0.03 * half_width);
}

TEST(PriorFitTest, NarrowOnesDominateAndWideOnesDoNotMatter) {
  const RecordedMotion motion = NoisySwing();
  const FitSummary alone = RunFit({motion}, OptionsFor({"k_stretch", "k_bend"}, {}));
  const FitSummary wide = RunFit({motion}, OptionsFor({"k_stretch", "k_bend"}, {{"k_bend", {1.0, 1e3}}}));
  EXPECT_NEAR(wide.coordinates[1], alone.coordinates[1], 0.05 * StdOf(alone, 1));
  EXPECT_TRUE(wide.uncertainty->parameters[1].identifiable);
  const FitSummary narrow = RunFit({motion}, OptionsFor({"k_stretch", "k_bend"}, {{"k_bend", {4e-3, 1.0001}}}));
  EXPECT_NEAR(narrow.parameters[1].value, 4e-3, 4e-7);
  EXPECT_TRUE(narrow.uncertainty->parameters[1].beside_prior->adds_nothing());
  EXPECT_LE(StdOf(narrow, 0), StdOf(alone, 0));
}

TEST(PriorFitTest, OneRecordingMayHaveItsOwn) {
  const RecordedMotion motion = NoisyStretch();
  const FitSummary alone = RunFit({motion}, OptionsFor({"k_stretch"}, {}));
  FitOptions options = OptionsFor({"k_stretch"}, {{"k_stretch@2", PriorBeside(alone, 2.0)}});
  options.each = {"k_stretch"};
  const FitSummary summary = RunFit({motion, motion}, options);
  EXPECT_NEAR(summary.coordinates[0], alone.coordinates[0], 0.05 * StdOf(alone, 0));
  EXPECT_NEAR(summary.coordinates[1], alone.coordinates[0] + StdOf(alone, 0), 0.05 * StdOf(alone, 0));
  EXPECT_FALSE(summary.parameters[0].prior.is_given());
  EXPECT_TRUE(summary.parameters[1].prior.is_given());
}

TEST(PriorFitTest, CountsBesideAnUnknownStart) {
  MotionOptions truth;
  truth.true_values = {{"k_stretch", 70.0}, {"mu", 0.24}};
  truth.sigma = 2e-3;
  truth.frame_interval = 0.03;
  RecordedMotion motion = MakeMotion(ShippedScene("drape", 8), truth);
  AddLastingNoise(2e-3, 0.0, 1, &motion);
  motion = ForgetStart(StartSource::kRest, motion);
  FitOptions options = OptionsFor({"k_stretch", "mu"}, {});
  options.overrides.start = {{"mu", 0.36}, {"k_stretch", 110.0}};
  const FitSummary alone = RunFit({motion}, options);
  options.overrides.priors = {{"k_stretch", PriorBeside(alone, 1.0)}};
  const FitSummary both = RunFit({motion}, options);
  // Stages with an unknown start end within a tenth of a standard deviation.
  EXPECT_NEAR(both.coordinates[0], alone.coordinates[0] + 0.5 * StdOf(alone, 0), 0.2 * StdOf(alone, 0));
  EXPECT_NEAR(StdOf(both, 0), StdOf(alone, 0) / std::sqrt(2.0), 0.1 * StdOf(alone, 0));
}

TEST(PriorFitTest, JournalsBelongToTheirPriors) {
  const RecordedMotion motion = NoisySwing();
  const auto fingerprint = [&](const std::map<std::string, ParameterPrior>& priors) {
    const FitOptions options = OptionsFor({"k_stretch"}, priors);
    return FitFingerprint({motion}, FitProblem({motion}, options).blocks(), options);
  };
  EXPECT_NE(fingerprint({}), fingerprint({{"k_stretch", {100.0, 2.0}}}));
  EXPECT_NE(fingerprint({{"k_stretch", {100.0, 2.0}}}), fingerprint({{"k_stretch", {100.0, 2.5}}}));
}

TEST(PriorFitTest, RefusesThoseThatHaveNoEffect) {
  RecordedMotion motion = NoisySwing();
  const auto make = [&](const std::map<std::string, ParameterPrior>& priors) {
    FitProblem({motion}, OptionsFor({"k_stretch", "k_bend"}, priors));
  };
  ExpectError([&] { make({{"drag", {1.0, 2.0}}}); }, ErrorKind::kUsage, {"--prior: 'drag' is not among the fitted"});
  ExpectError([&] { make({{"k_bend", {1.0, 1.0}}}); }, ErrorKind::kUsage, {"the prior of 'k_bend'", "MEDIAN:FACTOR"});
  ExpectError([&] { make({{"k_bend", {-1.0, 2.0}}}); }, ErrorKind::kUsage, {"the prior of 'k_bend'", "MEDIAN:FACTOR"});
  motion.scene.parameters["k_bend"].frozen = true;
  ExpectError([&] { make({{"k_bend", {1.0, 2.0}}}); }, ErrorKind::kUsage, {"the prior of 'k_bend' has no effect"});
}

}  // namespace
}  // namespace clothid::prior_fit_test
