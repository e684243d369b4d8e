#include "datasets/importing/path_times.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/median.h"
#include "sim/base/text_file.h"

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

void ExpectSeconds(const Eigen::VectorXd& times, const std::string& source) {
  // Of a sensor with 2 to 2000 readings a second.
  constexpr double kMicroseconds = 500.0, kNanoseconds = 5e5;  // at least, from one time to the next
  if (times.size() < 3) return;
  std::vector<double> intervals;
  for (Eigen::Index i = 1; i < times.size(); ++i) intervals.push_back(times[i] - times[i - 1]);
  const double interval = Median(std::move(intervals));
  if (!(interval >= kMicroseconds)) return;
  const bool is_nano = interval >= kNanoseconds;
  FailOnData(source, std::string("times look like ") + (is_nano ? "nanoseconds" : "microseconds") + ", with " +
                         ShortestText(interval) + " from one to the next; expected s: divide by " +
                         (is_nano ? "1e9" : "1e6"));
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
