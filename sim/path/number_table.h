// Tables of numbers with a header, as CSV.
#ifndef CLOTHID_SIM_PATH_NUMBER_TABLE_H_
#define CLOTHID_SIM_PATH_NUMBER_TABLE_H_

#include <Eigen/Core>
#include <cstdint>
#include <string>

namespace clothid {

// Reads a CSV file with the header `header`, "time,x,y", and at least one row with a finite number for each of its
// names; cells as of `CsvCells`; empty lines do not count. The rows of the file are the columns of the result. Throws `Error`:
// kIo where the file cannot be read, else kBadData naming file and line, also for a file of more than `max_bytes`.
Eigen::MatrixXd ReadNumberTable(const std::string& path, const std::string& header, std::uint64_t max_bytes);

// The text of such a file, whose numbers read back exactly.
std::string NumberTable(const std::string& header, const Eigen::MatrixXd& columns);

}  // namespace clothid

#endif  // CLOTHID_SIM_PATH_NUMBER_TABLE_H_
