// What stands before the numbers of a .npy file. Internal to sim/.
// https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
//
// The magic string "\x93NUMPY", two bytes with the version of the format, the length of the header in 2 bytes (version
// 1) or 4 (versions 2 and 3), little-endian, then the header, a Python dictionary padded with blanks:
//   {'descr': '<f8', 'fortran_order': False, 'shape': (64, 3), }
#ifndef CLOTHID_SIM_BASE_NPY_HEADER_H_
#define CLOTHID_SIM_BASE_NPY_HEADER_H_

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace clothid {

inline constexpr std::size_t kMaxNpyDimensions = 32;  // of NumPy before version 2

struct NpyHeader {
  std::string descr;  // type of the elements: byte order, kind, bytes
  bool fortran_order = false;
  std::vector<long long> shape;  // every entry >= 0
  std::size_t size = 0;          // bytes before the numbers
};

// Reads the header from the bytes of a whole file. Nothing of it is evaluated: three keys with a string, True or False,
// and a tuple of integers are all that it may hold. Throws `Error` (kBadData), prefixed by `path`.
NpyHeader ReadNpyHeader(const std::string& path, std::string_view bytes);

// The bytes of a header of version 1.0 for numbers in C order.
std::string NpyHeaderBytes(const std::string& descr, const std::vector<long long>& shape);

}  // namespace clothid

#endif  // CLOTHID_SIM_BASE_NPY_HEADER_H_
