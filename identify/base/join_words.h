// Lists in sentences.
#ifndef CLOTHID_IDENTIFY_BASE_JOIN_WORDS_H_
#define CLOTHID_IDENTIFY_BASE_JOIN_WORDS_H_

#include <cstddef>
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

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_BASE_JOIN_WORDS_H_
