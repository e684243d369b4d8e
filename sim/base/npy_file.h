// NumPy's .npy array files, as far as positions, times and triangles come in them. The format: sim/base/npy_header.h
#ifndef CLOTHID_SIM_BASE_NPY_FILE_H_
#define CLOTHID_SIM_BASE_NPY_FILE_H_

#include <cstdint>
#include <string>
#include <vector>

namespace clothid {

inline constexpr std::uint64_t kMaxNpyBytes = std::uint64_t{1} << 30;

struct NpyArray {
  std::vector<long long> shape;
  std::vector<double> values;  // in C order; NaN and infinity as they stand in the file
};

struct NpyIntegers {
  std::vector<long long> shape;
  std::vector<long long> values;  // in C order
};

// Reads an array of float32 or float64, little- or big-endian, in C or Fortran order (format versions 1 to 3). Throws
// `Error`: kIo where the file cannot be read, kBadData naming file and fault where it is anything else or has more than
// kMaxNpyBytes.
NpyArray ReadNpy(const std::string& path);

// The same for integers of 1 to 8 bytes, signed or not.
NpyIntegers ReadNpyIntegers(const std::string& path);

// The bytes of a file that holds `array`: version 1.0, C order, '<f8' or '<i8'. `values` has as many entries as `shape`
// says, and `shape` at most kMaxNpyDimensions.
std::string NpyBytes(const NpyArray& array);
std::string NpyBytes(const NpyIntegers& array);

}  // namespace clothid

#endif  // CLOTHID_SIM_BASE_NPY_FILE_H_
