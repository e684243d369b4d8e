// "assimilation" and "missing_force" of result.json.
#ifndef CLOTHID_IDENTIFY_RESULT_CORRECTIONS_JSON_H_
#define CLOTHID_IDENTIFY_RESULT_CORRECTIONS_JSON_H_

#include <nlohmann/json.hpp>
#include <vector>

#include "identify/verdict/verdict.h"

namespace clothid {

// Of rollouts that the recordings correct, and of the fits that found their memory.
nlohmann::ordered_json CorrectionsJson(const FitSummary& summary, const FitChecks& checks);

// "missing_force" of result.json, an object per force.
nlohmann::ordered_json LastingForcesJson(const std::vector<LastingForce>& forces);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_RESULT_CORRECTIONS_JSON_H_
