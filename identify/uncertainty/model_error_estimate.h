// How far the model errs, from the residuals that a fit leaves.
//
// With residuals e_i over sigma_i at the times t_i and the variances (in sigma_i^2)
//   v_i = 1 + tau(t_i)^2/sigma_i^2,   tau(t)^2 = sum_k c_k phi_k(t),   c_k >= 0,
// phi_k the hat functions of knots at the shares (k/K)^2 of the rollout, the c_k are where the likelihood
//   -2 log L = sum_i h log v_i + e_i^2/v_i,   h = (m - p)/m,
// is least (restricted: p of the m residuals are fitted away). At the start of the rollout c = 0: the cloth is where it
// was seen. By Fisher scoring with the bounds kept. Where the likelihood does not gain what chance could not, the model
// does not err: every c is zero then.
//
// How many residuals err alike is seen in the products of frames, G_tu = sum_r e_rt e_ru over the R rows that they have
// in common. With S_t = G_tt - R, what the model errs by in a frame, c the correlation from frame to frame and N the
// number of rows of a frame that err independently of each other, for t != u
//   E G_tt+1 = c sqrt(S_t S_t+1),   E G_tu^2 = S_t S_u (k + (1 - k)/N) + S_t + S_u + R,   k = c^(2 |t - u|),
// the last three for the noise. That gives c and N, and
//   n = R/N min(T, (1 + c)/(1 - c)).
#ifndef CLOTHID_IDENTIFY_UNCERTAINTY_MODEL_ERROR_ESTIMATE_H_
#define CLOTHID_IDENTIFY_UNCERTAINTY_MODEL_ERROR_ESTIMATE_H_

#include <Eigen/Core>
#include <map>
#include <utility>

#include "datasets/observation/model_error.h"

namespace clothid {

// Rows of one kind. The likelihood takes those of one time and one sigma together, so that a large recording needs no
// more than its number of frames.
class ErrorRows {
 public:
  struct Sum {
    double count = 0.0;
    double squares = 0.0;  // of e_i^2
  };

  // A row at `time` s, its sigma in m or N, and its e_i^2 as a loss weighs it.
  void Add(double time, double sigma, double square);
  // By time and sigma.
  const std::map<std::pair<double, double>, Sum>& sums() const { return sums_; }

 private:
  std::map<std::pair<double, double>, Sum> sums_;
};

inline constexpr int kMostErrorKnots = 10;  // beside the first
// What -2 log L gains where there is nothing but noise is chi-squared of about half of the knots: above this with a
// probability below 1e-6.
inline constexpr double kLeastGain = 40.0;

// The knots are from `start` to the last of the rows, no more than one for every second time of theirs.
// `degrees_of_freedom`: h.
ErrorCurve EstimateErrorCurve(const ErrorRows& rows, double start, double degrees_of_freedom);

// n, of the residuals over sigma of one kind, the same row of every frame being the same point and axis [R x T]; NaN:
// not seen. 1 where they are those of noise, more than a recording says or lasting from frame to frame as it may be:
// the model errs by what points have in common. `is_absorbed`: of a fit that has taken over what it could of an error
// of the model, so that they are less alike than the error: rows of a frame that are alike at all are taken for those
// of one displacement then, N = 3.
double NumAlike(const Eigen::MatrixXd& frames, bool is_absorbed);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_UNCERTAINTY_MODEL_ERROR_ESTIMATE_H_
