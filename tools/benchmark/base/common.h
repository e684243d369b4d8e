// What all modes of `benchmark` share: progress, checks of flags, and the text of tables and CSV files.
#ifndef CLOTHID_TOOLS_BENCHMARK_BASE_COMMON_H_
#define CLOTHID_TOOLS_BENCHMARK_BASE_COMMON_H_

#include <functional>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/scene/scene.h"

namespace clothid {

inline constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

// Told after every item of a benchmark, in the order in which they end, never two at a time; may be empty.
using BenchmarkProgress = std::function<void(const std::string& item, int num_done, int num_items)>;

// Throws `Error` (kUsage), led by `flag`, unless there is at least one of `items` and each is one of `known`.
void RequireKnown(const std::vector<std::string>& items, const std::vector<std::string>& known,
                  const std::string& flag);

inline const std::vector<std::string> kIntegratorNames = {"euler", "sdirk2"};
// Throws `Error` (kUsage), naming --integrator, for an unknown name.
Integrator IntegratorNamed(const std::string& name);

// As printf.
std::string Format(const char* format, ...) __attribute__((format(printf, 1, 2)));
// "1.50", "1.5" with so many digits; "-" where there is no number.
std::string FixedNumber(double value, int digits);
std::string GeneralNumber(double value, int digits = 4);

// A line of a CSV file, with all digits of its numbers.
template <typename... Values>
std::string CsvLine(const Values&... values) {
  std::ostringstream line;
  line.precision(std::numeric_limits<double>::max_digits10);
  const char* separator = "";
  ((line << separator << values, separator = ","), ...);
  return line.str() + "\n";
}

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_BASE_COMMON_H_
