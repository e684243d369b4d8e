// What a model misses, in words.
#ifndef CLOTHID_IDENTIFY_VERDICT_MODEL_ERROR_TEXT_H_
#define CLOTHID_IDENTIFY_VERDICT_MODEL_ERROR_TEXT_H_

#include <string>
#include <vector>

#include "datasets/observation/model_error.h"
#include "identify/checks/lead_time.h"

namespace clothid {

// Of a deviation tau of one coordinate, of a distance to the surface or of a component of a force: the root mean square
// distance of points, m, which is sqrt(3) tau; tau.
double DistanceOf(double deviation, PredictedKind kind);
// The largest over time.
double LargestDistance(const ModelError& error, PredictedKind kind);

// "4.2 mm after 0.3 s and 2 mm at the end", of forces "0.1 N at the end"; empty where the model does not err.
std::string ModelErrorText(const ModelError& error);

// "1.2 mm after 0.1 s and 3 mm after 0.2 s (12 mm and 30 mm for a cloth that stays where it was seen)", of at least
// one.
std::string LeadTimesText(const std::vector<LeadTimeError>& lead_times);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_VERDICT_MODEL_ERROR_TEXT_H_
