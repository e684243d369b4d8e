// Motions as what pickle can keep.
#ifndef CLOTHID_TOOLS_PYTHON_BINDINGS_PICKLED_MOTION_H_
#define CLOTHID_TOOLS_PYTHON_BINDINGS_PICKLED_MOTION_H_

#include "tools/python/bindings/bindings.h"

namespace clothid {

py::dict PickledMotion(const PyMotion& motion);
// Throws `Error` (kBadData) where the state is no valid recording.
PyMotion UnpickledMotion(const py::dict& state);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_PYTHON_BINDINGS_PICKLED_MOTION_H_
