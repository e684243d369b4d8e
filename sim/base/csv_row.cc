#include "sim/base/csv_row.h"

#include <algorithm>
#include <utility>

#include "sim/base/text_file.h"

namespace clothid {
namespace {

void SkipBlanks(std::string_view* rest) { rest->remove_prefix(std::min(rest->find_first_not_of(" \t"), rest->size())); }

// Takes a quoted cell, whose first character is the quote, and the blanks after it off the front of `rest`.
std::optional<std::string> TakeQuoted(std::string_view* rest) {
  std::string cell;
  rest->remove_prefix(1);
  while (!rest->empty()) {
    const char c = rest->front();
    rest->remove_prefix(1);
    if (c == '"') {
      if (rest->empty() || rest->front() != '"') {
        SkipBlanks(rest);
        return rest->empty() || rest->front() == ',' ? std::optional(std::move(cell)) : std::nullopt;
      }
      rest->remove_prefix(1);
    }
    cell += c;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::vector<std::string>> CsvCells(std::string_view line) {
  std::vector<std::string> cells;
  while (true) {
    SkipBlanks(&line);
    if (!line.empty() && line.front() == '"') {
      std::optional<std::string> cell = TakeQuoted(&line);
      if (!cell) return std::nullopt;
      cells.push_back(std::move(*cell));
    } else {
      const std::string_view text = line.substr(0, line.find(','));
      line.remove_prefix(text.size());
      cells.emplace_back(Trimmed(text));
    }
    if (line.empty()) return cells;
    line.remove_prefix(1);
  }
}

}  // namespace clothid
