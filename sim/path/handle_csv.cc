#include "sim/path/handle_csv.h"

#include "sim/base/error.h"
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
  const Eigen::MatrixXd table = ReadNumberTable(path, Header(num_handles), kMaxHandleCsvBytes);
  try {
    return HandlePath(table.row(0).transpose(), table.bottomRows(table.rows() - 1));
  } catch (const Error& error) {
    throw Error(ErrorKind::kBadData, path + ": " + error.what());
  }
}

std::string HandleCsv(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions) {
  Eigen::MatrixXd table(1 + positions.rows(), times.size());
  table << times.transpose(), positions;
  return NumberTable(Header(static_cast<int>(positions.rows() / 3)), table);
}

}  // namespace clothid
