// clothid.Motion.
#include <pybind11/stl.h>

#include <sstream>
#include <utility>

#include "datasets/checking/motion_check.h"
#include "datasets/files/sha256.h"
#include "datasets/importing/import_motion.h"
#include "datasets/motion/motion_container.h"
#include "datasets/motion/motion_name.h"
#include "datasets/motion/motion_validation.h"
#include "tools/python/bindings/arrays.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/bindings/errors.h"
#include "tools/python/bindings/pickled_motion.h"

namespace clothid {
namespace {

constexpr char kMotionDoc[] = R"(A recording: measured positions over time, and the scene in which they moved.

Motion(positions, *, scene, times=None, frame_rate=0.0, handle_nodes=None, handle_positions=None, handle_times=None,
       sigma=None, node_index=None, rest_positions=None, faces=None, provenance="")

positions (T, P, 3) m, NaN where a point was not seen. Point p is node p of the mesh, or node node_index[p].
times (T,) s, increasing; or frame_rate in Hz. scene: a Scene, dict, text or path, without `duration`, and without
`mesh` where rest_positions (N, 3) m and faces (F, 3) give it. handle_nodes (H,): the nodes that are held; their path is
that of their points, or handle_positions (K, H, 3) m at handle_times (K,) s, those of the frames where not given.
sigma: standard deviation of a coordinate, m, a number or (P,). Raises UsageError and InputError, naming the argument
or key. It never changes; it can be pickled.)";

struct MotionArguments {
  py::object times, handle_nodes, handle_positions, handle_times, sigma, node_index, rest_positions, faces;
};

// The path of the handles and their nodes.
void SetHandles(const MotionArguments& arguments, const Eigen::VectorXd& times, ImportOptions* options) {
  if (!arguments.handle_nodes.is_none()) options->handle_nodes = ToIndices(arguments.handle_nodes, "handle_nodes");
  if (arguments.handle_positions.is_none()) {
    if (!arguments.handle_times.is_none()) FailArgument("handle_times", "expected with handle_positions");
    return;
  }
  const Eigen::MatrixXd path = ToTracks(arguments.handle_positions, "handle_positions", "(K, H, 3)");
  const Eigen::VectorXd own =
      arguments.handle_times.is_none() ? times : ToVector(arguments.handle_times, "handle_times", "(K,)");
  if (own.size() != path.cols()) {
    FailArgument("handle_positions", "expected " + std::to_string(own.size()) + " times, as many as " +
                                         (arguments.handle_times.is_none() ? "frames" : "handle_times") + "; got " +
                                         std::to_string(path.cols()));
  }
  if (!path.allFinite()) FailArgument("handle_positions", "expected finite numbers, as nothing fills what is missing");
  options->handle_path = HandlePath(own, path);
}

void SetMesh(const MotionArguments& arguments, ImportOptions* options) {
  if (arguments.rest_positions.is_none() != arguments.faces.is_none()) {
    FailArgument("rest_positions", "expected with faces, and faces with it");
  }
  if (arguments.faces.is_none()) return;
  options->mesh =
      Mesh{ToPoints(arguments.rest_positions, "rest_positions", "(N, 3)"), ToFaces(arguments.faces, "faces")};
}

// Of every point, or of all.
Eigen::VectorXd ToSigma(const py::object& sigma, Eigen::Index num_points) {
  if (sigma.is_none()) return {};
  if (py::isinstance<py::float_>(sigma) || py::isinstance<py::int_>(sigma)) {
    return Eigen::VectorXd::Constant(num_points, sigma.cast<double>());
  }
  const py::array_t<double> values = ToDoubles(sigma, "sigma", {num_points}, "(P,)");
  return Eigen::Map<const Eigen::VectorXd>(values.data(), num_points);
}

PyMotion MakeMotion(const py::object& positions, const py::object& scene, double frame_rate,
                    const std::string& provenance, const MotionArguments& arguments) {
  PointTracks tracks;
  tracks.name = "positions";
  tracks.positions = ToTracks(positions, "positions", "(T, P, 3)");
  ImportOptions options;
  options.provenance = provenance;
  options.edit.frame_rate = frame_rate;
  if (!arguments.times.is_none()) {
    const py::array_t<double> times = ToDoubles(arguments.times, "times", {tracks.num_frames()}, "(T,)");
    tracks.times = Eigen::Map<const Eigen::VectorXd>(times.data(), tracks.num_frames());
  } else if (frame_rate == 0.0) {
    FailArgument("times", "expected times or frame_rate");
  }
  if (!arguments.node_index.is_none()) {
    PointMap& map = options.given_map.emplace();
    map.node_index = ToIndices(arguments.node_index, "node_index");
    for (int p = 0; p < tracks.num_points(); ++p) map.points.push_back(p);
  }
  SetMesh(arguments, &options);
  std::tie(options.scene_text, options.scene_path) = ToSceneText(scene);
  const Eigen::VectorXd times =
      tracks.times.size() > 0 ? tracks.times : TimesAtRate(frame_rate, tracks.num_frames(), {}, "frame_rate");
  SetHandles(arguments, times, &options);
  MotionTensors tensors = ImportMotion(tracks, options);
  tensors.sigma = ToSigma(arguments.sigma, tracks.num_points());
  ValidateMotionTensors(tensors, "positions");
  return {std::make_shared<const MotionTensors>(std::move(tensors)), "recording", ""};
}

PyMotion LoadMotion(const py::object& path) {
  const std::string name = ToPath(path);
  VerifiedMotion file = ReadVerifiedMotion(name);
  PyMotion motion = {std::make_shared<const MotionTensors>(std::move(file.tensors)), name, std::move(file.sha256)};
  motion.Read({});  // what cannot be fitted is told at once
  return motion;
}

void SaveMotion(const PyMotion& self, const py::object& path) {
  const std::string name = ToPath(path);
  ExpectMotionName(name);
  WriteMotion(*self.tensors, name);
}

std::string Words(const PyMotion& self) {
  std::ostringstream words;
  const Eigen::VectorXd& times = self.tensors->times;
  words << "<clothid.Motion " << self.name << ": " << times.size() << " frames of "
        << self.tensors->positions.rows() / 3 << " points, " << times[0] << " to " << times[times.size() - 1] << " s>";
  return words.str();
}

py::array_t<double> Positions(const py::object& self) {
  return ViewOfTracks(self.cast<const PyMotion&>().tensors->positions, self);
}

std::string CheckJson(const PyMotion& self) {
  ReadMotionOptions options;
  options.smooth_handles = false;
  return FindingsJson(CheckMotion(self.Read(options)), self.name);
}

void BindArrays(py::class_<PyMotion>* motion) {
  motion->def_property_readonly("positions", &Positions,
                                "(T, P, 3) m, float64, NaN where a point was not seen; a read-only view, no copy.");
  motion->def_property_readonly(
      "times", [](const PyMotion& self) { return FromVector(self.tensors->times); }, "(T,) s; a copy.");
  motion->def_property_readonly(
      "sigma",
      [](const PyMotion& self) -> py::object {
        if (self.tensors->sigma.size() == 0) return py::none();
        return FromVector(self.tensors->sigma);
      },
      "(P,) m, standard deviation of a coordinate, or None; a copy.");
  motion->def_property_readonly(
      "rest_positions", [](const PyMotion& self) { return FromPoints(self.tensors->mesh.rest_positions); },
      "(N, 3) m: the mesh at rest; a copy.");
  motion->def_property_readonly(
      "faces", [](const PyMotion& self) { return FromFaces(self.tensors->mesh.faces); }, "(F, 3); a copy.");
}

}  // namespace

RecordedMotion PyMotion::Read(const ReadMotionOptions& options) const {
  RecordedMotion motion = InterpretMotion(*tensors, name, options);
  motion.sha256 = sha256;
  return motion;
}

void BindMotion(py::module_* module) {
  py::class_<PyMotion> motion(*module, "Motion", kMotionDoc);
  motion.def(py::init([](const py::object& positions, const py::object& scene, const py::object& times,
                         double frame_rate, const py::object& handle_nodes, const py::object& handle_positions,
                         const py::object& handle_times, const py::object& sigma, const py::object& node_index,
                         const py::object& rest_positions, const py::object& faces, const std::string& provenance) {
               return MakeMotion(
                   positions, scene, frame_rate, provenance,
                   {times, handle_nodes, handle_positions, handle_times, sigma, node_index, rest_positions, faces});
             }),
             py::arg("positions"), py::kw_only(), py::arg("scene"), py::arg("times") = py::none(),
             py::arg("frame_rate") = 0.0, py::arg("handle_nodes") = py::none(),
             py::arg("handle_positions") = py::none(), py::arg("handle_times") = py::none(),
             py::arg("sigma") = py::none(), py::arg("node_index") = py::none(), py::arg("rest_positions") = py::none(),
             py::arg("faces") = py::none(), py::arg("provenance") = "");
  motion.def_static("load", &LoadMotion, py::arg("path"),
                    "Reads and verifies a motion.bin. Raises FileError, InputError.");
  motion.def("save", &SaveMotion, py::arg("path"), "Writes a motion.bin, whole or not at all. Raises FileError.");
  motion.def("view", &ViewMotion,
             "A View: the replay with forces, wind and what `check` finds, for notebooks and browsers.");
  BindArrays(&motion);
  motion.def_property_readonly("scene", &PyScene::Of, "The scene, with the mesh, start and time of the recording.");
  motion.def_readonly("name", &PyMotion::name, "The file that it came from, or \"recording\".");
  motion.def_property_readonly("provenance", [](const PyMotion& self) { return self.tensors->provenance; });
  motion.def("__repr__", &Words);
  motion.def(py::pickle(&PickledMotion, &UnpickledMotion));
  module->def("check_json", &CheckJson, py::arg("motion"));
}

}  // namespace clothid
