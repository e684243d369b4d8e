// What is wrong with one of several rows, which a caller that has read them from a file can name by its line.
#ifndef CLOTHID_SIM_BASE_ROW_ERROR_H_
#define CLOTHID_SIM_BASE_ROW_ERROR_H_

#include <string>
#include <vector>

#include "sim/base/error.h"

namespace clothid {

// Of kind kBadData. Rows count from 0 on.
class RowError : public Error {
 public:
  RowError(long long row, const std::string& message) : Error(ErrorKind::kBadData, message), row_(row) {}
  long long row() const { return row_; }

 private:
  long long row_;
};

// What `make` makes of rows that stand in the lines `lines` of `path`. Every `Error` of it is led by the path, a
// `RowError` by the line, too.
template <typename Make>
auto NamingLines(const std::string& path, const std::vector<int>& lines, const Make& make) {
  try {
    return make();
  } catch (const RowError& error) {
    const int line = lines.at(static_cast<std::size_t>(error.row()));
    throw Error(error.kind(), path + ":" + std::to_string(line) + ": " + error.what());
  } catch (const Error& error) {
    throw Error(error.kind(), path + ": " + error.what());
  }
}

}  // namespace clothid

#endif  // CLOTHID_SIM_BASE_ROW_ERROR_H_
