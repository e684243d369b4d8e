// Tables of numbers with a header, as CSV.
#ifndef CLOTHID_SIM_PATH_NUMBER_TABLE_H_
#define CLOTHID_SIM_PATH_NUMBER_TABLE_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace clothid {

struct NumberTableRows {
  Eigen::MatrixXd columns;  // a row of the file per column
  std::vector<int> lines;   // of the file, of each
};

// Reads a table (sim/base/table.h) with the columns of `header`, "time,x,y", x, y and z among them lengths: a finite
// number in each of them, in every row, of which there is at least one; times increase. A further column that
// `ComponentNamed` knows is an error: it is of a path of more handles. Throws `Error`: kIo where the file cannot be
// read, else kBadData naming file and line, also for a file of more than `max_bytes`.
NumberTableRows ReadNumberTable(const std::string& path, const std::string& header, std::uint64_t max_bytes);

// The text of such a file, whose numbers read back exactly.
std::string NumberTable(const std::string& header, const Eigen::MatrixXd& columns);

// 3 group + axis of the name "y4", of group 4; nothing for another.
std::optional<int> ComponentNamed(std::string_view name);

}  // namespace clothid

#endif  // CLOTHID_SIM_PATH_NUMBER_TABLE_H_
