// What repetitions tell, for programs; and the result.json of a run that judges finished fits.
#ifndef CLOTHID_IDENTIFY_RESULT_REPETITION_JSON_H_
#define CLOTHID_IDENTIFY_RESULT_REPETITION_JSON_H_

#include <nlohmann/json.hpp>
#include <string>

#include "identify/repetition/repetitions.h"
#include "identify/verdict/verdict.h"

namespace clothid {

// "repetitions" of result.json. Of every parameter: the estimates of all recordings in their own units, with weight,
// deviation from the others in joint standard deviations, and whether they fit (null where they are not pooled); the
// mean, its interval and that of the next specimen, in its own unit; "scatter" (tau with its interval, and by Paule and
// Mandel), "difference" (tau and typical_std together), "typical_std" and "common_error" in the coordinate: of the
// logarithm where "scale" is "log", so 0.12 is 12 %.
nlohmann::ordered_json RepetitionsJson(const Repetitions& repetitions);

// The text of result.json where there is no joint fit: "status" is "pooled", and of "parameters" value, std, lower95
// and upper95 are those of the mean.
std::string PooledResultJson(const FitSummary& summary, const FitChecks& checks, const Verdict& verdict);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_RESULT_REPETITION_JSON_H_
