// Motion.view and Scene.view: pages to look at.
#include "datasets/files/atomic_file.h"
#include "identify/view/view_page.h"
#include "tools/python/bindings/bindings.h"

namespace clothid {
namespace {

// The class is Python's: clothid/_view.py.
py::object MakeView(const PyMotion& motion, bool is_simulated) {
  ReadMotionOptions options;
  options.smooth_handles = false;
  const std::string html = ViewHtml(motion.Read(options), is_simulated);
  return py::module_::import("clothid._view").attr("View")(html);
}

void WritePage(const py::object& path, const std::string& html) { WriteFileAtomically(ToPath(path), {html}); }

}  // namespace

py::object ViewMotion(const PyMotion& motion) { return MakeView(motion, false); }

py::object ViewScene(const PyScene& scene, const py::object& values) {
  SyntheticOptions options;
  if (!scene.scene->handles.nodes.empty()) options.force_sensor.emplace();
  PyMotion motion = SimulateMotion(py::cast(scene), values, options, py::none());
  motion.name = scene.source;
  return MakeView(motion, true);
}

void BindView(py::module_* module) { module->def("write_page", &WritePage, py::arg("path"), py::arg("html")); }

}  // namespace clothid
