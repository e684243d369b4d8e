#include "tools/python/bindings/arrays.h"

#include <algorithm>
#include <limits>
#include <string>

#include "tools/python/bindings/errors.h"

namespace clothid {
namespace {

std::string ShapeText(const py::array& array) {
  std::string text;
  for (py::ssize_t i = 0; i < array.ndim(); ++i) text += (i > 0 ? ", " : "") + std::to_string(array.shape(i));
  return "(" + text + (array.ndim() == 1 ? ",)" : ")");
}

// Throws unless the kind of its dtype is one of `kinds` (numpy's letters).
py::array ToArray(const py::object& value, const std::string& name, const std::string& kinds, const char* words) {
  py::array array;
  try {
    array = py::array::ensure(value);
  } catch (const py::error_already_set&) {
    PyErr_Clear();
  }
  if (!array) {
    PyErr_Clear();
    FailArgument(name, std::string("expected ") + words + "; got " + Py_TYPE(value.ptr())->tp_name);
  }
  if (kinds.find(array.dtype().kind()) == std::string::npos) {
    FailArgument(name, std::string("expected ") + words + "; got an array of dtype " +
                           py::str(array.dtype()).cast<std::string>());
  }
  return array;
}

void ExpectShape(const py::array& array, const std::string& name, const std::vector<py::ssize_t>& shape,
                 const std::string& words) {
  bool fits = array.ndim() == static_cast<py::ssize_t>(shape.size());
  for (std::size_t i = 0; fits && i < shape.size(); ++i) {
    fits = shape[i] == -1 || shape[i] == array.shape(static_cast<py::ssize_t>(i));
  }
  if (!fits) FailArgument(name, "expected an array of shape " + words + "; got " + ShapeText(array));
}

// Of a masked array (numpy.ma) a copy that has NaN where it is masked; `array`, its data, of others.
py::array WithoutMask(const py::object& value, const py::array& array) {
  if (!py::hasattr(value, "mask") || !py::hasattr(value, "filled")) return array;
  return value.attr("astype")("float64").attr("filled")(std::numeric_limits<double>::quiet_NaN());
}

py::array_t<int> ToInts(const py::object& value, const std::string& name) {
  const py::array array = ToArray(value, name, "iu", "whole numbers");
  return py::array_t<int, py::array::c_style | py::array::forcecast>::ensure(array);
}

}  // namespace

py::array_t<double> ToDoubles(const py::object& value, const std::string& name, const std::vector<py::ssize_t>& shape,
                              const std::string& words) {
  const py::array array = WithoutMask(value, ToArray(value, name, "fiu", "real numbers"));
  ExpectShape(array, name, shape, words);
  return py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(array);
}

Eigen::MatrixXd ToTracks(const py::object& value, const std::string& name, const std::string& words) {
  const py::array_t<double> array = ToDoubles(value, name, {-1, -1, 3}, words);
  return Eigen::Map<const Eigen::MatrixXd>(array.data(), 3 * array.shape(1), array.shape(0));
}

Eigen::Matrix3Xd ToPoints(const py::object& value, const std::string& name, const std::string& words) {
  const py::array_t<double> array = ToDoubles(value, name, {-1, 3}, words);
  return Eigen::Map<const Eigen::Matrix3Xd>(array.data(), 3, array.shape(0));
}

Eigen::VectorXd ToVector(const py::object& value, const std::string& name, const std::string& words) {
  const py::array_t<double> array = ToDoubles(value, name, {-1}, words);
  return Eigen::Map<const Eigen::VectorXd>(array.data(), array.shape(0));
}

std::vector<int> ToIndices(const py::object& value, const std::string& name) {
  const py::array_t<int> array = ToInts(value, name);
  ExpectShape(array, name, {-1}, "(H,)");
  return std::vector<int>(array.data(), array.data() + array.size());
}

Eigen::Matrix3Xi ToFaces(const py::object& value, const std::string& name) {
  const py::array_t<int> array = ToInts(value, name);
  ExpectShape(array, name, {-1, 3}, "(F, 3)");
  return Eigen::Map<const Eigen::Matrix3Xi>(array.data(), 3, array.shape(0));
}

py::array_t<double> FromTracks(const Eigen::MatrixXd& tracks) {
  return py::array_t<double>({tracks.cols(), tracks.rows() / 3, Eigen::Index{3}}, tracks.data());
}

py::array_t<double> FromPoints(const Eigen::Matrix3Xd& points) {
  return py::array_t<double>({points.cols(), Eigen::Index{3}}, points.data());
}

py::array_t<int> FromFaces(const Eigen::Matrix3Xi& faces) {
  return py::array_t<int>({faces.cols(), Eigen::Index{3}}, faces.data());
}

py::array_t<double> FromVector(const Eigen::VectorXd& values) {
  return py::array_t<double>(values.size(), values.data());
}

py::array_t<int> FromIndices(const std::vector<int>& values) {
  return py::array_t<int>(static_cast<py::ssize_t>(values.size()), values.data());
}

py::array_t<double> ViewOfTracks(const Eigen::MatrixXd& tracks, const py::object& owner) {
  py::array_t<double> view({tracks.cols(), tracks.rows() / 3, Eigen::Index{3}}, tracks.data(), owner);
  view.attr("setflags")(py::arg("write") = false);
  return view;
}

}  // namespace clothid
