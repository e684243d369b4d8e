// Text as files and terminals want it.
#include "sim/base/text_file.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::text_file_test {
namespace {

TEST(ReadText, LeavesTheByteOrderMarkOut) {
  const TemporaryFolder folder;
  EXPECT_EQ(ReadText(folder.Write("marked.txt", "\xef\xbb\xbfv 1"), 100), "v 1");
  EXPECT_EQ(ReadText(folder.Write("plain.txt", "v \xef\xbb\xbf"), 100), "v \xef\xbb\xbf");
  EXPECT_EQ(ReadText(folder.Write("empty.txt", ""), 100), "");
  EXPECT_EQ(ReadFile(folder.File("marked.txt"), 100).size(), 6u);
}

TEST(ReadText, NamesTheOtherEncoding) {
  const TemporaryFolder folder;
  for (const std::string mark : {"\xff\xfe", "\xfe\xff"}) {
    const std::string path = folder.Write("wide.txt", mark + std::string("v\0", 2));
    ExpectError([&] { ReadText(path, 100); }, ErrorKind::kBadData, {"wide.txt: is text in UTF-16; expected UTF-8"});
  }
}

TEST(TakeLine, KnowsEveryEnd) {
  for (const char* text : {"a\nb c\n\nd", "a\r\nb c\r\n\r\nd\r\n", "a\rb c\r\rd\r", "a\rb c\n\r\nd\n"}) {
    std::string_view rest = text;
    for (const char* line : {"a", "b c", "", "d"}) EXPECT_EQ(TakeLine(&rest), line) << Escaped(text);
    EXPECT_FALSE(TakeLine(&rest)) << Escaped(text);
  }
}

TEST(Escaped, LeavesNothingThatATerminalActsOn) {
  EXPECT_EQ(Escaped("\x1b]0;title\x07\x1b[31mred"), "\\x1b]0;title\\x07\\x1b[31mred");
  EXPECT_EQ(Escaped("a\nb\r\t\x7f"), "a\\nb\\x0d\\x09\\x7f");
  EXPECT_EQ(Escaped("\xc2\x9b"
                    "31m"),
            "\\x9b31m");
  EXPECT_EQ(Escaped("Z\xc3\xbcrich, \xc2\xb5 \\"), "Z\xc3\xbcrich, \xc2\xb5 \\");
  EXPECT_EQ(Escaped("\xc2"), "\xc2");
  EXPECT_EQ(Escaped(std::string(500, 'x')).size(), 500u);
}

}  // namespace
}  // namespace clothid::text_file_test
