// Repetitions as six fits might have ended, and pages of them.
#ifndef CLOTHID_TESTS_IDENTIFY_REPORT_MADE_REPETITIONS_H_
#define CLOTHID_TESTS_IDENTIFY_REPORT_MADE_REPETITIONS_H_

#include <cmath>
#include <string>
#include <vector>

#include "identify/fit/fit.h"
#include "identify/repetition/repetitions.h"
#include "identify/report/repetition_report.h"
#include "identify/verdict/verdict.h"
#include "tests/identify/repetition/single_fits.h"

namespace clothid {

inline constexpr char kHostileRecording[] = "</script><img src=x onerror=document.title=1>.bin";

// k_stretch of five recordings, of which e.bin does not fit the others; one that is not used; mu, which d.bin and e.bin
// do not tell and c.bin does not have; k_bend, which one recording tells.
inline Repetitions MadeRepetitions() {
  const double nan = std::nan("");
  const std::vector<std::string> names = {kHostileRecording, "b.bin", "c.bin", "d.bin", "e.bin", "f.bin"};
  const std::vector<double> stiffnesses = {50.0, 51.0, 49.0, 50.5, 90.0, 12.0}, stds = {1.0, 1.0, 1.0, 4.0, 2.0, 1.0};
  std::vector<SingleFit> fits(names.size());
  for (std::size_t r = 0; r < fits.size(); ++r) {
    fits[r].name = names[r];
    fits[r].estimates = {Estimate("k_stretch", ParameterScale::kLog, stiffnesses[r], stds[r])};
    if (r != 2) {
      const bool is_told = r == 0 || r == 5;
      fits[r].estimates.push_back(
          Estimate("mu", ParameterScale::kLinear, 0.3 + 0.01 * static_cast<double>(r), is_told ? 0.02 : nan));
    }
    fits[r].estimates.push_back(Estimate("k_bend", ParameterScale::kLog, 1e-3, r == 0 ? 1e-4 : nan));
  }
  fits[1].estimates[1] = Estimate("mu", ParameterScale::kLinear, 0.31, 0.03);
  fits[5].why_not_used = "do not use: the fit has not converged";
  return Pool(fits, {"k_stretch", "mu", "k_bend"});
}

inline FitChecks ChecksOf(const Repetitions& repetitions) {
  FitChecks checks;
  checks.repetitions = repetitions;
  checks.flags = "--repeat --target fits";
  return checks;
}

// The page of these as finished fits.
inline std::string MadePooledHtml() {
  FitChecks checks = ChecksOf(MadeRepetitions());
  checks.repetitions->is_of_folders = true;
  FitSummary summary;
  summary.status = FitStatus::kConverged;
  for (const PooledParameter& pooled : checks.repetitions->parameters) {
    FittedParameter parameter;
    parameter.name = pooled.name;
    parameter.value = pooled.mean;
    parameter.scale = pooled.scale;
    summary.parameters.push_back(parameter);
  }
  return PooledHtml(summary, checks, Judge(summary, checks));
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_IDENTIFY_REPORT_MADE_REPETITIONS_H_
