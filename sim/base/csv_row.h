// The rows of tables (RFC 4180), as all of them are read.
#ifndef CLOTHID_SIM_BASE_CSV_ROW_H_
#define CLOTHID_SIM_BASE_CSV_ROW_H_

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace clothid {

// What is between the cells of a line: ',', or ';' where more of these stand outside of quotes, or a tab where neither
// does.
char SeparatorOf(std::string_view line);

// The cells of a line between `separator`, without blanks and other tabs around them. A cell may be quoted, "a, b", and
// then have separators, blanks and, doubled, quotes in it. An empty line has one empty cell. False where a quoted cell
// does not end, or goes on after its end.
bool SplitCells(std::string_view line, char separator, std::vector<std::string>* cells);

// What else a message expects there.
inline constexpr char kExpectedQuotes[] = "expected quoted cells to end with a quote before the next cell";
// And a likely cause of one cell where several were expected.
inline constexpr char kNoComments[] = "; lines that begin with '#' are no comments here: leave them out";
inline constexpr char kTornTabs[] = "; did an editor turn its tabs into blanks?";

// Whether `text` is "nan", in any letter case and with any sign.
bool IsNanWord(std::string_view text);

// The numbers of a table. Between semicolons or tabs they may have a decimal comma: all of them, or none.
class CellNumbers {
 public:
  explicit CellNumbers(char separator) : separator_(separator) {}

  // A finite number; nothing for other text, and for a number with another decimal mark than that of one before it.
  std::optional<double> Parse(const std::string& cell);
  // What `Parse` seems to have made nothing of `cell` for, "; ..", for the end of a message; empty where that is plain.
  std::string LikelyCause(const std::string& cell) const;

 private:
  char separator_;
  char mark_ = 0;  // none while no number has one
};

}  // namespace clothid

#endif  // CLOTHID_SIM_BASE_CSV_ROW_H_
