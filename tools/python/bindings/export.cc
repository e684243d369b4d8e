// clothid.export.
#include "identify/export/export.h"

#include <pybind11/stl.h>

#include "tools/python/bindings/bindings.h"

namespace clothid {
namespace {

constexpr char kExportDoc[] = R"(export(scene, parameters=None, simulators="all") -> {file name: text}

The constants of a cloth as files for other simulators: mujoco (a model, ready to run), newton, arcsim, blender, ppf;
with formula, unit and source beside every number, and what does not map. parameters: {name: value}, as `Result.values`;
nominal values for all others. Raises UsageError.)";

py::dict ExportTexts(const py::object& scene_like, const py::object& values, const py::object& simulators) {
  const PyScene scene = ToScene(scene_like);
  std::string names;
  if (py::isinstance<py::str>(simulators)) {
    names = simulators.cast<std::string>();
  } else {
    for (const py::handle name : py::iter(simulators)) names += (names.empty() ? "" : ",") + name.cast<std::string>();
  }
  const Parameters parameters = ParametersOfEstimates(ToValues(values, "parameters"), *scene.scene);
  ValidateParameters(parameters, *scene.scene, "parameters");
  py::dict texts;
  for (const ExportedFile& file : ExportCloth(*scene.scene, parameters, ParseSimulators(names, "simulators"))) {
    texts[py::str(file.name)] = file.text;
  }
  return texts;
}

}  // namespace

void BindExport(py::module_* module) {
  module->def("export", &ExportTexts, kExportDoc, py::arg("scene"), py::arg("parameters") = py::none(),
              py::arg("simulators") = "all");
}

}  // namespace clothid
