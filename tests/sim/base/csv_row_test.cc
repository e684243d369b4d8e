#include "sim/base/csv_row.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace clothid::csv_row_test {
namespace {

using Cells = std::vector<std::string>;

TEST(CsvRowTest, CellsStandBetweenCommas) {
  EXPECT_EQ(CsvCells("a,b,c"), (Cells{"a", "b", "c"}));
  EXPECT_EQ(CsvCells(" a ,\tb c , 1"), (Cells{"a", "b c", "1"}));
  EXPECT_EQ(CsvCells("a,,"), (Cells{"a", "", ""}));
  EXPECT_EQ(CsvCells(""), (Cells{""}));
  EXPECT_EQ(CsvCells("5'2\""), (Cells{"5'2\""})) << "a quote within a cell is a character";
}

TEST(CsvRowTest, QuotedCellsMayHaveCommasBlanksAndQuotes) {
  EXPECT_EQ(CsvCells(R"("a","b")"), (Cells{"a", "b"}));
  EXPECT_EQ(CsvCells(R"( "a, b" , "" ,1)"), (Cells{"a, b", "", "1"}));
  EXPECT_EQ(CsvCells(R"("say ""a"", b"," c ")"), (Cells{R"(say "a", b)", " c "}));
  EXPECT_EQ(CsvCells(R"("a",)"), (Cells{"a", ""}));
}

TEST(CsvRowTest, CellsThatDoNotEndWithTheirQuoteAreNone) {
  for (const char* line : {"\"a", "1,\"a,b", "\"a\"b,c", "\"a\"\"", "\"", "\"a\" \"b\""}) {
    EXPECT_EQ(CsvCells(line), std::nullopt) << line;
  }
}

}  // namespace
}  // namespace clothid::csv_row_test
