// The tutorial, as a newcomer runs it: every block of identify/tutorial.md, in order, in one empty folder.
//
// A block is what stands between lines of ```. Its language says what to do with it:
//   sh       run by bash, ending at the first command that fails
//   python   run by python3
//   json     written to the file that the last line of text before it names, as in `scene.json`:
//   text     lines that the block before it must have printed, in this order; "..." stands for any number of others
//   console  not run: it is about the reader's own folders
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "tests/last_line.h"
#include "tests/tools/tool_test.h"

namespace clothid {
namespace {

constexpr char kTutorial[] = CLOTHID_SOURCE_DIR "/identify/tutorial.md";

struct Block {
  std::string language, content;
  std::string heading;  // the last line of text before it
  int line = 0;         // of its first ```, from 1
};

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::vector<Block> ReadBlocks(const std::string& text) {
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
bool WordsAgree(const std::string& expected, const std::string& printed, bool are_counts_free) {
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

bool LinesAgree(const std::string& expected, const std::string& printed) {
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
std::string FirstMissingLine(const std::string& expected, const std::string& printed) {
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

// The name in "`scene.json`:".
std::string FileName(const Block& block) {
  std::smatch match;
  EXPECT_TRUE(std::regex_match(block.heading, match, std::regex("`([a-z_.]+)`:")))
      << kTutorial << ":" << block.line << ": expected the name of the file on the line before";
  return match.empty() ? "unnamed" : match[1].str();
}

class TutorialTest : public ToolTest {
 protected:
  // Sets `python` to a python3 that has NumPy: the one on the path, or Debian's. Else it says what is missing.
  std::string FindPython(std::string* python) const {
    std::string error;
    for (const std::string name : {"python3", "/usr/bin/python3"}) {
      const ToolResult result = Run(name + " -c 'import numpy'");
      *python = name;
      if (result.exit_code == 0) return "";
      if (result.exit_code != 127) error = LastLine(result.err);
    }
    if (error.empty()) return "the package python3 is absent";
    const bool is_absent = error.find("No module named 'numpy'") != std::string::npos;
    return "the package python3-numpy is " + (is_absent ? "absent" : "damaged: " + error);
  }
};

TEST_F(TutorialTest, RunsAsItStands) {
  std::string python;
  const std::string missing = FindPython(&python);
  if (!missing.empty()) GTEST_SKIP() << missing;
  const std::vector<Block> blocks = ReadBlocks(ReadBytes(kTutorial));
  ToolResult last;
  int num_run = 0, num_compared = 0;
  for (const Block& block : blocks) {
    SCOPED_TRACE(std::string(kTutorial) + ":" + std::to_string(block.line));
    if (block.language == "json") {
      WriteBytes(folder() / FileName(block), block.content);
    } else if (block.language == "sh" || block.language == "python") {
      WriteBytes(folder() / "block", block.content);
      last = Run(block.language == "sh" ? "bash -eu block" : python + " block");
      ASSERT_EQ(last.exit_code, 0) << last.err;
      ++num_run;
    } else if (block.language == "text") {
      EXPECT_EQ(FirstMissingLine(block.content, last.out), "") << "printed:\n" << last.out << last.err;
      ++num_compared;
    } else {
      EXPECT_EQ(block.language, "console");
    }
  }
  EXPECT_GE(num_run, 10);
  EXPECT_GE(num_compared, 7);
  EXPECT_TRUE(std::filesystem::exists(folder() / "result" / "report.html"));
}

TEST(TutorialBlocksTest, NumbersMayDifferALittleAndWordsMayNot) {
  EXPECT_TRUE(LinesAgree("mu  0.297 (4.38 %), 1 of 2", "mu 0.2971   (4.39 %), 1 of 2"));
  EXPECT_FALSE(LinesAgree("mu 0.297", "mu 0.33"));
  EXPECT_FALSE(LinesAgree("mu 0.297", "k_stretch 0.297"));
  EXPECT_FALSE(LinesAgree("frames 41", "frames 42"));
  EXPECT_FALSE(LinesAgree("a b", "a"));
  EXPECT_FALSE(LinesAgree("a", "a b"));
  EXPECT_TRUE(LinesAgree("status converged after 5 iterations", "status converged after 6 iterations"));
  EXPECT_FALSE(LinesAgree("status converged after 5 iterations", "status not_converged after 5 iterations"));
}

TEST(TutorialBlocksTest, DotsStandForOtherLines) {
  const std::string printed = "a\nb\nc\n";
  EXPECT_EQ(FirstMissingLine("a\nb\n", printed), "");
  EXPECT_EQ(FirstMissingLine("...\nc\n", printed), "");
  EXPECT_EQ(FirstMissingLine("b\n", printed), "b");
  EXPECT_EQ(FirstMissingLine("a\n...\nd\n", printed), "d");
  EXPECT_EQ(FirstMissingLine("a\nc\n", printed), "c");
}

}  // namespace
}  // namespace clothid
