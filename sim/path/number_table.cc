#include "sim/path/number_table.h"

#include <algorithm>
#include <optional>
#include <string_view>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

std::string WithoutBlanks(std::string_view line) {
  std::string result;
  for (const char c : line) {
    if (c != ' ' && c != '\t') result.push_back(c);
  }
  return result;
}

// Appends the numbers of `line`; false unless there are `count` of them.
bool AppendRow(std::string_view line, std::size_t count, std::vector<double>* values) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t comma = line.find(',');
    const std::optional<double> value = ParseNumber(line.substr(0, comma));
    const bool last = i + 1 == count;
    if (!value || last != (comma == std::string_view::npos)) return false;
    values->push_back(*value);
    if (!last) line.remove_prefix(comma + 1);
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
    const std::string row = WithoutBlanks(*line);
    const auto fail = [&](const std::string& expected) {
      throw Error(ErrorKind::kBadData, path + ":" + std::to_string(line_number) + ": expected " + expected);
    };
    if (line_number == 1) {
      if (row != header) fail("the header '" + Printable(header) + "'");
    } else if (!row.empty() && !AppendRow(row, columns, &values)) {
      fail(std::to_string(columns) + " finite numbers");
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
