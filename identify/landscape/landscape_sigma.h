// The standard deviation by which the costs of a scan were weighed, and what they say of the error in metres.
#ifndef CLOTHID_IDENTIFY_LANDSCAPE_LANDSCAPE_SIGMA_H_
#define CLOTHID_IDENTIFY_LANDSCAPE_LANDSCAPE_SIGMA_H_

#include <limits>

#include "datasets/motion/recorded_motion.h"

namespace clothid {

struct LandscapeSigma {
  SigmaSource source = SigmaSource::kUnknown;
  // m, of a coordinate; where nobody knows it, what `Observation` takes for it. NaN: points differ.
  double value = std::numeric_limits<double>::quiet_NaN();
  double rmse_of_root_cost = std::numeric_limits<double>::quiet_NaN();  // m, see `RmseOfRootCost`
};

// That of the residuals of `motion`. Throws `Error` where `Observation` does.
LandscapeSigma SigmaOf(const RecordedMotion& motion);

// Whether both weigh the residuals of the same recording alike.
bool IsSameSigma(const LandscapeSigma& a, const LandscapeSigma& b);

// m: the factor between the root mean square distance of seen points and the square root of the cost without a loss,
//   rmse = sigma sqrt(2 L/n),   n the seen coordinates over 3, and the points of clouds; NaN unless all have
//   one sigma, and where forces, or distances to the border, are part of the cost.
double RmseOfRootCost(const RecordedMotion& motion);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_LANDSCAPE_LANDSCAPE_SIGMA_H_
