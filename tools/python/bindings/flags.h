// Flags of a program, by name, from a dict of Python.
#ifndef CLOTHID_TOOLS_PYTHON_BINDINGS_FLAGS_H_
#define CLOTHID_TOOLS_PYTHON_BINDINGS_FLAGS_H_

#include <pybind11/pybind11.h>

#include <cstddef>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "tools/python/bindings/bindings.h"
#include "tools/python/bindings/errors.h"

namespace clothid {

// `visit(&flags, visitor)` calls visitor(name, field) for every flag, as `VisitRunFlags` does. Raises UsageError,
// naming the argument, for a value of the wrong type or out of range.
template <typename Flags, typename Visit>
Flags ToFlags(const py::dict& values, const Visit& visit) {
  Flags flags;
  std::size_t num_taken = 0;
  visit(&flags, [&](const char* name, auto* field) {
    if (!values.contains(name)) return;
    const py::object given = values[name];
    try {
      *field = given.cast<std::remove_pointer_t<decltype(field)>>();
    } catch (const py::cast_error&) {
      FailArgument(name, "got " + py::repr(given).cast<std::string>() + ", which is of the wrong type or out of range");
    }
    ++num_taken;
  });
  if (num_taken < values.size()) throw std::logic_error("flags that the program does not have");
  return flags;
}

}  // namespace clothid

#endif  // CLOTHID_TOOLS_PYTHON_BINDINGS_FLAGS_H_
