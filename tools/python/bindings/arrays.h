// Arrays of numbers from Python, checked, and back.
#ifndef CLOTHID_TOOLS_PYTHON_BINDINGS_ARRAYS_H_
#define CLOTHID_TOOLS_PYTHON_BINDINGS_ARRAYS_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "tools/python/bindings/bindings.h"

namespace clothid {

// `value`, an array or nested lists of real numbers, as C-contiguous float64, copied only where it is anything else.
// What a masked array (numpy.ma) masks is NaN.
// Throws `Error` (kUsage), led by `name`: for other dtypes, and unless its shape is `shape`, in which -1 stands for any
// length; `words` says the shape, "(T, N, 3)".
py::array_t<double> ToDoubles(const py::object& value, const std::string& name, const std::vector<py::ssize_t>& shape,
                              const std::string& words);

// (T, K, 3) -> [3K x T], (N, 3) -> [3 x N], (T,) -> [T].
Eigen::MatrixXd ToTracks(const py::object& value, const std::string& name, const std::string& words);
Eigen::Matrix3Xd ToPoints(const py::object& value, const std::string& name, const std::string& words);
Eigen::VectorXd ToVector(const py::object& value, const std::string& name, const std::string& words);

// Whole numbers; (F, 3) -> [3 x F].
std::vector<int> ToIndices(const py::object& value, const std::string& name);
Eigen::Matrix3Xi ToFaces(const py::object& value, const std::string& name);

// Copies.
py::array_t<double> FromTracks(const Eigen::MatrixXd& tracks);  // [3K x T] -> (T, K, 3)
py::array_t<double> FromPoints(const Eigen::Matrix3Xd& points);
py::array_t<int> FromFaces(const Eigen::Matrix3Xi& faces);
py::array_t<double> FromVector(const Eigen::VectorXd& values);
py::array_t<int> FromIndices(const std::vector<int>& values);

// A read-only view (T, K, 3) of columns [3K x T], which `owner` keeps alive.
py::array_t<double> ViewOfTracks(const Eigen::MatrixXd& tracks, const py::object& owner);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_PYTHON_BINDINGS_ARRAYS_H_
