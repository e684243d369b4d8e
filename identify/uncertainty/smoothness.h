// How smooth something is believed to be, chosen by what was measured.
//
// Beside the residuals e with their Jacobian J a fit may have priors  w_g/2 |R_g z|^2  of smoothness: of a field,
// |R z|^2 is the integral of a squared Laplacian, of a wind that changes over time the sum of squared increments. Their
// weights w_g are stationary points of the marginal likelihood (MacKay 1992) where
//   w_g = s^2 gamma_g/|R_g z|^2,   gamma_g = rank R_g - w_g tr(R_g H^-1 R_g^T),   H = J^T J + sum_g w_g R_g^T R_g,
// gamma_g being how many of the differences R_g z the measurements determine, s^2 as for intervals
// (identify/uncertainty/uncertainty.h) with these counted as fitted. z and e are those where the linear model has its
// minimum for these weights: they follow w, and what is left of an unfinished fit does not go into it.
#ifndef CLOTHID_IDENTIFY_UNCERTAINTY_SMOOTHNESS_H_
#define CLOTHID_IDENTIFY_UNCERTAINTY_SMOOTHNESS_H_

#include <Eigen/Core>
#include <vector>

namespace clothid {

// A linear least-squares problem in the changes of c coordinates about a point.
struct SmoothnessModel {
  Eigen::MatrixXd curvature;        // J^T J [c x c], priors that have no weight of this kind among the rows of J
  Eigen::VectorXd gradient;         // J^T e [c]
  double squared_residual = 0.0;    // |e|^2
  double degrees_of_freedom = 1.0;  // m, less the fitted coordinates that no R_g touches
  bool sigma_is_known = true;
  std::vector<Eigen::MatrixXd> roots;   // R_g [r x c]
  std::vector<Eigen::VectorXd> values;  // R_g z [r] at the point
};

class SmoothnessChooser {
 public:
  // The coordinates that no root touches are eliminated: they follow.
  explicit SmoothnessChooser(const SmoothnessModel& model);

  // Beyond it what prior g speaks of is as good as perfectly smooth: the largest curvature relative to R_g^T R_g.
  double LargestWeight(int g) const { return largest_[g]; }
  // From weights [g] towards the fixed point, round by round, until they change by less than 1e-5 of themselves; each
  // stays within 1e-12 of LargestWeight and that, and where it is unless it `is_chosen` [g]. A weight of 0 starts at
  // LargestWeight: what wrong parameters leave unexplained must not make anything rough.
  Eigen::VectorXd Follow(Eigen::VectorXd weights, const std::vector<bool>& is_chosen, int most_rounds) const;
  // gamma_g [g].
  Eigen::VectorXd NumDetermined(const Eigen::VectorXd& weights) const;

 private:
  struct Solution {
    Eigen::VectorXd determined, roughness;  // gamma_g and |R_g z|^2 [g]
    double squared_scale = 0.0;             // s^2
  };
  Solution SolveFor(const Eigen::VectorXd& weights) const;

  SmoothnessModel model_;  // of the coordinates that are touched
  Eigen::VectorXd ranks_, largest_;
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_UNCERTAINTY_SMOOTHNESS_H_
