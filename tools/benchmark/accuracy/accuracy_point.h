// One measurement of what accuracy costs, and which of them are worth their time.
#ifndef CLOTHID_TOOLS_BENCHMARK_ACCURACY_ACCURACY_POINT_H_
#define CLOTHID_TOOLS_BENCHMARK_ACCURACY_ACCURACY_POINT_H_

#include <limits>
#include <string>
#include <vector>

namespace clothid {

struct AccuracyPoint {
  std::string scene, setting;  // of kBenchmarkScenes and kBackpropSettings
  std::string quantity;        // of kAccuracyQuantities
  std::string reference;       // what the error is taken against; errors against others do not compare
  std::string method;
  double threshold = std::numeric_limits<double>::quiet_NaN();  // what `method` was solved to; NaN: directly
  int nodes = 0;                                                // along both axes
  double time_step = 0.0;                                       // s
  int iteration = 0;                                            // of a fit, else 0
  // Relative; NaN where a rollout failed, here or for the reference.
  double error = std::numeric_limits<double>::quiet_NaN();
  double seconds = std::numeric_limits<double>::quiet_NaN();  // processor time; NaN where a rollout failed
  // Steps that did not converge; gradient: linear systems that missed the threshold, so that LU stepped in.
  int steps_failed = 0;
};

inline const std::vector<std::string> kAccuracyQuantities = {"forward", "gradient", "fit"};

// Whether two points differ in nothing but what was done, so that errors and times compare.
bool AreComparable(const AccuracyPoint& a, const AccuracyPoint& b);

// For every point whether no comparable one is better: as fast and more accurate, or as accurate and faster. Of two
// that are as good the first; never one with an error of NaN.
std::vector<bool> ParetoFront(const std::vector<AccuracyPoint>& points);

// The fastest of `points` with an error of at most `error`; null where there is none.
const AccuracyPoint* FindCheapest(const std::vector<AccuracyPoint>& points, double error);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_ACCURACY_ACCURACY_POINT_H_
