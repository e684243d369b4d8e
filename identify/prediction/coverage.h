// What can be told of bands by one motion.
//
// Errors within one motion go together: where a draw of a cloud is too far to the left it is so for a while, and so are
// the nodes beside. So the share of one motion in the bands of 90 % scatters, by much, even if the bands are right; of
// n independent errors as a binomial, of a single error that all have in common it is 0 or 100 %. How far it scatters
// the cloud itself tells. If a prediction is right, what happens is one more draw. So each draw in turn is taken for
// what happens, and judged by what `BandsOf` makes of the others:
//   c_d = the share of measurements of which draw d lies in the bands of 90 % of all draws but d,
//   e_d = the root mean square of its deviation from their median.
// They are distributed as coverage and error of a right prediction of D - 1 draws are. So where the bands are right
// what happens holds less than the 5 % quantile of all c_d once in twenty times, and the median misses it by more than
// the 95 % quantile of all e_d as often: then they are too narrow, or this was that time. That bands are too wide the
// coverage hardly ever tells, as right ones often hold all of a motion. But then the median misses by less than the 5 %
// quantile of all e_d, which right ones do once in twenty times, too.
//
// Few draws make no bias: `BandsOf` takes its quantiles at the ranks p (n + 1), below which a further draw lies with
// probability p whatever the distribution, so the mean of all c_d is 90 % where p (n + 1) is whole, as for n = 19, and
// else up to half a per cent above for what it interpolates in a Gaussian tail (identify/prediction/coverage_test).
#ifndef CLOTHID_IDENTIFY_PREDICTION_COVERAGE_H_
#define CLOTHID_IDENTIFY_PREDICTION_COVERAGE_H_

#include <Eigen/Core>
#include <vector>

namespace clothid {

// What the others say of each of D >= 2 draws of one measurement.
struct ByOthers {
  explicit ByOthers(const Eigen::VectorXd& draws);

  Eigen::ArrayXd held;    // [D] 1 in their band of 90 %, ends included, else 0
  Eigen::ArrayXd missed;  // [D] what their median misses it by
};

// From the 5 to the 95 % quantile of right predictions.
struct RightRange {
  double low = 0.0, high = 0.0;
};

// c_d and e_d over measurements that are added one by one. Where a draw is missing in some of them, its numbers are of
// the others.
class LeaveOneOut {
 public:
  explicit LeaveOneOut(int num_draws);

  // One measurement: what is said of some draws [d], which they are, and their unit.
  void Add(const ByOthers& said, const std::vector<int>& draws, double unit);

  // [<= D] of the draws with measurements.
  Eigen::VectorXd Shares() const;
  Eigen::VectorXd Errors() const;

 private:
  Eigen::VectorXd Means(const Eigen::ArrayXd& sums) const;

  Eigen::ArrayXd held_, squares_, num_;  // [D]
};

// Of c_d or e_d [D], D >= 1.
RightRange RangeOf(const Eigen::VectorXd& numbers);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PREDICTION_COVERAGE_H_
