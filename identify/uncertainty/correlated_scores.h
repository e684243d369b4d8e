// The covariance of estimates whose residuals are not independent: a sandwich over the frames of the recordings.
//
// The score of frame i is g_i = J_i^T e_i, its influence on the estimate u_i = (J^T J)^-1 g_i: to first order the noise
// moves the estimate by -sum u_i. So
//   Cov(q) = Cov(sum u_i) = (J^T J)^-1 Cov(sum g_i) (J^T J)^-1,
// whatever the covariance of the residuals is (White 1980; Liang and Zeger 1986 for clusters, here the frames:
// residuals that are correlated within a frame are correlated in its score). From frame to frame it is estimated with
// Bartlett weights (Newey and West 1987) after prewhitening (Andrews and Monahan 1992) with c, the correlation of
// successive residuals, which is known much better than that of p scores:
//   z_i = u_i - c u_{i-1},
//   W   = sum_i z_i z_i^T + sum_{l = 1, 2} (1 - l/3) sum_i (z_i z_{i+l}^T + z_{i+l} z_i^T),
//   Cov(q) = W/(1 - c)^2  T/(T - R)  T/(T - p),
// the last two for the first frame of each of the R recordings and for the p fitted parameters. Frames count, not
// seconds: where frames are further apart, their residuals are less correlated than this takes them to be.
//
// T frames say as much about a mean as T (1 - c)/(1 + c) independent ones, so intervals take Student's t with
//   nu = max(2, T (1 - c)/(1 + c) - p).
#ifndef CLOTHID_IDENTIFY_UNCERTAINTY_CORRELATED_SCORES_H_
#define CLOTHID_IDENTIFY_UNCERTAINTY_CORRELATED_SCORES_H_

#include <Eigen/Core>
#include <vector>

namespace clothid {

// The scores, or influences, of one recording [p x T], in the order of its frames. A frame of zeros (nothing seen, or
// seen before anything moved) is none.
using FrameSeries = std::vector<Eigen::MatrixXd>;

// The same without frames of zeros.
FrameSeries WithoutEmptyFrames(const FrameSeries& scores);

// Cov(sum u_i) [p x p] of the influences, without frames of zeros, for the correlation `autocorrelation` = c in [0, 1)
// of successive residuals. Zero where there are no more frames than recordings and parameters.
Eigen::MatrixXd CovarianceOfSum(const FrameSeries& influences, double autocorrelation);

// Whether residuals are correlated within frames: for independent ones the sum over frames of u_i^2 is, for every row,
// the variance `independent` [p] of the estimate, up to 2/T_e, T_e = 3 (sum u_i^2)^2/sum u_i^4 the number of frames
// that tell. Four times the root of that, and one half, above it is not chance.
bool IsCorrelatedWithinFrames(const FrameSeries& influences, const Eigen::VectorXd& independent);

// nu.
double ScoreDegreesOfFreedom(const FrameSeries& influences, double autocorrelation);

// The half-width of a 95 % interval of Student's t in standard deviations, nu >= 2 (Hill 1970, Communications of the
// ACM, algorithm 396: six digits).
double Student95(double degrees_of_freedom);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_UNCERTAINTY_CORRELATED_SCORES_H_
