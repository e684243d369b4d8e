// Repetitions in report.html: what the page of a fit holds of them, and that of finished fits.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "identify/report/repetition_report.h"
#include "identify/report/report_page.h"
#include "identify/result/repetition_json.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/identify/report/made_repetitions.h"
#include "tests/identify/report/packed_page.h"

namespace clothid::repetition_page_test {
namespace {

using Json = nlohmann::ordered_json;

bool Contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(RepetitionPageTest, LinesAreThoseOfTheVerdict) {
  FitChecks checks = ChecksOf(MadeRepetitions());
  const Json lines = RepetitionLinesJson(*checks.repetitions);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_TRUE(Contains(lines["k_stretch"], "k_stretch differs by ")) << lines;
  EXPECT_TRUE(Contains(lines["mu"], "mu differs between recordings by no more than ")) << lines;
  EXPECT_TRUE(Contains(lines["k_bend"], "fewer than two recordings")) << lines;
  const Json verdict = PageData(MadePooledHtml())["result"]["verdict"];
  for (const auto& [name, line] : lines.items()) {
    EXPECT_NE(std::find(verdict.begin(), verdict.end(), line), verdict.end()) << name << ": " << verdict;
  }
}

TEST(RepetitionPageTest, FinishedFitsHaveAPageOfTheirOwn) {
  const std::string html = MadePooledHtml();
  const Json data = PageData(html);
  EXPECT_EQ(data["result"]["status"], "pooled");
  EXPECT_EQ(data["result"]["repetitions"], Json::parse(RepetitionsJson(MadeRepetitions()).dump())) << "NaN is null";
  EXPECT_EQ(data["repetition_lines"], RepetitionLinesJson(MadeRepetitions()));
  EXPECT_LT(html.size(), 100000u) << "without a library";
  EXPECT_FALSE(Contains(html, "<img"));
  EXPECT_FALSE(Contains(html, "http:") || Contains(html, "https:"));
  EXPECT_FALSE(Contains(html, "{{"));
  EXPECT_EQ(MadePooledHtml(), html);
}

TEST(RepetitionPageTest, FitsHaveThemWhereTheyWereAskedFor) {
  MotionOptions options;
  options.true_values = {{"k_stretch", 150.0}};
  const std::vector<RecordedMotion> motions = {MakeMotion(SwingScene(), options)};
  FitOptions fit;
  fit.parameters = {"k_stretch"};
  FitProblem problem(motions, fit);
  const FitSummary summary = Fit(fit, &problem);
  const std::string with = ReportHtml(summary, ChecksOf(MadeRepetitions()), motions);
  EXPECT_EQ(PageData(with)["repetition_lines"], RepetitionLinesJson(MadeRepetitions()));
  EXPECT_TRUE(PageData(with)["result"].contains("repetitions"));
  EXPECT_TRUE(Contains(with, "function showRepetitions"));
  const std::string without = ReportHtml(summary, FitChecks(), motions);
  EXPECT_FALSE(PageData(without).contains("repetition_lines"));
  EXPECT_FALSE(Contains(without, "function showRepetitions"));
}

}  // namespace
}  // namespace clothid::repetition_page_test
