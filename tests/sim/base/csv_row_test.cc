#include "sim/base/csv_row.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

namespace clothid::csv_row_test {
namespace {

using Cells = std::vector<std::string>;

std::optional<Cells> CellsOf(const std::string& line, char separator = ',') {
  Cells cells = {"of", "the", "row", "before"};
  return SplitCells(line, separator, &cells) ? std::optional(cells) : std::nullopt;
}

TEST(CsvRowTest, CellsStandBetweenCommas) {
  EXPECT_EQ(CellsOf("a,b,c"), (Cells{"a", "b", "c"}));
  EXPECT_EQ(CellsOf(" a ,\tb c , 1"), (Cells{"a", "b c", "1"}));
  EXPECT_EQ(CellsOf("a,,"), (Cells{"a", "", ""}));
  EXPECT_EQ(CellsOf(""), (Cells{""}));
  EXPECT_EQ(CellsOf("5'2\""), (Cells{"5'2\""})) << "a quote within a cell is a character";
}

TEST(CsvRowTest, OrBetweenSemicolonsOrTabs) {
  EXPECT_EQ(CellsOf("a; 1,5 ;\t\"b;c\"", ';'), (Cells{"a", "1,5", "b;c"}));
  EXPECT_EQ(CellsOf("\ta \t\t\"b\tc\" \t", '\t'), (Cells{"", "a", "", "b\tc", ""}));
}

TEST(CsvRowTest, TheHeaderTellsTheSeparator) {
  EXPECT_EQ(SeparatorOf("t,id,x"), ',');
  EXPECT_EQ(SeparatorOf("t;id;x"), ';');
  EXPECT_EQ(SeparatorOf("t\tid\tx"), '\t');
  EXPECT_EQ(SeparatorOf("t,\t\tid,\t\tx"), ',') << "tabs that line up columns";
  EXPECT_EQ(SeparatorOf("\"a;b\",\"c;d\",e"), ',') << "what is quoted does not count";
  EXPECT_EQ(SeparatorOf("time"), ',');
}

TEST(CsvRowTest, QuotedCellsMayHaveCommasBlanksAndQuotes) {
  EXPECT_EQ(CellsOf(R"("a","b")"), (Cells{"a", "b"}));
  EXPECT_EQ(CellsOf(R"( "a, b" , "" ,1)"), (Cells{"a, b", "", "1"}));
  EXPECT_EQ(CellsOf(R"("say ""a"", b"," c ")"), (Cells{R"(say "a", b)", " c "}));
  EXPECT_EQ(CellsOf(R"("a",)"), (Cells{"a", ""}));
}

TEST(CsvRowTest, CellsThatDoNotEndWithTheirQuoteAreNone) {
  for (const char* line : {"\"a", "1,\"a,b", "\"a\"b,c", "\"a\"\"", "\"", "\"a\" \"b\""}) {
    EXPECT_EQ(CellsOf(line), std::nullopt) << line;
  }
}

TEST(CellNumbersTest, HaveOneDecimalMark) {
  CellNumbers numbers(';');
  EXPECT_EQ(numbers.Parse("3"), 3.0);
  EXPECT_EQ(numbers.Parse("-1,5e2"), -150.0);
  EXPECT_EQ(numbers.Parse("0.5"), std::nullopt);
  EXPECT_EQ(numbers.LikelyCause("0.5"), "; the numbers before it have ',' as their decimal mark");
  EXPECT_EQ(numbers.Parse("1,234,5"), std::nullopt);
  CellNumbers points('\t');
  EXPECT_EQ(points.Parse("0.5"), 0.5);
  EXPECT_EQ(points.Parse("1,5"), std::nullopt);
  EXPECT_EQ(CellNumbers(';').Parse("1.234,5"), std::nullopt) << "a point between thousands";
  EXPECT_EQ(CellNumbers(',').Parse("1,5"), std::nullopt);
  EXPECT_NE(CellNumbers(',').LikelyCause("1,5"), "");
  EXPECT_EQ(CellNumbers(',').LikelyCause("left, 5"), "");
}

}  // namespace
}  // namespace clothid::csv_row_test
