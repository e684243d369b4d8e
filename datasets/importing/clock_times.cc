#include "datasets/importing/clock_times.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>

#include "datasets/formats/npy_tracks.h"
#include "sim/base/error.h"
#include "sim/base/npy_file.h"
#include "sim/base/table.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr std::uint64_t kMaxTimesBytes = std::uint64_t{1} << 28;
constexpr double kMostWhole = 4e18;        // differences of which are a long long, too
constexpr std::size_t kSecondDigits = 10;  // of a time since 1970
constexpr std::size_t kNanosecondDigits = 9;

bool IsClockDigit(char c) { return c >= '0' && c <= '9'; }

using VectorXll = Eigen::Matrix<long long, Eigen::Dynamic, 1>;

// A stamp in a name, and how many of its units a s has.
struct Stamp {
  ClockTime time = ClockTime(0LL);
  double per_second = 1.0;
};

Stamp StampOfName(const std::string& path) {
  const std::string name = std::filesystem::path(path).stem().string();
  const auto digits_before = [&](std::size_t end) {
    std::size_t begin = end;
    while (begin > 0 && IsClockDigit(name[begin - 1])) --begin;
    return begin;
  };
  std::size_t end = name.size();
  while (end > 0 && !IsClockDigit(name[end - 1])) --end;
  std::size_t begin = digits_before(end);
  if (begin == end) FailOnData(path, "expected a time in its name, as in cloud_0.25");
  std::string text = name.substr(begin, end - begin);
  if (begin > 1 && (name[begin - 1] == '.' || name[begin - 1] == '_')) {
    const std::size_t whole = digits_before(begin - 1), num_digits = begin - 1 - whole;
    const bool is_second_and_nanosecond = num_digits == kSecondDigits && text.size() == kNanosecondDigits;
    if (num_digits > 0 && (name[begin - 1] == '.' || is_second_and_nanosecond)) {
      text = name.substr(whole, num_digits) + "." + text;
    }
  }
  const std::optional<ClockTime> time = ParseClockTime(text);
  if (!time) FailOnData(path, "expected a time in its name, found '" + Printable(text) + "'");
  if (text.find('.') != std::string::npos) return {*time};
  return {*time, text.size() == 13 ? 1e3 : text.size() == 16 ? 1e6 : text.size() == 19 ? 1e9 : 1.0};
}

// Of a .npy array of integers; nothing of any other file.
std::optional<FrameTimes> IntegerTimes(const std::string& path) {
  NpyIntegers array;
  try {
    array = ReadNpyIntegers(path);
  } catch (const Error&) {
    return std::nullopt;
  }
  if (array.shape.size() != 1 || array.values.empty()) FailOnData(path, "expected an array of shape (T)");
  std::vector<ClockTime> stamps;
  for (const long long value : array.values) stamps.emplace_back(value);
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    if (array.values[i] > array.values[i - 1]) continue;
    FailOnData(path, "the time of frame " + std::to_string(i) + ", " + std::to_string(array.values[i]) +
                         ", is not after the one before it, " + std::to_string(array.values[i - 1]));
  }
  FrameTimes result;
  result.since_first = SinceFirst(stamps);
  result.times = Eigen::Map<const VectorXll>(array.values.data(), result.since_first.size()).cast<double>();
  return result;
}

FrameTimes TimesOfTable(const std::string& path) {
  Table table(path, ReadText(path, kMaxTimesBytes), "time", HeaderLine::kOptional);
  const std::optional<std::size_t> short_name = table.Find("t");
  const std::size_t column = short_name ? *short_name : table.Require("time");
  std::vector<double> times;
  std::vector<ClockTime> stamps;
  while (table.NextRow()) {
    times.push_back(table.LaterTime(column));
    const std::optional<ClockTime> stamp = ParseClockTime(table.Digits(column));
    if (!stamp) table.FailAt(column, "a finite number");
    stamps.push_back(*stamp);
  }
  if (times.empty()) table.FailWithoutRows();
  FrameTimes result;
  result.times = Eigen::Map<Eigen::VectorXd>(times.data(), static_cast<Eigen::Index>(times.size()));
  result.since_first = SinceFirst(stamps) / table.UnitsPerSi(column, Quantity::kTime);
  return result;
}

}  // namespace

ClockTime::ClockTime(double value) : fraction(value) {
  if (!(std::abs(value) < kMostWhole)) return;
  whole = static_cast<long long>(std::floor(value));
  fraction = value - std::floor(value);
}

std::optional<ClockTime> ParseClockTime(std::string_view text) {
  const std::optional<double> value = ParseNumber(text);
  if (!value) return std::nullopt;
  const std::size_t point = std::min(text.find('.'), text.size());
  const std::string_view decimals = text.substr(std::min(point + 1, text.size()));
  const std::optional<long long> whole = ParseInteger(text.substr(0, point));
  const bool is_plain = std::all_of(decimals.begin(), decimals.end(), IsClockDigit);
  if (!whole || !is_plain || *whole < 0 || text.front() == '-' || !(*value < kMostWhole)) return ClockTime(*value);
  ClockTime time(*whole);
  time.fraction = *ParseNumber("0." + std::string(decimals) + "0");
  return time;
}

Eigen::VectorXd SinceFirst(const std::vector<ClockTime>& times) {
  Eigen::VectorXd since(static_cast<Eigen::Index>(times.size()));
  for (std::size_t i = 0; i < times.size(); ++i) {
    since[static_cast<Eigen::Index>(i)] =
        static_cast<double>(times[i].whole - times[0].whole) + (times[i].fraction - times[0].fraction);
  }
  return since;
}

FrameTimes ReadFrameTimes(const std::string& path) {
  if (std::filesystem::path(path).extension() != ".npy") return TimesOfTable(path);
  if (const std::optional<FrameTimes> integers = IntegerTimes(path)) return *integers;
  FrameTimes result;
  result.times = ReadNpyTimes(path);
  return result;
}

Eigen::VectorXd ReadTimes(const std::string& path) { return ReadFrameTimes(path).times; }

FrameTimes TimesOfNames(const std::vector<std::string>& paths) {
  std::vector<ClockTime> stamps;
  double per_second = 1.0;
  for (const std::string& path : paths) {
    const Stamp stamp = StampOfName(path);
    if (stamps.empty()) per_second = stamp.per_second;
    if (stamp.per_second != per_second)
      FailOnData(path, "expected a time of as many digits in its name as in " + paths[0]);
    stamps.push_back(stamp.time);
  }
  FrameTimes result;
  result.since_first = SinceFirst(stamps) / per_second;
  result.times.resize(result.since_first.size());
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    result.times[static_cast<Eigen::Index>(i)] = stamps[i].Rounded() / per_second;
  }
  return result;
}

}  // namespace clothid
