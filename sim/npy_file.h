// NumPy's .npy array files, as far as positions come in them.
#ifndef CLOTHID_SIM_NPY_FILE_H_
#define CLOTHID_SIM_NPY_FILE_H_

#include <cstdint>
#include <string>
#include <vector>

namespace clothid {

inline constexpr std::uint64_t kMaxNpyBytes = std::uint64_t{1} << 30;

struct NpyArray {
  std::vector<long long> shape;
  std::vector<double> values;  // in C order; NaN and infinity as they stand in the file
};

// Reads an array of little-endian float32 or float64 in C order (format versions 1 to 3). Throws `Error`: kIo where the
// file cannot be read, kBadData naming file and fault where it is anything else or has more than kMaxNpyBytes.
NpyArray ReadNpy(const std::string& path);

}  // namespace clothid

#endif  // CLOTHID_SIM_NPY_FILE_H_
