// The rows of CSV files (RFC 4180), as all tables are read.
#ifndef CLOTHID_SIM_BASE_CSV_ROW_H_
#define CLOTHID_SIM_BASE_CSV_ROW_H_

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace clothid {

// The cells of a line, without blanks and tabs around them. A cell may be quoted, "a, b", and then have commas, blanks
// and, doubled, quotes in it. Nothing where a quoted cell does not end, or goes on after its end. An empty line has one
// empty cell.
std::optional<std::vector<std::string>> CsvCells(std::string_view line);

// What else a message expects there.
inline constexpr char kExpectedQuotes[] = "expected quoted cells to end with a quote before the next comma";

}  // namespace clothid

#endif  // CLOTHID_SIM_BASE_CSV_ROW_H_
