// A fit with a profile of the wind whose smoothness is chosen.
//
// With L the residuals of neighbouring knots for a smoothness of 1 (identify/uncertainty/priors.h), w the knots and S
// the smoothness, the marginal likelihood is stationary where
//   S^2 = |L w|^2/(gamma s^2),   gamma = n - tr(L H^-1 L^T)/S^2,   H = J^T J + P + L^T L/S^2
// (MacKay 1992), n the number of differences, gamma that of those which the recordings determine, s^2 as for intervals;
// w and s^2 are those where the linear model has its minimum for that S. So a fit says with which S the next one goes
// on from its end, until S changes no more.
#ifndef CLOTHID_IDENTIFY_WIND_WIND_FIT_H_
#define CLOTHID_IDENTIFY_WIND_WIND_FIT_H_

#include <memory>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "identify/base/options.h"
#include "identify/fit/fit_summary.h"
#include "identify/fit/problem.h"
#include "identify/uncertainty/uncertainty.h"

namespace clothid {

class GrowingHorizon;

inline constexpr double kFirstWindSmoothness = 0.3;  // m/s in a second
inline constexpr double kLeastWindSmoothness = 1e-3, kMostWindSmoothness = 1e3;

// S for the linear model at `coordinates` [p], of blocks that are linked with the smoothness `smoothness`, where they
// are not frozen or at a bound. `linearization`: of the recordings, of the p blocks alone.
double StationarySmoothness(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                            const Linearization& linearization, double smoothness);

// `options` with a smoothness to start with, and `problem` made with it, become those of the last fit. `is_chosen`: the
// smoothness of the last fit is such a choice; false where the fit ended before.
FitSummary FitWithChosenSmoothness(const std::vector<RecordedMotion>& motions, GrowingHorizon* horizon,
                                   FitOptions* options, std::unique_ptr<FitProblem>* problem, bool* is_chosen);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_WIND_WIND_FIT_H_
