#include "tools/motion/repeated_value.h"

#include <cmath>
#include <limits>

#include "identify/repetition/distributions.h"
#include "identify/uncertainty/uncertainty.h"

namespace clothid {

RepeatedValue MeanOfRepetitions(const Eigen::VectorXd& values) {
  RepeatedValue result;
  result.count = static_cast<int>(values.size());
  result.mean = values.mean();
  result.std = result.half95 = result.mean_std = result.next_std = std::numeric_limits<double>::quiet_NaN();
  if (!result.is_repeated()) return result;
  const double count = result.count, half_width = StudentHalfWidth95(result.count - 1);
  result.std = std::sqrt((values.array() - result.mean).square().sum() / (count - 1.0));
  result.half95 = half_width * result.std / std::sqrt(count);
  result.mean_std = result.half95 / kNormal95;
  result.next_std = result.mean_std * std::sqrt(count + 1.0);
  return result;
}

}  // namespace clothid
