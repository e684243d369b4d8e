// Pages whose blocks of code a test runs, and whether what was printed is what they say.
//
// A block is what stands between lines of ```. Its language says what to do with it:
//   sh       run by bash, ending at the first command that fails
//   python   run by python3
//   json, csv, cpp, cmake   written to the file that the last line of text before it names, as in `scene.json`:
//   text     lines that the block before it must have printed, in this order; "..." stands for any number of others
//   console  not run: it is about the reader's own folders
#ifndef CLOTHID_TESTS_PAGE_BLOCKS_H_
#define CLOTHID_TESTS_PAGE_BLOCKS_H_

#include <gtest/gtest.h>

#include <cmath>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace clothid {

struct Block {
  std::string language, content;
  std::string heading;  // the last line of text before it
  int line = 0;         // of its first ```, from 1
};

inline std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

inline std::vector<Block> ReadBlocks(const std::string& text) {
  const std::string fence = "```";
  std::vector<Block> blocks;
  std::string heading;
  bool is_inside = false;
  int number = 0;
  for (const std::string& line : Lines(text)) {
    ++number;
    if (line.rfind(fence, 0) == 0) {
      if (!is_inside) blocks.push_back({line.substr(fence.size()), "", heading, number});
      is_inside = !is_inside;
    } else if (is_inside) {
      blocks.back().content += line + "\n";
    } else if (!line.empty()) {
      heading = line;
    }
  }
  EXPECT_FALSE(is_inside) << "the last block has no end";
  return blocks;
}

// Whether two words are the same but for a number in them, which may differ by 5 %: processors round differently, and
// a fit stops somewhere within its tolerance. Integers have to be the same, unless `are_counts_free`.
inline bool WordsAgree(const std::string& expected, const std::string& printed, bool are_counts_free) {
  if (expected == printed) return true;
  static const std::regex pattern(R"(([^0-9+-]*)([+-]?[0-9]+)(\.[0-9]+)?([eE][+-]?[0-9]+)?([^0-9]*))");
  std::smatch a, b;
  if (!std::regex_match(expected, a, pattern) || !std::regex_match(printed, b, pattern)) return false;
  if (a[1] != b[1] || a[5] != b[5]) return false;
  const auto is_integer = [](const std::smatch& match) { return match[3].length() + match[4].length() == 0; };
  if (is_integer(a) && is_integer(b)) return are_counts_free;
  const auto value = [](const std::smatch& match) {
    return std::stod(match[2].str() + match[3].str() + match[4].str());
  };
  return std::abs(value(a) - value(b)) <= 0.05 * std::abs(value(a));
}

inline bool LinesAgree(const std::string& expected, const std::string& printed) {
  // How many iterations a fit takes is not what the page is about.
  const bool are_counts_free = expected.rfind("status ", 0) == 0;
  std::istringstream a(expected), b(printed);
  std::string word, other;
  while (a >> word) {
    if (!(b >> other) || !WordsAgree(word, other, are_counts_free)) return false;
  }
  return !(b >> other);
}

// Empty where `printed` has the lines of `expected`, else the first line that is missing.
inline std::string FirstMissingLine(const std::string& expected, const std::string& printed) {
  const std::vector<std::string> lines = Lines(printed);
  std::size_t next = 0;
  bool may_skip = false;
  for (const std::string& line : Lines(expected)) {
    if (line == "...") {
      may_skip = true;
      continue;
    }
    while (may_skip && next < lines.size() && !LinesAgree(line, lines[next])) ++next;
    if (next == lines.size() || !LinesAgree(line, lines[next])) return line;
    ++next;
    may_skip = false;
  }
  return "";
}

// The name at the end of the line before: "..`scene.json`:"; empty where there is none.
inline std::string FileName(const Block& block) {
  std::smatch match;
  return std::regex_search(block.heading, match, std::regex("`([A-Za-z_.]+)`:$")) ? match[1].str() : "";
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_PAGE_BLOCKS_H_
