// Fits of single recordings as they might have ended.
#ifndef CLOTHID_TESTS_IDENTIFY_REPETITION_SINGLE_FITS_H_
#define CLOTHID_TESTS_IDENTIFY_REPETITION_SINGLE_FITS_H_

#include <string>
#include <utility>
#include <vector>

#include "identify/repetition/repetitions.h"
#include "tests/expect_error.h"

namespace clothid {

inline SingleEstimate Estimate(const std::string& name, ParameterScale scale, double value, double std) {
  SingleEstimate estimate;
  estimate.name = name;
  estimate.scale = scale;
  estimate.value = value;
  estimate.std = std;
  estimate.lower95 = value - 1.96 * std;
  estimate.upper95 = value + 1.96 * std;
  return estimate;
}

inline SingleEstimate Stiffness(double value, double std) {
  return Estimate("k_stretch", ParameterScale::kLog, value, std);
}

inline SingleEstimate Friction(double value, double std) { return Estimate("mu", ParameterScale::kLinear, value, std); }

inline SingleFit Fit(const std::string& name, std::vector<SingleEstimate> estimates) {
  SingleFit fit;
  fit.name = name;
  fit.estimates = std::move(estimates);
  return fit;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_IDENTIFY_REPETITION_SINGLE_FITS_H_
