#include "tools/benchmark/base/common.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {

void RequireKnown(const std::vector<std::string>& items, const std::vector<std::string>& known,
                  const std::string& flag) {
  ExpectUsage(!items.empty(), flag + ": expected at least one name");
  std::string list;
  for (const std::string& name : known) list += (list.empty() ? "" : ", ") + name;
  for (const std::string& item : items) {
    ExpectUsage(std::find(known.begin(), known.end(), item) != known.end(),
                flag + ": '" + Printable(item) + "': expected any of " + list);
  }
}

Integrator IntegratorNamed(const std::string& name) {
  RequireKnown({name}, kIntegratorNames, "--integrator");
  return name == "euler" ? Integrator::kEuler : Integrator::kSdirk2;
}

std::string Format(const char* format, ...) {
  va_list arguments, copy;
  va_start(arguments, format);
  va_copy(copy, arguments);
  std::string text(static_cast<std::size_t>(std::vsnprintf(nullptr, 0, format, copy)), '\0');
  va_end(copy);
  std::vsnprintf(text.data(), text.size() + 1, format, arguments);
  va_end(arguments);
  return text;
}

std::string FixedNumber(double value, int digits) { return std::isfinite(value) ? Format("%.*f", digits, value) : "-"; }

std::string GeneralNumber(double value, int digits) {
  return std::isfinite(value) ? Format("%.*g", digits, value) : "-";
}

}  // namespace clothid
