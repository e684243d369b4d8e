// What the parts of the Python module share: its objects and how values pass between both languages. Nothing here
// computes: every function of the module is one of the library.
//
// Arrays of Python are C-contiguous, with time first: positions (T, N, 3) are the columns of [3N x T].
#ifndef CLOTHID_TOOLS_PYTHON_BINDINGS_BINDINGS_H_
#define CLOTHID_TOOLS_PYTHON_BINDINGS_BINDINGS_H_

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "datasets/motion/motion_file.h"
#include "datasets/motion/motion_tensors.h"
#include "datasets/synthetic/synthetic.h"
#include "sim/scene/scene.h"

namespace clothid {

namespace py = pybind11;

// A recording as it stands in a file. It never changes, so views of it may be handed out.
struct PyMotion {
  std::shared_ptr<const MotionTensors> tensors;
  std::string name;    // for messages: the file that it came from
  std::string sha256;  // of that file; empty: it came from memory

  // What `ReadMotion` makes of it.
  RecordedMotion Read(const ReadMotionOptions& options) const;
};

// A scene with the text that it was read from. Neither ever changes.
struct PyScene {
  std::string text;    // JSON
  std::string source;  // names it in errors; names of files in the text start at its folder
  std::shared_ptr<const Scene> scene;
  std::optional<PyMotion> recording;  // whose scene it is, and which has what the text leaves out; absent: none

  static PyScene Of(const PyMotion& motion);
};

// A Scene, a dict, the text of one (it begins with a brace) or the path of a scene.json.
PyScene ToScene(const py::object& scene);
// The same, unread: a recording may bring a mesh of its own. Text and source.
std::pair<std::string, std::string> ToSceneText(const py::object& scene);
// The path that a str or os.PathLike names.
std::string ToPath(const py::object& path);
// Of a dict, a list of pairs is no good; None is empty. `what` names it in errors.
std::map<std::string, double> ToValues(const py::object& values, const std::string& what);

// What a sensor sees of a scene with the values of some of its parameters, a dict. `progress` may be None.
PyMotion SimulateMotion(const py::object& scene, const py::object& values, const SyntheticOptions& options,
                        const py::object& progress);
// A clothid.View of a recording, or of the motion of a scene.
py::object ViewMotion(const PyMotion& motion);
py::object ViewScene(const PyScene& scene, const py::object& values);

void BindErrors(py::module_* module);
void BindScene(py::module_* module);
void BindMotion(py::module_* module);
void BindSimulate(py::module_* module);
void BindRollout(py::module_* module);
void BindFit(py::module_* module);
void BindPlan(py::module_* module);
void BindPredict(py::module_* module);
void BindLandscape(py::module_* module);
void BindExport(py::module_* module);
void BindView(py::module_* module);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_PYTHON_BINDINGS_BINDINGS_H_
