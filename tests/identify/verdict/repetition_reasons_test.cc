// What the verdict says of repetitions.
#include <gtest/gtest.h>

#include <algorithm>

#include "identify/verdict/verdict.h"
#include "tests/identify/repetition/single_fits.h"

namespace clothid::repetition_reasons_test {
namespace {

// Of finished fits.
Verdict JudgeFits(const std::vector<SingleFit>& fits, const std::vector<std::string>& names) {
  FitSummary summary;
  summary.status = FitStatus::kConverged;
  for (const std::string& name : names) {
    FittedParameter parameter;
    parameter.name = name;
    summary.parameters.push_back(parameter);
  }
  FitChecks checks;
  checks.repetitions = Pool(fits, names);
  checks.repetitions->is_of_folders = true;
  return Judge(summary, checks);
}

std::vector<SingleFit> FitsOf(const std::vector<double>& stiffnesses, double relative_std) {
  std::vector<SingleFit> fits;
  for (const double value : stiffnesses) {
    const std::string name(1, static_cast<char>('a' + static_cast<int>(fits.size())));
    fits.push_back(Fit(name, {Stiffness(value, relative_std * value), Friction(0.2, 0.01)}));
  }
  return fits;
}

bool Says(const Verdict& verdict, const std::string& words) {
  return std::any_of(verdict.reasons.begin(), verdict.reasons.end(),
                     [&](const std::string& line) { return line.find(words) != std::string::npos; });
}

TEST(RepetitionReasonsTest, LeadsWithScatterThatIntervalsDoNotExplain) {
  const Verdict verdict = JudgeFits(FitsOf({60.0, 70.0, 80.0, 66.0, 75.0}, 0.03), {"k_stretch", "mu"});
  EXPECT_EQ(verdict.line,
            "usable with care: recordings differ by 11 % in k_stretch, their intervals explain 3 %: material, set-up "
            "or model varies");
  EXPECT_EQ(verdict.exit_code, kExitSuccess);
  EXPECT_EQ(verdict.parameters, (std::vector<Usability>{Usability::kWithCare, Usability::kUsable}));
  EXPECT_EQ(verdict.reasons[0].substr(0, 70), "k_stretch differs by 11 % between recordings, their intervals explain ");
  EXPECT_TRUE(Says(verdict, "for the next specimen"));
  EXPECT_TRUE(Says(verdict, "mu differs between recordings by no more than their intervals say"));
}

TEST(RepetitionReasonsTest, InventsNoScatter) {
  const Verdict verdict = JudgeFits(FitsOf({68.0, 70.0, 72.0, 69.0}, 0.03), {"k_stretch", "mu"});
  EXPECT_EQ(verdict.line, "usable: recordings differ by no more than their intervals say");
  EXPECT_EQ(verdict.overall, Usability::kUsable);
  EXPECT_EQ(verdict.exit_code, kExitSuccess);
}

TEST(RepetitionReasonsTest, NamesTheRecordingThatDoesNotFit) {
  const Verdict verdict = JudgeFits(FitsOf({70.0, 70.5, 69.6, 70.3, 69.8, 120.0}, 0.01), {"k_stretch"});
  EXPECT_TRUE(Says(verdict, "f does not fit the others: its k_stretch is "));
  EXPECT_FALSE(Says(verdict, "a does not fit the others"));
  EXPECT_NE(verdict.line.find("f does not fit the others"), std::string::npos) << verdict.line;
}

TEST(RepetitionReasonsTest, SaysThatTheStepsErrorIsCommon) {
  std::vector<SingleFit> fits = FitsOf({60.0, 70.0, 80.0}, 0.01);
  for (SingleFit& fit : fits) fit.estimates[0].step_error = 0.05 * fit.estimates[0].value;
  EXPECT_TRUE(Says(JudgeFits(fits, {"k_stretch"}), "the error of time step and mesh, 5 %, is common to all"));
}

TEST(RepetitionReasonsTest, OneRecordingTellsNothingOfScatter) {
  std::vector<SingleFit> fits = FitsOf({60.0, 70.0, 80.0}, 0.01);
  fits[0].why_not_used = "not converged: no progress";
  fits[1].estimates[0].std = std::numeric_limits<double>::quiet_NaN();
  const Verdict verdict = JudgeFits(fits, {"k_stretch", "mu"});
  EXPECT_EQ(verdict.exit_code, kExitNotIdentifiable);
  EXPECT_EQ(verdict.line.substr(0, 66), "do not use k_stretch (told by fewer than two recordings); with car");
  EXPECT_TRUE(Says(verdict, "a was left out of the repetitions: its fit: not converged: no progress"));
}

}  // namespace
}  // namespace clothid::repetition_reasons_test
