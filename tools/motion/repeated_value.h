// What a test tells that was repeated.
#ifndef CLOTHID_TOOLS_MOTION_REPEATED_VALUE_H_
#define CLOTHID_TOOLS_MOTION_REPEATED_VALUE_H_

#include <Eigen/Core>

namespace clothid {

// n values that are taken to be normally distributed. Without n > 1 only the mean is known, the rest is NaN.
struct RepeatedValue {
  int count = 0;
  double mean = 0.0;
  double std = 0.0;       // s, of the values
  double half95 = 0.0;    // half the 95 % interval of the mean, t_(n-1) s/sqrt(n)
  double mean_std = 0.0;  // of a normal distribution with that interval, half95/1.96
  double next_std = 0.0;  // likewise of the next value, t_(n-1) s sqrt(1 + 1/n)/1.96

  bool is_repeated() const { return count > 1; }
};

RepeatedValue MeanOfRepetitions(const Eigen::VectorXd& values);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_MOTION_REPEATED_VALUE_H_
