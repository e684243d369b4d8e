// The fitted profiles of the wind, put together from the parameters that their knots are.
#ifndef CLOTHID_IDENTIFY_WIND_WIND_RESULT_H_
#define CLOTHID_IDENTIFY_WIND_WIND_RESULT_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "identify/estimate/fit_summary.h"
#include "identify/problem/problem.h"
#include "sim/air/wind.h"

namespace clothid {

// One component of the wind of one recording.
struct FittedWind {
  int recording = 0, axis = 0;
  std::vector<int> parameters;           // [K] indices into `FitSummary::parameters`
  Eigen::VectorXd times, values, start;  // [K] s, m/s
  Eigen::VectorXd lower95, upper95;      // [K] NaN where there is no interval
  int num_told = 0;                      // knots that the recording tells without what is believed of their neighbours
};

// Of the smoothness of a profile.
enum class SmoothnessSource {
  kGiven,
  kChosen,     // by the marginal likelihood
  kNotChosen,  // yet: the fit ended before
};
const char* SmoothnessWords(SmoothnessSource source);

struct WindResult {
  double smoothness = 0.0;  // m/s in a second (`FitOptions::wind_smoothness`)
  SmoothnessSource smoothness_source = SmoothnessSource::kGiven;
  std::vector<FittedWind> winds;      // by recording and component
  std::vector<WindProfile> profiles;  // of every recording, at the estimate, with the components that were not fitted
};

// `problem` is that of the summary.
WindResult DescribeWind(const std::vector<RecordedMotion>& motions, const FitSummary& summary,
                        const FitProblem& problem);

// One line: "y over 8 knots: 0.12 .. 1.43 m/s, 95 % intervals +- 0.2 .. 0.5 m/s, told at 7 of 8 knots".
std::string DescribeFittedWind(const FittedWind& wind);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_WIND_WIND_RESULT_H_
