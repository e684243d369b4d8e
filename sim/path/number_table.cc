#include "sim/path/number_table.h"

#include <algorithm>

#include "sim/base/table.h"
#include "sim/base/text_file.h"
#include "sim/mesh/mesh.h"

namespace clothid {
namespace {

Quantity QuantityOf(const std::string& name) {
  return std::string_view("xyz").find(name.front()) == std::string_view::npos ? Quantity::kNumber : Quantity::kLength;
}

}  // namespace

NumberTableRows ReadNumberTable(const std::string& path, const std::string& header, std::uint64_t max_bytes) {
  Table table(path, ReadText(path, max_bytes), header);
  const std::vector<std::string> names = Split(header, ',');
  std::vector<std::size_t> places;
  for (const std::string& name : names) places.push_back(table.Require(name));
  for (std::size_t i = 0; i < table.header().size(); ++i) {
    const bool is_wanted = std::find(places.begin(), places.end(), i) != places.end();
    if (!is_wanted && ComponentNamed(table.header()[i])) {
      table.FailOnHeader("column '" + table.header()[i] + "': expected no more of these");
    }
  }
  std::vector<double> values;
  NumberTableRows rows;
  while (table.NextRow()) {
    for (std::size_t k = 0; k < names.size(); ++k) {
      const bool is_time = names[k] == "time";
      values.push_back(is_time ? table.LaterTime(places[k]) : table.Number(places[k], QuantityOf(names[k])));
    }
    rows.lines.push_back(table.line());
  }
  if (rows.lines.empty()) table.FailWithoutRows();
  rows.columns = Eigen::Map<const Eigen::MatrixXd>(values.data(), static_cast<Eigen::Index>(names.size()),
                                                   static_cast<Eigen::Index>(rows.lines.size()));
  return rows;
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

std::optional<int> ComponentNamed(std::string_view name) {
  const std::size_t axis = name.empty() ? std::string_view::npos : std::string_view("xyzXYZ").find(name.front());
  const std::optional<long long> group = ParseInteger(name.substr(std::min<std::size_t>(name.size(), 1)));
  if (axis == std::string_view::npos || !group || *group < 0 || *group >= kMaxNodes) return std::nullopt;
  return 3 * static_cast<int>(*group) + static_cast<int>(axis % 3);
}

}  // namespace clothid
