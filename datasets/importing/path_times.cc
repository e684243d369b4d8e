#include "datasets/importing/path_times.h"

#include <algorithm>

#include "sim/base/error.h"

namespace clothid {

void FailOfClock(const Eigen::VectorXd& known, const Eigen::VectorXd& times, const std::string& source,
                 const std::string& expected) {
  throw Error(ErrorKind::kBadData, source + ": is known from " + std::to_string(known[0]) + " s to " +
                                       std::to_string(known[known.size() - 1]) +
                                       " s on the clock of the recording, which lasts from " +
                                       std::to_string(times[0]) + " s to " + std::to_string(times[times.size() - 1]) +
                                       " s; expected " + expected);
}

void ExpectCovered(const Eigen::VectorXd& known, const Eigen::VectorXd& times, const std::string& source) {
  double longest = 0.0;
  for (Eigen::Index i = 1; i < known.size(); ++i) longest = std::max(longest, known[i] - known[i - 1]);
  const double first = known[0], last = known[known.size() - 1];
  if (known.size() == 1 || (times[0] >= first - longest && times[times.size() - 1] <= last + longest)) return;
  FailOfClock(known, times, source, "another time offset");
}

KnotRange NeededKnots(const Eigen::VectorXd& knots, const Eigen::VectorXd& times) {
  constexpr Eigen::Index kBeside = 2;
  const double *begin = knots.data(), *end = begin + knots.size();
  const Eigen::Index from = std::lower_bound(begin, end, times[0]) - begin,
                     to = std::upper_bound(begin, end, times[times.size() - 1]) - begin;
  const Eigen::Index first = std::max<Eigen::Index>(0, from - kBeside);
  return {first, std::min(knots.size(), to + kBeside) - first};
}

}  // namespace clothid
