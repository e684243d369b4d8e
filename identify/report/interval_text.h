// Intervals in tables.
#ifndef CLOTHID_IDENTIFY_REPORT_INTERVAL_TEXT_H_
#define CLOTHID_IDENTIFY_REPORT_INTERVAL_TEXT_H_

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "identify/base/join_words.h"

namespace clothid {

// "0.2398 .. 0.2402": with as many digits as tell the ends apart, by the standard deviation of the value. "-" where an
// end is NaN.
inline std::string IntervalText(double value, double std, double lower, double upper) {
  if (std::isnan(lower) || std::isnan(upper)) return "-";
  constexpr int kFewestDigits = 3, kMostDigits = 9;
  const double relative_std = std / std::max(std::abs(value), std);
  const int digits =
      2 + static_cast<int>(std::ceil(-std::log10(relative_std + std::numeric_limits<double>::epsilon())));
  const int shown = std::clamp(digits, kFewestDigits, kMostDigits);
  return NumberText(lower, shown) + " .. " + NumberText(upper, shown);
}

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPORT_INTERVAL_TEXT_H_
