// Reading small input files whole, and items and numbers out of text.
#ifndef CLOTHID_SIM_BASE_TEXT_FILE_H_
#define CLOTHID_SIM_BASE_TEXT_FILE_H_

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace clothid {

// The bytes of a file. Throws `Error`: kIo where it cannot be opened or read, kBadData where it is larger than
// `max_bytes`.
std::string ReadFile(const std::string& path, std::uint64_t max_bytes);

// The text of a file, without the mark that UTF-8 may begin with (U+FEFF, "byte order mark"): editors and spreadsheets
// write it. Throws `Error` as `ReadFile` does, and kBadData for UTF-16.
std::string ReadText(const std::string& path, std::uint64_t max_bytes);

// The same for the first bytes of a file, which `path` names in an error.
void StripByteOrderMark(const std::string& path, std::string* start);

// Takes the next line off the front of `rest`, without its end ("\n", "\r\n" or "\r"); nothing when `rest` is empty.
std::optional<std::string_view> TakeLine(std::string_view* rest);

// Takes the next word (a run without blanks and tabs) off the front of `rest`; empty when there is none.
std::string_view TakeWord(std::string_view* rest);

// `text` without the blanks and tabs at its ends.
std::string_view Trimmed(std::string_view text);

// The items of `text` between separators: one more than there are separators, empty ones included.
std::vector<std::string> Split(std::string_view text, char separator);

// The value of `text`, which must be one finite number from end to end; else nothing.
std::optional<double> ParseNumber(std::string_view text);
std::optional<long long> ParseInteger(std::string_view text);

// The shortest text of which `ParseNumber` makes exactly `value`; "nan", "inf" or "-inf" of one that is not finite.
std::string ShortestText(double value);

// `text` fit for a one-line message: control characters become '?', and what is long is cut.
std::string Printable(std::string_view text);

// `text`, whole, fit for a terminal: control characters, also those of two bytes in UTF-8 (U+0080 to U+009F), become
// "\x1b" and the like, a line end "\n", a backslash stays.
std::string Escaped(std::string_view text);

}  // namespace clothid

#endif  // CLOTHID_SIM_BASE_TEXT_FILE_H_
