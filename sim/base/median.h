// The median of a sample.
#ifndef CLOTHID_SIM_BASE_MEDIAN_H_
#define CLOTHID_SIM_BASE_MEDIAN_H_

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace clothid {

// Of those that are not NaN, the upper of the two in the middle; NaN where there are none.
inline double Median(std::vector<double> values) {
  values.erase(std::remove_if(values.begin(), values.end(), [](double value) { return std::isnan(value); }),
               values.end());
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

inline double Median(const Eigen::VectorXd& values) {
  return Median(std::vector<double>(values.begin(), values.end()));
}

}  // namespace clothid

#endif  // CLOTHID_SIM_BASE_MEDIAN_H_
