#include "datasets/checking/finding_words.h"

#include <algorithm>
#include <iomanip>
#include <sstream>

namespace clothid {
namespace {

constexpr std::size_t kMaxNamed = 8;  // frames or points that a text names

}  // namespace

std::string Rounded(double value) {
  std::ostringstream text;
  text << std::setprecision(3) << value;
  return text.str();
}

std::string Millimetres(double length) { return Rounded(1e3 * length) + " mm"; }

std::string Named(const std::string& what, const std::vector<int>& numbers) {
  std::string text = what + (numbers.size() == 1 ? " " : "s ");
  for (std::size_t i = 0; i < std::min(kMaxNamed, numbers.size()); ++i) {
    text += (i == 0 ? "" : ", ") + std::to_string(numbers[i]);
  }
  return numbers.size() > kMaxNamed ? text + ", .. (" + std::to_string(numbers.size()) + " of them)" : text;
}

}  // namespace clothid
