// What report.html shows of a landscape: maps of the cost over two parameters of the fit.
#ifndef CLOTHID_IDENTIFY_REPORT_REPORT_LANDSCAPE_H_
#define CLOTHID_IDENTIFY_REPORT_REPORT_LANDSCAPE_H_

#include <Eigen/Core>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "identify/fit/fit.h"
#include "identify/landscape/fit_landscape.h"
#include "identify/verdict/verdict.h"

namespace clothid {

// The bytes that `max_bytes` allows, with every k-th cell of larger maps. Keys: recording (its index), x and y
// (parameter of the fit, scale), windows (zoom, every, x, y, cost with x fastest and null where a rollout failed,
// failed cells and why), rmse_of_root_cost (m or null), estimate_rmse_m (null where the rmse of a cell cannot be
// compared with it), region
// ([2 x n] points of x and y, see `ConfidenceRegion`, or null) and notes, in which the map differs from the fit.
// `MatchLandscape` must have seen it.
nlohmann::ordered_json LandscapeJson(const FitLandscape& landscape, const FitSummary& summary, const FitChecks& checks,
                                     const std::vector<RecordedMotion>& motions, std::size_t max_bytes);

// The border of the joint 95 % region of both parameters, [2 x n] in their own units, closed:
//   q = q_hat + r C^1/2 (cos, sin),   C the covariance of both internal coordinates, whatever the others are,
//   r = sqrt(5.99) (chi-square of two degrees of freedom), times quantile95/1.96 where intervals are widened.
// Empty where one of both has no standard deviation.
Eigen::Matrix2Xd ConfidenceRegion(const FitLandscape& landscape, const FitSummary& summary);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPORT_REPORT_LANDSCAPE_H_
