// What a model misses, in words.
#ifndef CLOTHID_IDENTIFY_VERDICT_MODEL_ERROR_TEXT_H_
#define CLOTHID_IDENTIFY_VERDICT_MODEL_ERROR_TEXT_H_

#include <string>

#include "datasets/observation/model_error.h"

namespace clothid {

// Of a deviation tau of one coordinate, of a distance to the surface or of a component of a force: the root mean square
// distance of points, m, which is sqrt(3) tau; tau.
double DistanceOf(double deviation, PredictedKind kind);
// The largest over time.
double LargestDistance(const ModelError& error, PredictedKind kind);

// "4.2 mm after 0.3 s and 2 mm at the end", of forces "0.1 N at the end"; empty where the model does not err.
std::string ModelErrorText(const ModelError& error);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_VERDICT_MODEL_ERROR_TEXT_H_
