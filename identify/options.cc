#include "identify/options.h"

#include <algorithm>
#include <optional>
#include <string_view>

#include "sim/error.h"
#include "sim/text_file.h"

namespace clothid {
namespace {

[[noreturn]] void Fail(const std::string& message) { throw Error(ErrorKind::kUsage, message); }

std::vector<std::string> Split(const std::string& text, char separator) {
  std::vector<std::string> items;
  std::size_t begin = 0;
  for (std::size_t end = text.find(separator); end != std::string::npos; end = text.find(separator, begin)) {
    items.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  items.push_back(text.substr(begin));
  return items;
}

}  // namespace

void FitOptions::Validate() const {
  if (max_iterations < 1) Fail("--max_iterations: expected a number >= 1");
  if (num_starts < 1) Fail("--starts: expected a number >= 1");
  if (num_threads < 1) Fail("--threads: expected a number >= 1");
  if (!(function_tolerance > 0.0)) Fail("function_tolerance: expected a number > 0");
  if (!(parameter_tolerance > 0.0)) Fail("parameter_tolerance: expected a number > 0");
}

std::vector<std::string> ParseNames(const std::string& text, const std::string& flag) {
  std::vector<std::string> names;
  if (text.empty()) return names;
  for (const std::string& name : Split(text, ',')) {
    if (name.empty()) Fail(flag + ": expected names separated by single commas, got '" + Printable(text) + "'");
    if (std::count(names.begin(), names.end(), name) > 0) Fail(flag + ": '" + name + "' is given twice");
    names.push_back(name);
  }
  return names;
}

std::map<std::string, double> ParseParameterValues(const std::string& text, const std::string& flag) {
  std::map<std::string, double> values;
  if (text.empty()) return values;
  for (const std::string& item : Split(text, ',')) {
    const std::size_t equals = item.find('=');
    if (equals == std::string::npos || equals == 0)
      Fail(flag + ": expected NAME=NUMBER, got '" + Printable(item) + "'");
    const std::string name = item.substr(0, equals);
    const std::optional<double> value = ParseNumber(std::string_view(item).substr(equals + 1));
    if (!value) Fail(flag + ": expected a finite number for '" + Printable(name) + "'");
    if (!values.emplace(name, *value).second) Fail(flag + ": '" + name + "' is given twice");
  }
  return values;
}

FitMethod ParseFitMethod(const std::string& text) {
  if (text == "lm") return FitMethod::kLevenbergMarquardt;
  if (text == "lbfgs") return FitMethod::kLbfgs;
  Fail("--method: expected lm or lbfgs, got '" + Printable(text) + "'");
}

JacobianMethod ParseJacobianMethod(const std::string& text) {
  for (JacobianMethod method : {JacobianMethod::kAdjoint, JacobianMethod::kSensitivity, JacobianMethod::kNumeric}) {
    if (text == JacobianMethodName(method)) return method;
  }
  Fail("--jacobian: expected adjoint, sensitivity or numeric, got '" + Printable(text) + "'");
}

std::string JacobianMethodName(JacobianMethod method) {
  switch (method) {
    case JacobianMethod::kAdjoint:
      return "adjoint";
    case JacobianMethod::kSensitivity:
      return "sensitivity";
    case JacobianMethod::kNumeric:
      return "numeric";
  }
  return "unknown";
}

}  // namespace clothid
