// Times as a clock tells them. One that counts from 1970 tells more digits than a double has, which resolves 0.24 us of
// such times in s: they are kept where times are subtracted before they are rounded.
#ifndef CLOTHID_DATASETS_IMPORTING_CLOCK_TIMES_H_
#define CLOTHID_DATASETS_IMPORTING_CLOCK_TIMES_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace clothid {

// whole + fraction, without rounding.
struct ClockTime {
  long long whole = 0;
  double fraction = 0.0;  // of a number beyond long long all of it

  explicit ClockTime(double value);
  explicit ClockTime(long long integer) : whole(integer) {}
  double Rounded() const { return static_cast<double>(whole) + fraction; }
};

// A number with every digit: decimals without an exponent, else as ParseNumber has it.
std::optional<ClockTime> ParseClockTime(std::string_view text);

// [T]: times less the first of them.
Eigen::VectorXd SinceFirst(const std::vector<ClockTime>& times);

struct FrameTimes {
  Eigen::VectorXd times;        // [T]
  Eigen::VectorXd since_first;  // [T] times less the first, subtracted before they were rounded; empty: as `times` are
};

// Times, which increase: a .npy array of shape (T), of integers, too; else a table (sim/base/table.h) with a column
// `time` or `t`, or with one column and no header. Integers and decimals keep every digit. Throws `Error`: kIo, or
// kBadData naming file and line.
FrameTimes ReadFrameTimes(const std::string& path);
Eigen::VectorXd ReadTimes(const std::string& path);

// The times, in s, that files have by their names: the last number in each, "cloud_0.25.ply", "1700000000.033333.npy".
// Integers of 13, 16 and 19 digits are ms, us and ns since 1970; "1700000000_033333000" is s and ns. Throws `Error`
// (kBadData), naming a file without a number.
FrameTimes TimesOfNames(const std::vector<std::string>& paths);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_IMPORTING_CLOCK_TIMES_H_
