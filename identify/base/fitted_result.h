// What result.json says of a fit, for those who go on from it.
#ifndef CLOTHID_IDENTIFY_BASE_FITTED_RESULT_H_
#define CLOTHID_IDENTIFY_BASE_FITTED_RESULT_H_

#include <map>
#include <string>
#include <vector>

#include "costs/assimilation/assimilation.h"
#include "datasets/observation/model_error.h"

namespace clothid {

inline constexpr char kResultSchema[] = "clothid.result/1";

// What was assumed about a recording, in the words of result.json.
struct FittedReading {
  std::string sigma_source, start_source;
  double sigma = 0.0;  // m, the mean over its points; NaN: none
};

struct FittedResult {
  std::string path;                         // for messages
  std::map<std::string, double> estimates;  // by name, as "drag" or, of the second recording, "drag@2"
  std::vector<std::string> recordings;      // their SHA-256, in the order of the fit
  std::vector<ModelError> model_errors;     // of each, that frames were weighed by
  Assimilation assimilation;                // of the rollouts that the recordings corrected
  std::vector<FittedReading> readings;      // of each; empty: what their files say
};

// The estimates of a result.json by name. Throws `Error` (kIo, kBadData), naming file and key.
std::map<std::string, double> ReadEstimates(const std::string& path);

// All of it. Throws `Error` likewise, and where the fit ended without an estimate, was interrupted, or is of fields,
// which result.json does not hold.
FittedResult ReadFittedResult(const std::string& path);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_BASE_FITTED_RESULT_H_
