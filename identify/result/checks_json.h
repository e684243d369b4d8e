// The parts of result.json about checks of a fit: other starts, profiles, other steps and meshes, what was held out.
#ifndef CLOTHID_IDENTIFY_RESULT_CHECKS_JSON_H_
#define CLOTHID_IDENTIFY_RESULT_CHECKS_JSON_H_

#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "identify/verdict/verdict.h"

namespace clothid {

// Each of these is null where the check was not asked for.
nlohmann::ordered_json StartsJson(const FitSummary& summary, const FitChecks& checks);
nlohmann::ordered_json ProfilesJson(const FitChecks& checks);
nlohmann::ordered_json RepeatedFitJson(const FitSummary& summary, const std::optional<RepeatedFit>& fit);
nlohmann::ordered_json HoldoutJson(const FitChecks& checks);

nlohmann::ordered_json StepChoiceJson(const StepChoice& choice);

// An object per lead time, with the rmse of predictions and of the cloth at rest.
nlohmann::ordered_json LeadTimesJson(const std::vector<LeadTimeError>& lead_times);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_RESULT_CHECKS_JSON_H_
