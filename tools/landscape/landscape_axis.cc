#include "tools/landscape/landscape_axis.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>

#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

[[noreturn]] void FailOnAxis(const std::string& flag, const std::string& text, const std::string& problem) {
  throw Error(ErrorKind::kUsage, flag + ": '" + Printable(text) + "': " + problem);
}

ParameterKind ParseKind(const std::string& name, const std::string& flag,
                        const std::vector<std::string>& obstacle_names, const std::vector<std::string>& piece_names) {
  ParameterId id;
  try {
    id = ParseParameter(name, obstacle_names, piece_names);
  } catch (const Error& error) {
    throw Error(ErrorKind::kUsage, flag + ": " + error.what());
  }
  if (id.kind == ParameterKind::kFriction && obstacle_names.empty())
    FailOnAxis(flag, name, "the scene has no obstacle");
  return id.kind;
}

double ToScale(ParameterScale scale, double value) { return scale == ParameterScale::kLog ? std::log(value) : value; }
double FromScale(ParameterScale scale, double value) { return scale == ParameterScale::kLog ? std::exp(value) : value; }

}  // namespace

LandscapeAxis ParseAxis(const std::string& text, const std::string& flag,
                        const std::vector<std::string>& obstacle_names, const std::vector<std::string>& piece_names) {
  const std::size_t equals = std::min(text.find('='), text.size());
  std::vector<std::string> items = Split(std::string_view(text).substr(std::min(equals + 1, text.size())), ':');
  const bool has_scale = items.size() == 4;
  const bool is_whole = items.size() == 3 || (has_scale && items[3] == "log");
  items.resize(3);
  const std::optional<double> lower = ParseNumber(items[0]), upper = ParseNumber(items[1]);
  const std::optional<long long> num_cells = ParseInteger(items[2]);
  if (!is_whole || !lower || !upper || !num_cells) {
    FailOnAxis(flag, text, "expected NAME=LOWER:UPPER:CELLS or NAME=LOWER:UPPER:CELLS:log");
  }
  LandscapeAxis axis;
  axis.parameter = text.substr(0, equals);
  axis.scale = has_scale ? ParameterScale::kLog : ParameterScale::kLinear;
  axis.lower = *lower;
  axis.upper = *upper;
  axis.num_cells = static_cast<int>(std::min<long long>(*num_cells, std::numeric_limits<int>::max()));
  const ParameterKind kind = ParseKind(axis.parameter, flag, obstacle_names, piece_names);
  if (!(axis.lower < axis.upper)) FailOnAxis(flag, text, "expected a lower end below the upper one");
  if (*num_cells < 2) FailOnAxis(flag, text, "expected at least 2 cells");
  if (has_scale && !(axis.lower > 0.0)) FailOnAxis(flag, text, "expected a lower end above 0 on a log axis");
  if (!IsInDomain(RowOf(kind).domain, axis.lower)) {
    const bool above = RowOf(kind).domain == ParameterDomain::kPositive;
    FailOnAxis(flag, text, above ? "expected a lower end above 0" : "expected a lower end of at least 0");
  }
  return axis;
}

LandscapeAxis ZoomInto(const LandscapeAxis& whole, double center, double zoom, const std::string& flag) {
  const double lower = ToScale(whole.scale, whole.lower), upper = ToScale(whole.scale, whole.upper);
  const double width = zoom * (upper - lower);
  const double start = std::clamp(ToScale(whole.scale, center) - width / 2.0, lower, upper - width);
  LandscapeAxis axis = whole;
  // An end of the whole is met exactly.
  if (start > lower) axis.lower = std::clamp(FromScale(whole.scale, start), whole.lower, whole.upper);
  if (start + width < upper) axis.upper = std::clamp(FromScale(whole.scale, start + width), whole.lower, whole.upper);
  for (int i = 1; i < axis.num_cells; ++i) {
    if (!(axis.Value(i) > axis.Value(i - 1))) {
      FailOnAxis(flag, ShortestText(zoom), "too small: the cells of '" + whole.parameter + "' fall on each other");
    }
  }
  return axis;
}

}  // namespace clothid
