// The tutorials, as a newcomer runs them: every block of a page, in order, in one empty folder.
// See tests/page_blocks.h for what is done with a block.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "tests/last_line.h"
#include "tests/page_blocks.h"
#include "tests/tools/tool_test.h"

namespace clothid::tutorial_test {
namespace {

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

  // Runs the blocks of a page of identify/, at least `least_run` of them, and compares what at least `least_compared`
  // say that they print.
  void RunPage(const std::string& name, int least_run, int least_compared) const {
    std::string python;
    const std::string missing = FindPython(&python);
    if (!missing.empty()) GTEST_SKIP() << missing;
    const std::string page = CLOTHID_SOURCE_DIR "/identify/" + name;
    ToolResult last;
    int num_run = 0, num_compared = 0;
    for (const Block& block : ReadBlocks(ReadBytes(page))) {
      SCOPED_TRACE(page + ":" + std::to_string(block.line));
      if (block.language == "json" || block.language == "csv") {
        ASSERT_NE(FileName(block), "") << "expected the name of the file on the line before";
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
    EXPECT_GE(num_run, least_run);
    EXPECT_GE(num_compared, least_compared);
    EXPECT_TRUE(std::filesystem::exists(folder() / "result" / "report.html"));
  }
};

TEST_F(TutorialTest, RunsAsItStands) { RunPage("tutorial.md", 10, 7); }

TEST_F(TutorialTest, OfAFabricRunsAsItStands) { RunPage("fabric_tutorial.md", 9, 9); }

TEST_F(TutorialTest, OfPredictionsRunsAsItStands) { RunPage("prediction_tutorial.md", 5, 4); }

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
}  // namespace clothid::tutorial_test
