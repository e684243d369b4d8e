#include "sim/path/handle_csv.h"

#include <optional>
#include <string_view>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

std::string Header(int num_handles) {
  std::string header = "time";
  for (int i = 0; i < num_handles; ++i) {
    for (const char axis : {'x', 'y', 'z'}) header.append({',', axis}).append(std::to_string(i));
  }
  return header;
}

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

HandlePath ReadHandleCsv(const std::string& path, int num_handles) {
  const std::string text = ReadText(path, kMaxHandleCsvBytes);
  const std::size_t columns = 1 + 3 * static_cast<std::size_t>(num_handles);
  std::string_view rest = text;
  std::vector<double> values;
  for (int line_number = 1; std::optional<std::string_view> line = TakeLine(&rest); ++line_number) {
    const std::string row = WithoutBlanks(*line);
    const auto fail = [&](const std::string& expected) {
      throw Error(ErrorKind::kBadData, path + ":" + std::to_string(line_number) + ": expected " + expected);
    };
    if (line_number == 1) {
      if (row != Header(num_handles)) fail("the header '" + Printable(Header(num_handles)) + "'");
    } else if (!row.empty() && !AppendRow(row, columns, &values)) {
      fail(std::to_string(columns) + " finite numbers");
    }
  }
  if (values.empty()) throw Error(ErrorKind::kBadData, path + ": expected a header and at least one row of numbers");
  const Eigen::Index num_times = static_cast<Eigen::Index>(values.size() / columns);
  const Eigen::Map<const Eigen::MatrixXd> table(values.data(), static_cast<Eigen::Index>(columns), num_times);
  try {
    return HandlePath(table.row(0).transpose(), table.bottomRows(static_cast<Eigen::Index>(columns) - 1));
  } catch (const Error& error) {
    throw Error(ErrorKind::kBadData, path + ": " + error.what());
  }
}

std::string HandleCsv(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions) {
  std::string text = Header(static_cast<int>(positions.rows() / 3)) + "\n";
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    text += ShortestText(times[i]);
    for (const double coordinate : positions.col(i)) text += "," + ShortestText(coordinate);
    text += "\n";
  }
  return text;
}

}  // namespace clothid
