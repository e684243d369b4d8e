#include "sim/path/handle_csv.h"

#include "sim/base/row_error.h"
#include "sim/path/number_table.h"

namespace clothid {
namespace {

std::string Header(int num_handles) {
  std::string header = "time";
  for (int i = 0; i < num_handles; ++i) {
    for (const char axis : {'x', 'y', 'z'}) header.append({',', axis}).append(std::to_string(i));
  }
  return header;
}

}  // namespace

HandlePath ReadHandleCsv(const std::string& path, int num_handles) {
  const NumberTableRows rows = ReadNumberTable(path, Header(num_handles), kMaxHandleCsvBytes);
  return NamingLines(path, rows.lines, [&] {
    return HandlePath(rows.columns.row(0).transpose(), rows.columns.bottomRows(rows.columns.rows() - 1));
  });
}

std::string HandleCsv(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions) {
  Eigen::MatrixXd table(1 + positions.rows(), times.size());
  table << times.transpose(), positions;
  return NumberTable(Header(static_cast<int>(positions.rows() / 3)), table);
}

}  // namespace clothid
