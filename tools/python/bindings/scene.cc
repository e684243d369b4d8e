// clothid.Scene.
#include <filesystem>
#include <utility>

#include "datasets/fabric/scene_with_fabric.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"
#include "sim/scene/parameters.h"
#include "sim/scene/scene_json.h"
#include "tools/python/bindings/arrays.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/bindings/errors.h"

namespace clothid {
namespace {

constexpr char kSceneDoc[] = R"(A cloth, what holds it and what it touches (datasets/scene.md).

Scene(source, fabric=""): source is a dict, the JSON text of a scene, or the path of a scene.json. Every error names
the key and what was expected. fabric: light, medium, heavy, knit or denim, whose measured constants stand in for those
that the scene does not give. It never changes; it can be pickled.)";

PyScene ReadPyScene(std::string text, std::string source) {
  const std::string folder = std::filesystem::path(source).parent_path().string();
  Scene scene = ParseScene(text, source, folder);
  return {std::move(text), std::move(source), std::make_shared<const Scene>(std::move(scene)), std::nullopt};
}

py::tuple Pickled(const PyScene& self) {
  const py::object recording = self.recording ? py::cast(*self.recording) : py::none();
  return py::make_tuple(self.text, self.source, recording);
}

PyScene Unpickled(const py::tuple& state) {
  if (!state[2].is_none()) return PyScene::Of(state[2].cast<PyMotion>());
  return ReadPyScene(state[0].cast<std::string>(), state[1].cast<std::string>());
}

// The nominal value of every constant that the scene has.
py::dict NominalValues(const PyScene& self) {
  const Scene& scene = *self.scene;
  const Parameters parameters = scene.nominal_parameters();
  py::dict values;
  const auto add = [&](ParameterId id) {
    values[py::str(ParameterName(id, scene.obstacle_names(), scene.mesh.piece_names))] = GetParameter(parameters, id);
  };
  for (int i = 0; i < static_cast<int>(scene.obstacles.size()); ++i) add({ParameterKind::kFriction, 0, i});
  for (const ParameterKind kind : MaterialKinds()) {
    if (scene.has(kind)) add({kind});
  }
  for (const ParameterId id : scene.piece_parameters()) add(id);
  if (!scene.has_wind()) return values;
  for (const ParameterId id : ParametersOf(ParameterTerm::kWind)) add(id);
  return values;
}

PyScene MakeScene(const py::object& source, const std::string& fabric) {
  if (fabric.empty()) return ToScene(source);
  auto [text, name] = ToSceneText(source);
  text = WithFabricOrCard(text, fabric, "--fabric", name);
  return ReadPyScene(std::move(text), std::move(name));
}

void BindShape(py::class_<PyScene>* scene) {
  scene->def_property_readonly(
      "rest_positions", [](const PyScene& self) { return FromPoints(self.scene->mesh.rest_positions); },
      "(N, 3) m: the mesh at rest; a copy.");
  scene->def_property_readonly(
      "faces", [](const PyScene& self) { return FromFaces(self.scene->mesh.faces); },
      "(F, 3): the nodes of the triangles; a copy.");
  scene->def_property_readonly(
      "handles", [](const PyScene& self) { return FromIndices(self.scene->handles.nodes); },
      "(H,): the nodes that are held or moved.");
  scene->def_property_readonly(
      "clamped_edges",
      [](const PyScene& self) {
        py::list edges;
        for (const auto& [nodes, face] : self.scene->handles.clamped) edges.append(py::make_tuple(nodes[0], nodes[1]));
        return edges;
      },
      "[(i, j), ..]: the edges at which the cloth leaves clamps, by their nodes.");
  scene->def_property_readonly(
      "obstacles",
      [](const PyScene& self) {
        py::list names;
        for (const std::string& name : self.scene->obstacle_names()) names.append(name);
        return names;
      },
      "The names of the obstacles.");
  scene->def_property_readonly(
      "pieces", [](const PyScene& self) { return self.scene->mesh.piece_names; }, "The names of the cloth's pieces.");
  scene->def_property_readonly(
      "face_pieces", [](const PyScene& self) { return FromIndices(self.scene->mesh.face_pieces); },
      "(F,): the piece of every triangle, len(pieces) where it is in none; (0,) of a cloth without pieces.");
}

}  // namespace

PyScene PyScene::Of(const PyMotion& motion) {
  RecordedMotion read = motion.Read({});
  return {std::move(read.scene_text), motion.name, std::make_shared<const Scene>(std::move(read.scene)), motion};
}

std::string ToPath(const py::object& path) {
  const py::object text = py::reinterpret_steal<py::object>(PyOS_FSPath(path.ptr()));
  if (!text) throw py::error_already_set();
  return text.cast<std::string>();
}

std::pair<std::string, std::string> ToSceneText(const py::object& scene) {
  if (py::isinstance<PyScene>(scene)) {
    const PyScene& self = scene.cast<const PyScene&>();
    return {self.text, self.source};
  }
  if (py::isinstance<py::dict>(scene)) {
    return {py::module_::import("json").attr("dumps")(scene).cast<std::string>(), "scene"};
  }
  const bool is_path = py::isinstance<py::str>(scene) || py::hasattr(scene, "__fspath__");
  if (!is_path) FailArgument("scene", "expected a Scene, a dict, the text of a scene or a path");
  const std::string path = ToPath(scene);
  const std::string_view text = Trimmed(path);
  if (py::isinstance<py::str>(scene) && path.find_first_not_of(" \t\r\n") != std::string::npos &&
      path[path.find_first_not_of(" \t\r\n")] == '{') {
    return {path, "scene"};
  }
  if (text.empty()) FailArgument("scene", "expected a scene, got an empty text");
  return {ReadText(path, kMaxJsonBytes), path};
}

PyScene ToScene(const py::object& scene) {
  if (py::isinstance<PyScene>(scene)) return scene.cast<PyScene>();
  auto [text, source] = ToSceneText(scene);
  return ReadPyScene(std::move(text), std::move(source));
}

std::map<std::string, double> ToValues(const py::object& values, const std::string& what) {
  std::map<std::string, double> result;
  if (values.is_none()) return result;
  if (!py::isinstance<py::dict>(values)) FailArgument(what, "expected a dict {NAME: VALUE}");
  for (const auto& [name, value] : values.cast<py::dict>()) {
    const double number = PyFloat_AsDouble(value.ptr());
    if (PyErr_Occurred() != nullptr || !py::isinstance<py::str>(name)) {
      PyErr_Clear();
      FailArgument(what, "expected names with numbers; got " + py::repr(name).cast<std::string>() + ": " +
                             py::repr(value).cast<std::string>());
    }
    result[name.cast<std::string>()] = number;
  }
  return result;
}

void BindScene(py::module_* module) {
  py::class_<PyScene> scene(*module, "Scene", kSceneDoc);
  scene.def(py::init(&MakeScene), py::arg("source"), py::arg("fabric") = "");
  scene.def_readonly("json", &PyScene::text, "The JSON text.");
  scene.def_readonly("source", &PyScene::source, "The file that it came from, or \"scene\".");
  scene.def_property_readonly("num_nodes", [](const PyScene& self) { return self.scene->mesh.num_nodes(); });
  scene.def_property_readonly("num_steps", [](const PyScene& self) { return self.scene->num_steps(); });
  scene.def_property_readonly(
      "time_step", [](const PyScene& self) { return self.scene->time_step; }, "s");
  scene.def_property_readonly(
      "duration", [](const PyScene& self) { return self.scene->duration; }, "s");
  scene.def_property_readonly("parameters", &NominalValues,
                              "{name: nominal value} of every constant that it has, in SI units.");
  BindShape(&scene);
  scene.def("view", &ViewScene, py::arg("parameters") = py::none(),
            "Simulates it with the given parameters {name: value}, its nominal values for all others, and returns a "
            "View of that. Raises UsageError, SimulationError where a step does not converge.");
  scene.def("to_dict", [](const PyScene& self) { return py::module_::import("json").attr("loads")(self.text); });
  scene.def("__repr__", [](const PyScene& self) {
    return "<clothid.Scene " + self.source + ": " + std::to_string(self.scene->mesh.num_nodes()) + " nodes, " +
           std::to_string(self.scene->num_steps()) + " steps of " + ShortestText(self.scene->time_step) + " s>";
  });
  scene.def(py::pickle(&Pickled, &Unpickled));
}

}  // namespace clothid
