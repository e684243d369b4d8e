// Handle paths as a table.
#ifndef CLOTHID_SIM_PATH_HANDLE_CSV_H_
#define CLOTHID_SIM_PATH_HANDLE_CSV_H_

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "sim/path/handle_path.h"

namespace clothid {

inline constexpr std::uint64_t kMaxHandleCsvBytes = std::uint64_t{1} << 28;

// Reads a table (sim/base/table.h) with the columns "time,x0,y0,z0,x1,y1,z1,.." and one row per time (s, m): a triple
// of columns for each of `num_handles` handles, in the order of the scene's list. Throws `Error`: kIo where the file
// cannot be read, else kBadData naming file and line, also for a file of more than kMaxHandleCsvBytes.
HandlePath ReadHandleCsv(const std::string& path, int num_handles);

// The text of such a file, whose numbers read back exactly. times [T] s, positions [3H x T] m.
std::string HandleCsv(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions);

}  // namespace clothid

#endif  // CLOTHID_SIM_PATH_HANDLE_CSV_H_
