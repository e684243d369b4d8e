// The page of a prediction: `simulate --result .. --view FILE`.
#ifndef CLOTHID_TOOLS_SIMULATE_PREDICTION_VIEW_H_
#define CLOTHID_TOOLS_SIMULATE_PREDICTION_VIEW_H_

#include <vector>

#include "identify/prediction/prediction.h"
#include "identify/view/view_page.h"

namespace clothid {

// Spread and motion over time, the shares of what makes the spread, and bands of what was asked for; in words what
// dominates at the end, and until when the prediction is worth more than the cloth at rest.
PredictionView ViewOf(const FitPosterior& posterior, const Prediction& prediction);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_SIMULATE_PREDICTION_VIEW_H_
