#include "sim/base/table.h"

#include <algorithm>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

std::string InSmallLetters(std::string_view text) {
  std::string small(text);
  for (char& c : small) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c | 0x20) : c;
  return small;
}

std::string CountOfCells(std::size_t count) { return std::to_string(count) + (count == 1 ? " cell" : " cells"); }

// Why a line with this cell first has another number of cells than it should, or other names.
std::string CauseOf(const std::vector<std::string>& cells) {
  if (cells[0].substr(0, 1) == "#") return kNoComments;
  return cells.size() == 1 && cells[0].find(' ') != std::string::npos ? kTornTabs : "";
}

std::string NameOf(char separator) { return separator == '\t' ? "tabs" : std::string("'") + separator + "'"; }

void DropEmptyEnd(std::size_t least, std::vector<std::string>* cells) {
  while (cells->size() > least && cells->back().empty()) cells->pop_back();
}

// In the rows of tables that hold numbers and their names, blanks within quotes mean nothing: " 1" is 1.
bool SplitTrimmed(std::string_view line, char separator, std::vector<std::string>* cells) {
  if (!SplitCells(line, separator, cells)) return false;
  for (std::string& cell : *cells) {
    if (const std::string_view trimmed = Trimmed(cell); trimmed.size() < cell.size()) cell = std::string(trimmed);
  }
  return true;
}

// "[mm]" and "(mm)" are mm, "-" is no unit.
std::string_view WithoutBrackets(std::string_view unit) {
  if (unit == "-") return {};
  const bool has_brackets =
      unit.size() >= 2 && ((unit.front() == '[' && unit.back() == ']') || (unit.front() == '(' && unit.back() == ')'));
  return has_brackets ? Trimmed(unit.substr(1, unit.size() - 2)) : unit;
}

const char* UnitsOf(Quantity quantity) {
  switch (quantity) {
    case Quantity::kTime:
      return "s, ms, us or ns";
    case Quantity::kLength:
      return "m, cm or mm";
    case Quantity::kForce:
      return "N, mN or kN";
    case Quantity::kNumber:
      break;
  }
  return "no unit";
}

}  // namespace

std::optional<Unit> FindUnit(std::string_view name) {
  constexpr auto kTime = Quantity::kTime, kLength = Quantity::kLength, kForce = Quantity::kForce;
  static const std::map<std::string, Unit, std::less<>> units = {{"s", {kTime, 1.0}},
                                                                 {"sec", {kTime, 1.0}},
                                                                 {"seconds", {kTime, 1.0}},
                                                                 {"ms", {kTime, 1e3}},
                                                                 {"us", {kTime, 1e6}},
                                                                 {"ns", {kTime, 1e9}},
                                                                 {"m", {kLength, 1.0}},
                                                                 {"meters", {kLength, 1.0}},
                                                                 {"metres", {kLength, 1.0}},
                                                                 {"cm", {kLength, 1e2}},
                                                                 {"centimeters", {kLength, 1e2}},
                                                                 {"centimetres", {kLength, 1e2}},
                                                                 {"mm", {kLength, 1e3}},
                                                                 {"millimeters", {kLength, 1e3}},
                                                                 {"millimetres", {kLength, 1e3}},
                                                                 {"N", {kForce, 1.0}},
                                                                 {"newton", {kForce, 1.0}},
                                                                 {"mN", {kForce, 1e3}},
                                                                 {"kN", {kForce, 1e-3}}};
  auto found = units.find(name);
  if (found == units.end()) found = units.find(InSmallLetters(name));
  return found == units.end() ? std::nullopt : std::optional<Unit>(found->second);
}

Table::Table(const std::string& path, std::string text, std::string example, HeaderLine header)
    : path_(path), text_(std::move(text)), example_(std::move(example)), rest_(text_) {
  const std::optional<std::string_view> line = TakeFilledLine();
  if (!line) FailWithoutRows();
  header_line_ = line_;
  separator_ = SeparatorOf(*line);
  numbers_ = CellNumbers(separator_);
  if (!SplitTrimmed(*line, separator_, &header_)) Fail(kExpectedQuotes);
  if (header == HeaderLine::kOptional && CellNumbers(separator_).Parse(header_[0])) {
    header_ = Split(example_, ',');
    rest_ = text_;
    line_ = 0;
    return;
  }
  DropEmptyEnd(1, &header_);
  TakeUnits();
}

std::optional<std::size_t> Table::Find(std::string_view name) const {
  const auto count_and_place = [&](const auto& is_name) {
    return std::pair(std::count_if(header_.begin(), header_.end(), is_name),
                     std::find_if(header_.begin(), header_.end(), is_name) - header_.begin());
  };
  auto [count, place] = count_and_place([&](const std::string& cell) { return cell == name; });
  if (count == 0) {
    const std::string small = InSmallLetters(name);
    std::tie(count, place) = count_and_place([&](const std::string& cell) { return InSmallLetters(cell) == small; });
  }
  if (count > 1) FailOnHeader("column '" + std::string(name) + "': expected once in the header");
  return count == 0 ? std::nullopt : std::optional(static_cast<std::size_t>(place));
}

std::size_t Table::Require(std::string_view name) const {
  const std::optional<std::size_t> found = Find(name);
  if (!found) FailOnHeader("column '" + std::string(name) + "': expected once in the header");
  return *found;
}

bool Table::NextRow() {
  while (const std::optional<std::string_view> line = TakeFilledLine()) {
    if (!SplitTrimmed(*line, separator_, &cells_)) Fail(kExpectedQuotes);
    if (std::all_of(cells_.begin(), cells_.end(), [](const std::string& cell) { return cell.empty(); })) continue;
    ExpectCellsOfHeader(*line);
    return true;
  }
  return false;
}

double Table::Number(std::size_t column, Quantity quantity) {
  const std::optional<double> value = numbers_.Parse(cells_[column]);
  if (!value) FailOnNumber(column, "a finite number");
  return InSi(*value, column, quantity);
}

double Table::NumberOrNothing(std::size_t column, Quantity quantity) {
  const std::string& cell = cells_[column];
  if (cell.empty() || IsNanWord(cell)) return std::numeric_limits<double>::quiet_NaN();
  const std::optional<double> value = numbers_.Parse(cell);
  if (!value) FailOnNumber(column, "a finite number or nothing");
  return InSi(*value, column, quantity);
}

std::string Table::Digits(std::size_t column) const {
  std::string digits = cells_[column];
  if (separator_ != ',') std::replace(digits.begin(), digits.end(), ',', '.');
  return digits;
}

double Table::LaterTime(std::size_t column) {
  const double time = Number(column, Quantity::kTime);
  if (last_time_line_ > 0 && !(time > last_time_)) {
    FailAt(column, "a time after " + ShortestText(last_time_) + " s of line " + std::to_string(last_time_line_));
  }
  last_time_ = time;
  last_time_line_ = line_;
  return time;
}

void Table::Fail(const std::string& message) const { FailOnLine(line_, message); }

void Table::FailOnHeader(const std::string& message) const {
  std::string found;
  for (const std::string& cell : header_) found += (found.empty() ? "" : ",") + cell;
  FailOnLine(header_line_, message + ", as in '" + Printable(example_) + "', found " +
                               (header_.size() == 1 ? "one cell, '" : "'") + Printable(found) + "'" + CauseOf(header_));
}

void Table::FailAt(std::size_t column, const std::string& expected) const {
  Fail("column '" + Printable(header_[column]) + "': expected " + expected + ", found '" + Printable(cells_[column]) +
       "'");
}

void Table::FailWithoutRows() const {
  throw Error(ErrorKind::kBadData, path_ + ": expected the header '" + Printable(example_) + "' and at least one row");
}

std::string Table::note() const {
  std::string note;
  if (separator_ != ',') {
    note = "cells stand between " + NameOf(separator_) + ", commas in numbers are taken for decimal marks";
  }
  if (units_line_ == 0) return note;
  note += (note.empty() ? "line " : "; line ") + std::to_string(units_line_) + " is taken for units: ";
  for (std::size_t i = 0; i < units_.size(); ++i) note += (i > 0 ? ", " : "") + Printable(units_[i]);
  return note;
}

std::optional<std::string_view> Table::TakeFilledLine() {
  while (const std::optional<std::string_view> line = TakeLine(&rest_)) {
    ++line_;
    if (!Trimmed(*line).empty()) return line;
  }
  return std::nullopt;
}

// Below the header: no number, and a unit at least.
void Table::TakeUnits() {
  const std::string_view rest = rest_;
  const int header_line = line_;
  const std::optional<std::string_view> line = TakeFilledLine();
  if (line && SplitTrimmed(*line, separator_, &units_)) {
    const bool has_numbers = std::any_of(units_.begin(), units_.end(), [&](const std::string& cell) {
      return CellNumbers(separator_).Parse(cell).has_value();
    });
    for (std::string& unit : units_) unit = WithoutBrackets(std::string(unit));
    const bool has_units =
        std::any_of(units_.begin(), units_.end(), [](const std::string& unit) { return FindUnit(unit).has_value(); });
    if (has_units && !has_numbers) {
      units_line_ = line_;
      units_.resize(header_.size());
      return;
    }
  }
  units_.clear();
  rest_ = rest;
  line_ = header_line;
}

void Table::ExpectCellsOfHeader(std::string_view line) {
  DropEmptyEnd(header_.size(), &cells_);
  if (cells_.size() == header_.size()) return;
  std::string cause = CauseOf(cells_);
  if (cause.empty() && cells_.size() == 1 && cells_[0].find(SeparatorOf(cells_[0])) != std::string::npos) {
    cause = "; expected " + NameOf(separator_) + " between cells, as in the header";
  } else if (cause.empty() && separator_ == ',' && cells_.size() > header_.size() &&
             line.find('.') == std::string_view::npos) {
    cause = "; are there decimal commas? They need ';' or tabs between cells";
  }
  Fail("expected " + CountOfCells(header_.size()) + " as in the header, found " + std::to_string(cells_.size()) +
       cause);
}

double Table::UnitsPerSi(std::size_t column, Quantity quantity) const {
  if (units_line_ == 0 || units_[column].empty()) return 1.0;
  const std::optional<Unit> unit = FindUnit(units_[column]);
  if (unit && unit->quantity == quantity) return unit->per_si;
  FailOnLine(units_line_, "unit of column '" + Printable(header_[column]) + "': expected " + UnitsOf(quantity) +
                              ", found '" + Printable(units_[column]) + "'");
}

double Table::InSi(double value, std::size_t column, Quantity quantity) const {
  return value / UnitsPerSi(column, quantity);
}

void Table::FailOnLine(int line, const std::string& message) const {
  throw Error(ErrorKind::kBadData, path_ + ":" + std::to_string(line) + ": " + message);
}

void Table::FailOnNumber(std::size_t column, const std::string& expected) const {
  const std::string& cell = cells_[column];
  if (cell.substr(0, 1) == "#" && column == 0) {
    Fail("expected " + expected + ", found '" + Printable(cell) + "'" + kNoComments);
  }
  Fail("column '" + Printable(header_[column]) + "': expected " + expected + ", found '" + Printable(cell) + "'" +
       numbers_.LikelyCause(cell));
}

}  // namespace clothid
