#include "datasets/curves/curve_findings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "sim/base/error.h"

namespace clothid::curve_findings_test {
namespace {

// A pull to 20 % and back of a strip of 50 x 200 mm of cloth that stiffens, with noise of 0.2 % of the largest force.
class CurveFindingsTest : public testing::Test {
 protected:
  static constexpr int kCount = 300;

  CurveFindingsTest() {
    options_.width = 0.05;
    options_.length = 0.2;
    table_.elongations.resize(2 * kCount);
    table_.forces.resize(2 * kCount);
    std::mt19937_64 generator(1);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 2 * kCount; ++i) {
      const double strain = 0.2 * (i < kCount ? i : 2 * kCount - 1 - i) / (kCount - 1.0);
      table_.elongations[i] = 0.2 * strain;
      table_.forces[i] =
          0.05 * 300.0 * std::expm1(5.0 * strain) / 5.0 * (i < kCount ? 1.0 : 0.9) + 0.01 * normal(generator);
    }
  }

  Finding Find(const std::string& what) const {
    for (const Finding& finding : CheckCurve(table_, MakeTensileCurve(table_, options_))) {
      if (finding.what == what) return finding;
    }
    ADD_FAILURE() << what;
    return {};
  }

  void ExpectFinding(const std::string& what, Severity severity, const std::string& words) const {
    const Finding finding = Find(what);
    EXPECT_EQ(finding.severity, severity) << finding.value;
    EXPECT_NE((finding.value + "; " + finding.hint).find(words), std::string::npos)
        << words << "\n"
        << finding.value << "; " << finding.hint;
  }

  CurveTable table_;
  TensileCurveOptions options_;
};

TEST_F(CurveFindingsTest, AGoodCurveIsOk) {
  ExpectFinding("zero of the force", Severity::kOk, "before the loading");
  ExpectFinding("slip", Severity::kOk, "none");
  ExpectFinding("units", Severity::kOk, "a specimen of 50 x 200 mm");
  // Yarns that catch and let go are no slip, nor is a table that ends at its largest elongation.
  for (int i = 0; i < kCount; ++i) table_.forces[i] += 0.08 * std::sin(1.7 * i);
  ExpectFinding("slip", Severity::kOk, "none");
  table_.elongations.conservativeResize(kCount);
  table_.forces.conservativeResize(kCount);
  ExpectFinding("zero of the force", Severity::kOk, "does not come back");
}

TEST_F(CurveFindingsTest, TellsAZeroThatIsOffOrDrifts) {
  const Eigen::VectorXd forces = table_.forces;
  for (int i = 0; i < 2 * kCount; ++i) table_.forces[i] += 0.2 * i / (2.0 * kCount);
  ExpectFinding("zero of the force", Severity::kWarning, "drifts");
  table_.forces = forces.array() - 0.2;
  ExpectFinding("zero of the force", Severity::kWarning, "cloth does not push");
  table_.forces = forces;
  table_.forces.head(kCount).array() += 0.2;
  ExpectFinding("zero of the force", Severity::kNote, "a pretension");
}

TEST_F(CurveFindingsTest, TellsASlip) {
  for (int i = 180; i < kCount; ++i) table_.forces[i] -= 0.6;
  ExpectFinding("slip", Severity::kWarning, "at a strain of 12 %");
  ExpectFinding("slip", Severity::kWarning, "--strain 0:0.119");
  table_.elongations /= 0.2;
  table_.is_strain = true;
  ExpectFinding("slip", Severity::kWarning, "at a strain of 12 %");
}

TEST_F(CurveFindingsTest, TellsUnitsThatAreOff) {
  const CurveTable good = table_;
  table_.forces *= 1e3;
  ExpectFinding("units", Severity::kWarning, "is the unit of the force off by 10^3?");
  table_.forces *= 1e-6;
  ExpectFinding("units", Severity::kWarning, "is the unit of the force off by 10^-3?");
  table_ = good;
  table_.elongations *= 1e-3;
  ExpectFinding("units", Severity::kWarning, "is the unit of the elongation off");
  table_.elongations *= 2e4;
  ExpectFinding("units", Severity::kWarning, "is the unit of the elongation off");
  table_ = good;
  options_.width = 0.005;
  ExpectFinding("units", Severity::kWarning, "--specimen");
}

}  // namespace
}  // namespace clothid::curve_findings_test
