// Fits to be judged, each fine but for what a test changes.
#ifndef CLOTHID_TESTS_IDENTIFY_VERDICT_JUDGED_FITS_H_
#define CLOTHID_TESTS_IDENTIFY_VERDICT_JUDGED_FITS_H_

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "identify/report/report.h"
#include "identify/verdict/verdict.h"

namespace clothid::judged_fits {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

inline FitSummary Converged() {
  FitSummary summary;
  summary.status = FitStatus::kConverged;
  FittedParameter parameter;
  parameter.name = "mu";
  parameter.value = 0.3;
  summary.parameters = {parameter};
  summary.uncertainty.emplace();
  summary.uncertainty->parameters.resize(1);
  summary.uncertainty->parameters[0].visible = true;
  summary.uncertainty->parameters[0].identifiable = true;
  summary.uncertainty->parameters[0].std = 0.01;
  return summary;
}

inline bool Says(const FitSummary& summary, const FitChecks& checks, const std::string& words) {
  const std::vector<std::string> lines = Judge(summary, checks).Lines();
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(words) != std::string::npos; });
}

// A recording of one point, seen twice, that moves by `motion` (root mean square distance to its mean, m) and is
// predicted with the error `rmse` (m); the cloth is 1 m.
inline RecordingFit Recording(double rmse, double motion) {
  RecordingFit recording;
  recording.name = "a.bin";
  recording.cloth_size = 1.0;
  recording.error.num_coordinates = 6.0;
  recording.error.squared_error = 2.0 * rmse * rmse;
  recording.error.squared_motion = 2.0 * motion * motion;
  return recording;
}

inline FitChecks With(const RecordingFit& recording) {
  FitChecks checks;
  checks.recordings = {recording};
  return checks;
}

inline FittedParameter Named(const std::string& name) {
  FittedParameter parameter;
  parameter.name = name;
  parameter.value = 1.0;
  return parameter;
}

// mu, k_stretch and drag, all of them fine.
inline FitSummary ThreeParameters() {
  FitSummary summary = Converged();
  summary.parameters = {Named("mu"), Named("k_stretch"), Named("drag")};
  summary.uncertainty->parameters.resize(3, summary.uncertainty->parameters[0]);
  return summary;
}

}  // namespace clothid::judged_fits

#endif  // CLOTHID_TESTS_IDENTIFY_VERDICT_JUDGED_FITS_H_
