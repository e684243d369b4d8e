// Tables of text: what every reader of them shares.
//
// The first line that is not empty is the header, which names the columns in any order; letter case does not matter,
// and columns that nobody asks for are passed over. Then come the rows; those without anything in them are left out.
// Cells (csv_row.h; blanks within quotes are passed over) stand between commas, semicolons or tabs, whichever the
// header has. Where it has no commas, a number may have a decimal comma: all of them, or none. A row of units may
// follow the header, as s,m,m,m; its columns are converted to s, m and N. Empty cells at the end of a line do not
// count.
#ifndef CLOTHID_SIM_BASE_TABLE_H_
#define CLOTHID_SIM_BASE_TABLE_H_

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/csv_row.h"

namespace clothid {

enum class Quantity { kNumber, kTime, kLength, kForce };

struct Unit {
  Quantity quantity = Quantity::kNumber;
  double per_si = 1.0;  // 1000 of mm, for there are so many in the unit of the SI
};

// "mm", "s", "N", "metres", ..; nothing for a name that is none. The letter case counts in prefixes of N alone.
std::optional<Unit> FindUnit(std::string_view name);

enum class HeaderLine { kExpected, kOptional };

// Reads row by row. Every error is an `Error` (kBadData) that names file and line.
class Table {
 public:
  // `text` is what stands in the file `path`; `example` a header as expected, "time,x,y,z". Where the header is
  // optional, and the first line starts with a number, `example` is it.
  Table(const std::string& path, std::string text, std::string example, HeaderLine header = HeaderLine::kExpected);
  Table(const Table&) = delete;
  Table& operator=(const Table&) = delete;

  const std::vector<std::string>& header() const { return header_; }
  // The column of this name; throws where there are two.
  std::optional<std::size_t> Find(std::string_view name) const;
  std::size_t Require(std::string_view name) const;

  // Goes to the next row, which has as many cells as the header; false where there is none.
  bool NextRow();
  int line() const { return line_; }  // of the row, from 1 on
  const std::string& cell(std::size_t column) const { return cells_[column]; }

  // A finite number, in s, m or N.
  double Number(std::size_t column, Quantity quantity);
  // The same, or NaN for an empty cell and for nan.
  double NumberOrNothing(std::size_t column, Quantity quantity);
  // What the number in a cell is divided by where it is given in s, m or N.
  double UnitsPerSi(std::size_t column, Quantity quantity) const;
  // The digits of a cell, with a point for its decimal mark.
  std::string Digits(std::size_t column) const;
  // A time (s) after that of the row before.
  double LaterTime(std::size_t column);

  [[noreturn]] void Fail(const std::string& message) const;
  [[noreturn]] void FailOnHeader(const std::string& message) const;
  // "column 'x': expected EXPECTED, found 'CELL'".
  [[noreturn]] void FailAt(std::size_t column, const std::string& expected) const;
  // Of a table without rows.
  [[noreturn]] void FailWithoutRows() const;

  // What was made of a table that is not plain, "cells between ';', commas in numbers are decimal marks"; else empty.
  std::string note() const;

 private:
  std::optional<std::string_view> TakeFilledLine();
  void TakeUnits();
  void ExpectCellsOfHeader(std::string_view line);
  double InSi(double value, std::size_t column, Quantity quantity) const;
  [[noreturn]] void FailOnLine(int line, const std::string& message) const;
  [[noreturn]] void FailOnNumber(std::size_t column, const std::string& expected) const;

  const std::string path_, text_, example_;
  std::string_view rest_;
  int line_ = 0, header_line_ = 1, units_line_ = 0;
  char separator_ = ',';
  CellNumbers numbers_{','};
  std::vector<std::string> header_, units_, cells_;
  double last_time_ = 0.0;
  int last_time_line_ = 0;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_BASE_TABLE_H_
