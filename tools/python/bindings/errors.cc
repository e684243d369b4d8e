#include "tools/python/bindings/errors.h"

#include <cctype>
#include <string>

#include "tools/python/bindings/bindings.h"

namespace clothid {
namespace {

// Classes live as long as the interpreter.
PyObject* usage_error = nullptr;
PyObject* file_error = nullptr;
PyObject* input_error = nullptr;
PyObject* simulation_error = nullptr;

// clothid.NAME with both bases, either of which may be caught.
PyObject* NewClass(py::module_* module, const char* name, const char* doc, const py::tuple& bases) {
  const std::string full_name = std::string("clothid.") + name;
  PyObject* result = PyErr_NewExceptionWithDoc(full_name.c_str(), doc, bases.ptr(), nullptr);
  if (result == nullptr) throw py::error_already_set();
  module->attr(name) = py::handle(result);
  return result;
}

// Arguments have no dashes in Python: "--sigma: expected .." becomes "sigma: expected ..".
std::string WithoutDashes(const std::string& message) {
  std::string result;
  for (std::size_t i = 0; i < message.size(); ++i) {
    const bool starts_word = i == 0 || message[i - 1] == ' ' || message[i - 1] == '(';
    const bool is_flag = starts_word && message.compare(i, 2, "--") == 0 && i + 2 < message.size() &&
                         std::islower(static_cast<unsigned char>(message[i + 2])) != 0;
    if (is_flag) i += 2;
    result += message[i];
  }
  return result;
}

PyObject* ClassOf(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::kUsage:
      return usage_error;
    case ErrorKind::kIo:
      return file_error;
    case ErrorKind::kBadData:
      return input_error;
  }
  return input_error;
}

void Translate(std::exception_ptr failure) {
  try {
    if (failure) std::rethrow_exception(failure);
  } catch (const Error& error) {
    PyErr_SetString(ClassOf(error.kind()), WithoutDashes(error.what()).c_str());
  } catch (const SimulationFailure& error) {
    PyErr_SetString(simulation_error, error.what());
  }
}

}  // namespace

void BindErrors(py::module_* module) {
  const py::handle base = NewClass(module, "Error", "What clothid cannot do; one line says why.",
                                   py::make_tuple(py::handle(PyExc_Exception)));
  usage_error = NewClass(module, "UsageError", "A wrong argument.", py::make_tuple(base, py::handle(PyExc_ValueError)));
  file_error = NewClass(module, "FileError", "A file or folder that cannot be opened, read or written.",
                        py::make_tuple(base, py::handle(PyExc_OSError)));
  input_error = NewClass(module, "InputError", "A recording or scene that was read and cannot be used.",
                         py::make_tuple(base, py::handle(PyExc_ValueError)));
  simulation_error = NewClass(module, "SimulationError", "A simulation or a fit that came to no result.",
                              py::make_tuple(base, py::handle(PyExc_RuntimeError)));
  py::register_exception_translator(Translate);
}

}  // namespace clothid
