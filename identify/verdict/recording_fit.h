// How a fit reproduces each of its recordings, against the sizes that tell whether that is good.
#ifndef CLOTHID_IDENTIFY_VERDICT_RECORDING_FIT_H_
#define CLOTHID_IDENTIFY_VERDICT_RECORDING_FIT_H_

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "datasets/observation/observation.h"
#include "datasets/observation/start_difference.h"
#include "identify/fit/fit_summary.h"

namespace clothid {

struct RecordingFit {
  std::string name;                                         // of the recording
  PredictionError error;                                    // at the estimate
  double cloth_size = 0.0;                                  // m, the square root of the rest area
  double noise = std::numeric_limits<double>::quiet_NaN();  // m, the rmse that sigma alone makes; NaN: not known
  ModelError model_error;                                   // that frames were weighed by
  std::optional<StartDifference> start;                     // to the first frame, with a fitted frame of reference
  bool starts_at_noise = false;                             // noisy frames were taken for the start of the cloth

  // m, root mean square distance of the measured points to their means over time; NaN without tracked points.
  double motion() const;
};

// Of every recording of a fit that has an estimate, in their order. Throws `Error` where `Observation` does.
std::vector<RecordingFit> DescribeRecordings(const std::vector<RecordedMotion>& motions, const FitSummary& summary);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_VERDICT_RECORDING_FIT_H_
