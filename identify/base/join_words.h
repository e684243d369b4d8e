// Lists and numbers in sentences.
#ifndef CLOTHID_IDENTIFY_BASE_JOIN_WORDS_H_
#define CLOTHID_IDENTIFY_BASE_JOIN_WORDS_H_

#include <cstddef>
#include <iomanip>
#include <sstream>
#include <string>
#include <vector>

namespace clothid {

// "a", "a and b", "a, b and c".
inline std::string JoinWords(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 == words.size() ? " and " : ", ";
    text += words[i];
  }
  return text;
}

// "4.123", with that many digits; "1.234 mm" of metres.
inline std::string NumberText(double value, int digits = 4) {
  std::ostringstream text;
  text << std::setprecision(digits) << value;
  return text.str();
}
// "220 %" of 2.173, with 2 digits: never "2.2e+02 %".
inline std::string PercentText(double share, int digits) {
  return NumberText(std::stod(NumberText(100.0 * share, digits)), 15) + " %";
}
inline std::string MillimetreText(double metres, int digits = 4) { return NumberText(1e3 * metres, digits) + " mm"; }

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_BASE_JOIN_WORDS_H_
