// Lists and names of the command line.
#include "identify/base/options.h"

#include <gtest/gtest.h>

#include "tests/expect_error.h"

namespace clothid::options_test {
namespace {

TEST(OptionsTest, ParsesNames) {
  EXPECT_TRUE(ParseNames("", "--fit").empty());
  EXPECT_EQ(ParseNames("mu,k_stretch", "--fit"), (std::vector<std::string>{"mu", "k_stretch"}));
  EXPECT_EQ(ParseNames(" mu, k_stretch\t", "--fit"), ParseNames("mu,k_stretch", "--fit"));
  for (const char* text : {",", "mu,", "mu,,drag", "mu, ,drag", "mu,mu", "mu, mu"}) {
    ExpectError([&] { ParseNames(text, "--fit"); }, ErrorKind::kUsage, {"--fit"});
  }
}

TEST(OptionsTest, ParsesMethods) {
  for (const char* name : {"adjoint", "sensitivity", "numeric"}) {
    EXPECT_EQ(JacobianMethodName(ParseJacobianMethod(name)), name);
  }
  ExpectError([] { ParseJacobianMethod("exact"); }, ErrorKind::kUsage, {"--jacobian", "exact"});
  EXPECT_EQ(ParseFitPrecision("adaptive"), FitPrecision::kAdaptive);
  EXPECT_EQ(ParseFitPrecision("full"), FitPrecision::kFull);
  ExpectError([] { ParseFitPrecision("loose"); }, ErrorKind::kUsage, {"--precision", "loose"});
}

TEST(OptionsTest, ParsesAdjointMethodsWithTheirThresholds) {
  EXPECT_EQ(ParseAdjointOptions("lu").method, AdjointMethod::kLu);
  EXPECT_FALSE(ParseAdjointOptions("reduced").threshold.has_value());
  const AdjointOptions options = ParseAdjointOptions("fixed_point:1e-4");
  EXPECT_EQ(options.method, AdjointMethod::kFixedPoint);
  EXPECT_EQ(options.threshold, 1e-4);
  for (const char* text : {"", "qr", "gmres:", "gmres:0", "gmres:1", "gmres:nan", "gmres:1e-4:2", ":1e-4"}) {
    ExpectError([&] { ParseAdjointOptions(text); }, ErrorKind::kUsage, {"--adjoint", text});
  }
}

TEST(OptionsTest, ParsesWhatIsAssumedAboutNoiseAndStart) {
  ReadMotionOptions options;
  ParseSigma("auto", &options);
  EXPECT_EQ(options.sigma_source, SigmaSource::kEstimated);
  ParseSigma("recorded", &options);
  EXPECT_EQ(options.sigma_source, SigmaSource::kRecorded);
  ParseSigma("0.004", &options);
  EXPECT_EQ(options.sigma_source, SigmaSource::kGiven);
  EXPECT_EQ(options.sigma, 0.004);
  for (const char* text : {"", "0", "-1", "nan", "inf", "4mm", "estimated"}) {
    ExpectError([&] { ParseSigma(text, &options); }, ErrorKind::kUsage, {"--sigma", text});
  }
  EXPECT_EQ(ParseStartSource("first"), StartSource::kFirstFrame);
  EXPECT_EQ(ParseStartSource("smoothed"), StartSource::kSmoothed);
  ExpectError([] { ParseStartSource("scene"); }, ErrorKind::kUsage, {"--initial", "scene"});
}

TEST(OptionsTest, ParsesPartsOfTheDiscretization) {
  EXPECT_FALSE(ParseDiscretization("").any());
  EXPECT_TRUE(ParseDiscretization("step").step && !ParseDiscretization("step").mesh);
  EXPECT_TRUE(ParseDiscretization("mesh").mesh && !ParseDiscretization("mesh").step);
  EXPECT_TRUE(ParseDiscretization("all").mesh && ParseDiscretization("all").step);
  ExpectError([] { ParseDiscretization("time"); }, ErrorKind::kUsage,
              {"--discretization", "step, mesh or all", "time"});
}

TEST(OptionsTest, ParsesTheTimeStep) {
  EXPECT_EQ(ParseTimeStep("").seconds, 0.0);
  EXPECT_EQ(ParseTimeStep("0.002").seconds, 0.002);
  EXPECT_TRUE(ParseTimeStep("auto").is_automatic);
  for (const char* text : {"0", "-1", "inf", "half"}) {
    ExpectError([&] { ParseTimeStep(text); }, ErrorKind::kUsage, {"--time_step", "auto or a number > 0", text});
  }
}

TEST(OptionsTest, ValidatesItself) {
  EXPECT_NO_THROW(FitOptions().Validate());
  FitOptions options;
  options.max_iterations = 0;
  ExpectError([&] { options.Validate(); }, ErrorKind::kUsage, {"--max_iterations"});
  options = FitOptions();
  for (const int num_threads : {0, 1000000000}) {
    options.num_threads = num_threads;
    ExpectError([&] { options.Validate(); }, ErrorKind::kUsage, {"--threads", "from 1 to 4096"});
  }
  options = FitOptions();
  options.function_tolerance = 0.0;
  ExpectError([&] { options.Validate(); }, ErrorKind::kUsage, {"function_tolerance"});
}

}  // namespace
}  // namespace clothid::options_test
