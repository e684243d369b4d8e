// The last line of what a program has printed: where it says why it has failed.
#ifndef CLOTHID_TESTS_LAST_LINE_H_
#define CLOTHID_TESTS_LAST_LINE_H_

#include <string>

namespace clothid {

inline std::string LastLine(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text.substr(text.rfind('\n') + 1);
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_LAST_LINE_H_
