#include "sim/base/table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/expect_error.h"

namespace clothid::table_test {
namespace {

constexpr ErrorKind kBadData = ErrorKind::kBadData;

struct Row {
  int line = 0;
  double time = 0.0, x = 0.0, force = 0.0;
};

std::vector<Row> Rows(const std::string& text) {
  Table table("f.csv", text, "time,x,f");
  const std::size_t time = table.Require("time"), x = table.Require("x"), force = table.Require("f");
  std::vector<Row> rows;
  while (table.NextRow()) {
    rows.push_back({table.line(), table.LaterTime(time), table.Number(x, Quantity::kLength),
                    table.NumberOrNothing(force, Quantity::kForce)});
  }
  if (rows.empty()) table.FailWithoutRows();
  return rows;
}

// The line 1 s, 2.5 m, 3 N, in another form.
void ExpectRow(const std::string& text, int line) {
  SCOPED_TRACE(text);
  const std::vector<Row> rows = Rows(text);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].line, line);
  EXPECT_EQ(rows[0].time, 1.0);
  EXPECT_EQ(rows[0].x, 2.5);
  EXPECT_EQ(rows[0].force, 3.0);
}

void ExpectRefused(const std::string& text, std::initializer_list<const char*> fragments) {
  SCOPED_TRACE(text);
  ExpectError([&] { Rows(text); }, kBadData, fragments);
}

TEST(TableTest, ReadsEveryForm) {
  ExpectRow("time,x,f\n1,2.5,3\n", 2);
  ExpectRow("f,TIME,note,X\r\n3,1,\"a, b\",2.5\r\n", 2);
  ExpectRow("\n\"time\", \"x\" ,f\n\n 1 ,\"2.5\",3", 4);
  ExpectRow("time,x,f,\n1,2.5,3,,\n,,,\n", 2);
  ExpectRow("time;x;f\n1;2,5;3\n", 2);
  ExpectRow("time\tx\tf\n1\t2.5\t3\n", 2);
  ExpectRow("time,x,f\ns,m,N\n1,2.5,3\n", 3);
  ExpectRow("time,x,f\n[ms],(mm),mN\n1000,2500,3000\n", 3);
  EXPECT_TRUE(std::isnan(Rows("time,x,f\n1,2,-NaN\n")[0].force));
}

TEST(TableTest, TellsWhatItMadeOfThem) {
  const auto note = [](const std::string& text) { return Table("f.csv", text, "time").note(); };
  EXPECT_EQ(note("time,x\n0,1\n"), "");
  EXPECT_EQ(note("time;x\n0;1\n"), "cells stand between ';', commas in numbers are taken for decimal marks");
  EXPECT_EQ(note("time,x\ns,mm\n"), "line 2 is taken for units: s, mm");
}

TEST(TableTest, NamesTheLineAndALikelyCause) {
  ExpectRefused("", {"f.csv: expected the header 'time,x,f' and at least one row"});
  ExpectRefused("time,x,f\n\n", {"f.csv: expected the header"});
  ExpectRefused("time,x\n", {"f.csv:1: column 'f': expected once in the header, as in 'time,x,f', found 'time,x'"});
  ExpectRefused("time,x,f,x\n", {"f.csv:1: column 'x': expected once"});
  ExpectRefused("time,x,f\n1,2\n", {"f.csv:2: expected 3 cells as in the header, found 2"});
  ExpectRefused("time,x,f\n1,2,3\n1,2,3\n", {"f.csv:3: column 'time': expected a time after 1 s of line 2, found '1'"});
  ExpectRefused("time,x,f\n1,nan,3\n", {"f.csv:2: column 'x': expected a finite number, found 'nan'"});
  ExpectRefused("time,x,f\n1,2,much\n", {"f.csv:2: column 'f': expected a finite number or nothing, found 'much'"});
  ExpectRefused("time,x,f\n1,\"2\"3,4\n", {"f.csv:2: expected quoted cells to end"});
  ExpectRefused("time,x,f\ns,N,N\n1,2,3\n", {"f.csv:2: unit of column 'x': expected m, cm or mm, found 'N'"});
  ExpectRefused("time x f\n1 2 3\n", {"f.csv:1: column 'time'", "one cell, 'time x f'; did an editor turn its tabs"});
  ExpectRefused("time\tx\tf\n1 2 3\n", {"f.csv:2: expected 3 cells", "found 1; did an editor turn its tabs"});
  ExpectRefused("time,x,f\n1;2;3\n", {"f.csv:2: expected 3 cells", "expected ',' between cells"});
  ExpectRefused("time,x,f\n0,1,2,5,3\n", {"f.csv:2: expected 3 cells", "found 5; are there decimal commas?"});
  ExpectRefused("time,x,f\n1,\"2,5\",3\n", {"f.csv:2: column 'x'", "'2,5'; a decimal comma needs ';'"});
  ExpectRefused("time;x;f\n0,5;1;2\n0.6;1;2\n", {"f.csv:3: column 'time'", "'0.6'; the numbers before it have ','"});
}

TEST(TableTest, NamesCommentsAndMarksOfThousands) {
  ExpectRefused("# made by hand\ntime,x,f\n",
                {"f.csv:1: column 'time'", "'# made by hand'; lines that begin with '#'"});
  ExpectRefused("# time,x,f\n1,2,3\n", {"f.csv:1: column 'time'", "'# time,x,f'; lines that begin with '#'"});
  ExpectRefused("time,x,f\n# and then\n", {"f.csv:2: expected 3 cells", "found 1; lines that begin with '#'"});
  ExpectRefused("time,x,f\n#1,2,3\n", {"f.csv:2: expected a finite number, found '#1'; lines that begin with '#'"});
  ExpectRefused("time,x,f\n1,\"1,000.5\",3\n", {"f.csv:2: column 'x'", "'1,000.5'; numbers have no marks between"});
  ExpectRefused("time;x;f\n1;1.000,5;3\n", {"f.csv:2: column 'x'", "'1.000,5'; numbers have no marks between"});
}

TEST(TableTest, AHeaderMayBeOptional) {
  Table numbers("t.txt", "0\n0.5\n", "time", HeaderLine::kOptional);
  EXPECT_EQ(numbers.Require("time"), 0U);
  ASSERT_TRUE(numbers.NextRow());
  EXPECT_EQ(numbers.line(), 1);
  EXPECT_EQ(numbers.cell(0), "0");
  Table named("t.txt", "frame,time\n7,0.5\n", "time", HeaderLine::kOptional);
  EXPECT_EQ(named.Require("time"), 1U);
}

TEST(FindUnitTest, KnowsPrefixes) {
  EXPECT_EQ(FindUnit("MM")->per_si, 1000.0);
  EXPECT_EQ(FindUnit("Millimetres")->quantity, Quantity::kLength);
  EXPECT_EQ(FindUnit("mN")->per_si, 1000.0);
  EXPECT_FALSE(FindUnit("MN").has_value());
  EXPECT_FALSE(FindUnit("").has_value());
}

}  // namespace
}  // namespace clothid::table_test
