#include "sim/path/number_table.h"

#include <algorithm>
#include <optional>
#include <string_view>
#include <vector>

#include "sim/base/csv_row.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

// "a,b" of the cells of a header.
std::string Joined(const std::vector<std::string>& cells) {
  std::string text;
  for (const std::string& cell : cells) text += (text.empty() ? "" : ",") + cell;
  return text;
}

// Appends the numbers of `cells`; false unless there are `count` of them.
bool AppendRow(const std::vector<std::string>& cells, std::size_t count, std::vector<double>* values) {
  if (cells.size() != count) return false;
  for (const std::string& cell : cells) {
    const std::optional<double> value = ParseNumber(Trimmed(cell));
    if (!value) return false;
    values->push_back(*value);
  }
  return true;
}

}  // namespace

Eigen::MatrixXd ReadNumberTable(const std::string& path, const std::string& header, std::uint64_t max_bytes) {
  const std::string text = ReadText(path, max_bytes);
  const std::size_t columns = 1 + static_cast<std::size_t>(std::count(header.begin(), header.end(), ','));
  std::string_view rest = text;
  std::vector<double> values;
  for (int line_number = 1; std::optional<std::string_view> line = TakeLine(&rest); ++line_number) {
    const auto fail = [&](const std::string& expected) {
      throw Error(ErrorKind::kBadData, path + ":" + std::to_string(line_number) + ": " + expected);
    };
    const std::optional<std::vector<std::string>> cells = CsvCells(*line);
    if (!cells) fail(kExpectedQuotes);
    if (line_number == 1) {
      if (Joined(*cells) != header) fail("expected the header '" + Printable(header) + "'");
    } else if (!Trimmed(*line).empty() && !AppendRow(*cells, columns, &values)) {
      fail("expected " + std::to_string(columns) + " finite numbers");
    }
  }
  if (values.empty()) throw Error(ErrorKind::kBadData, path + ": expected a header and at least one row of numbers");
  return Eigen::Map<const Eigen::MatrixXd>(values.data(), static_cast<Eigen::Index>(columns),
                                           static_cast<Eigen::Index>(values.size() / columns));
}

std::string NumberTable(const std::string& header, const Eigen::MatrixXd& columns) {
  std::string text = header + "\n";
  for (Eigen::Index i = 0; i < columns.cols(); ++i) {
    for (Eigen::Index k = 0; k < columns.rows(); ++k) {
      if (k > 0) text += ",";
      text += ShortestText(columns(k, i));
    }
    text += "\n";
  }
  return text;
}

}  // namespace clothid
