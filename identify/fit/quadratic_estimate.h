// The estimate of a cost that is rough.
//
// Kinks of contact and buckling may be small beside the noise, but a derivative sees nothing else: a fit ends at one,
// and the covariance there is that of one side of it. At distances that the residuals make plausible such a cost is
// smooth again. So where a fit has stalled or ended in a dent, the cost is evaluated at points about the estimate, all
// else following the parameters, and a quadratic is fitted to it (identify/uncertainty/fitted_quadratic.h):
//   points    q +- d_i along every parameter, and for every pair q +- (d_i, d_j) together; of two parameters the other
//             two corners, too, of one six. Not the estimate itself, which the fit has chosen for its low cost.
//   distance  d at first where the cost rises by 2 s^2 as residuals tell it, but at least 1 %; three times as far,
//             up to 30 %, until the quadratic is convex, explains 90 % of the scatter of the costs and holds farther
//             out: at 3 d the cost has risen by a third of what it promises, or what it describes is a dent.
//   moves     the points go along with the minimum of the quadratic, by no more than d at a time, until it lies well
//             within them.
// Its minimum is the estimate then, and its second derivative takes the place of J^T J in the covariance. Scores of
// frames, for residuals that are correlated, are those of the mean derivative between the points; and the minimum is no
// surer than the roughness about the quadratic leaves it.
#ifndef CLOTHID_IDENTIFY_FIT_QUADRATIC_ESTIMATE_H_
#define CLOTHID_IDENTIFY_FIT_QUADRATIC_ESTIMATE_H_

#include "identify/base/options.h"
#include "identify/fit/fit_summary.h"
#include "identify/problem/problem.h"

namespace clothid {

// Costs that a quadratic may take.
inline constexpr int kMostQuadraticEvaluations = 60;
// Parameters of more points than that.
inline constexpr int kMostQuadraticParameters = 8;

// Fills `summary->quadratic` of a converged fit that has stalled or lies in a dent, by up to kMostQuadraticParameters
// parameters, and where one is accepted makes its minimum the estimate, with its uncertainty; the checks of the
// interval before are void then, for the quadratic is one. Not where the points have left the estimate of before behind
// and the cost at the minimum is higher by more than three times the roughness. Adds the work to the counts.
void EstimateFromQuadratic(const FitOptions& options, const FitProblem& problem, FitSummary* summary);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIT_QUADRATIC_ESTIMATE_H_
