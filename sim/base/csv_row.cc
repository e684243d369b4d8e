#include "sim/base/csv_row.h"

#include <algorithm>

#include "sim/base/text_file.h"

namespace clothid {
namespace {

// A tab between cells is no blank.
const char* Blanks(char separator) { return separator == '\t' ? " " : " \t"; }

void SkipBlanks(char separator, std::string_view* rest) {
  rest->remove_prefix(std::min(rest->find_first_not_of(Blanks(separator)), rest->size()));
}

// Takes a quoted cell, whose first character is the quote, and the blanks after it off the front of `rest`.
bool TakeQuoted(char separator, std::string_view* rest, std::string* cell) {
  rest->remove_prefix(1);
  while (!rest->empty()) {
    const char c = rest->front();
    rest->remove_prefix(1);
    if (c == '"') {
      if (rest->empty() || rest->front() != '"') {
        SkipBlanks(separator, rest);
        return rest->empty() || rest->front() == separator;
      }
      rest->remove_prefix(1);
    }
    *cell += c;
  }
  return false;
}

}  // namespace

char SeparatorOf(std::string_view line) {
  std::ptrdiff_t commas = 0, semicolons = 0;
  bool is_quoted = false, has_tabs = false;
  for (const char c : line) {
    if (c == '"') is_quoted = !is_quoted;
    if (is_quoted) continue;
    commas += c == ',' ? 1 : 0;
    semicolons += c == ';' ? 1 : 0;
    has_tabs = has_tabs || c == '\t';
  }
  if (semicolons > commas) return ';';
  return has_tabs && commas == 0 ? '\t' : ',';
}

bool SplitCells(std::string_view line, char separator, std::vector<std::string>* cells) {
  std::size_t count = 0;
  while (true) {
    if (++count > cells->size()) cells->emplace_back();
    std::string& cell = (*cells)[count - 1];
    SkipBlanks(separator, &line);
    if (!line.empty() && line.front() == '"') {
      cell.clear();
      if (!TakeQuoted(separator, &line, &cell)) return false;
    } else {
      const std::string_view text = line.substr(0, line.find(separator));
      line.remove_prefix(text.size());
      cell.assign(text.substr(0, text.find_last_not_of(Blanks(separator)) + 1));
    }
    if (line.empty()) break;
    line.remove_prefix(1);
  }
  cells->resize(count);
  return true;
}

bool IsNanWord(std::string_view text) {
  if (text.size() > 3 && (text.front() == '-' || text.front() == '+')) text.remove_prefix(1);
  return text.size() == 3 && (text[0] | 0x20) == 'n' && (text[1] | 0x20) == 'a' && (text[2] | 0x20) == 'n';
}

std::optional<double> CellNumbers::Parse(const std::string& cell) {
  const std::size_t place = separator_ == ',' ? std::string::npos : cell.find_first_of(".,");
  if (place == std::string::npos) return ParseNumber(cell);
  if (mark_ != 0 && cell[place] != mark_) return std::nullopt;
  std::string text = cell;
  text[place] = '.';
  const std::optional<double> value = ParseNumber(text);
  if (value) mark_ = cell[place];
  return value;
}

std::string CellNumbers::LikelyCause(const std::string& cell) const {
  const std::size_t place = cell.find_first_of(".,");
  if (place == std::string::npos || cell.find_first_not_of("0123456789.,eE+-") != std::string::npos) return "";
  if (cell.find(cell[place] == ',' ? '.' : ',', place) != std::string::npos) {
    return "; numbers have no marks between thousands";
  }
  if (separator_ == ',') return cell[place] == ',' ? "; a decimal comma needs ';' or tabs between cells" : "";
  if (mark_ == 0 || cell[place] == mark_) return "";
  return std::string("; the numbers before it have '") + mark_ + "' as their decimal mark";
}

}  // namespace clothid
