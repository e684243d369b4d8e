#include "sim/path/pose_csv.h"

#include "sim/base/row_error.h"
#include "sim/path/number_table.h"

namespace clothid {
namespace {

constexpr char kHeader[] = "time,x,y,z,qx,qy,qz,qw";

}  // namespace

RigidPath ReadPoseCsv(const std::string& path) {
  const NumberTableRows rows = ReadNumberTable(path, kHeader, kMaxPoseCsvBytes);
  return NamingLines(path, rows.lines, [&] { return PathOfTable(rows.columns); });
}

RigidPath PathOfTable(const Eigen::MatrixXd& table) {
  return RigidPath(table.row(0).transpose(), table.middleRows<3>(1), table.bottomRows<4>());
}

Eigen::MatrixXd TableOfPath(const RigidPath& path) {
  Eigen::MatrixXd table(8, path.times().size());
  table << path.times().transpose(), path.positions(), path.rotations();
  return table;
}

}  // namespace clothid
