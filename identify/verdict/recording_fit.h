// How a fit reproduces each of its recordings, against the sizes that tell whether that is good.
#ifndef CLOTHID_IDENTIFY_VERDICT_RECORDING_FIT_H_
#define CLOTHID_IDENTIFY_VERDICT_RECORDING_FIT_H_

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "costs/prediction/robust_loss.h"
#include "datasets/motion/recorded_motion.h"
#include "datasets/observation/observation.h"
#include "datasets/observation/start_difference.h"
#include "identify/estimate/fit_summary.h"

namespace clothid {

// What the fit's loss makes of a recording. It discounts a point of a frame, or the distance of one to the surface,
// that counts for less than half and is farther than kFarFromSurface sigma. Up to a fifth of all may be gross errors;
// where it is more, it is the model that errs, too.
struct Discounted {
  static constexpr double kMostGross = 0.2;
  double share = 0.0;     // of the points
  PredictionError error;  // at the estimate, without them: where they are more, without the worst fifth of all points

  bool is_many() const { return share > kMostGross; }
};

struct RecordingFit {
  std::string name;                                         // of the recording
  PredictionError error;                                    // at the estimate
  std::optional<Discounted> discounted;                     // where they make the error clearly larger
  double cloth_size = 0.0;                                  // m, the square root of the rest area
  double noise = std::numeric_limits<double>::quiet_NaN();  // m, the rmse that sigma alone makes; NaN: not known
  ModelError model_error;                                   // that frames were weighed by
  std::optional<StartDifference> start;                     // to the first frame, with a fitted frame of reference
  bool starts_at_noise = false;                             // noisy frames were taken for the start of the cloth

  // What the fit is judged by.
  const PredictionError& judged() const { return discounted ? discounted->error : error; }
  // m, root mean square distance of the measured points to their means over time; NaN without tracked points.
  double motion() const;
};

// Of every recording of a fit with `loss` that has an estimate, in their order. Throws `Error` where `Observation`
// does.
std::vector<RecordingFit> DescribeRecordings(const std::vector<RecordedMotion>& motions, const FitSummary& summary,
                                             const RobustLoss& loss = {});

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_VERDICT_RECORDING_FIT_H_
