// .npy files as tests need them.
#ifndef CLOTHID_TESTS_NPY_BYTES_H_
#define CLOTHID_TESTS_NPY_BYTES_H_

#include <Eigen/Core>
#include <string>

namespace clothid {

// A .npy file of format version 1 with the columns as rows of a (M, 3) array of float64.
inline std::string NpyBytes(const Eigen::Matrix3Xd& points) {
  std::string header =
      "{'descr': '<f8', 'fortran_order': False, 'shape': (" + std::to_string(points.cols()) + ", 3), }";
  header.resize((10 + header.size() + 1 + 63) / 64 * 64 - 11, ' ');
  header += '\n';
  std::string bytes = std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(header.size() % 256) +
                      static_cast<char>(header.size() / 256) + header;
  return bytes.append(reinterpret_cast<const char*>(points.data()), static_cast<std::size_t>(points.size()) * 8);
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_NPY_BYTES_H_
