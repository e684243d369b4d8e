#include "tools/python/bindings/pickled_motion.h"

#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <array>
#include <tuple>
#include <utility>
#include <vector>

#include "datasets/motion/motion_validation.h"

namespace clothid {
namespace {

// Calls visit(name, field) for every field of `tensors`, constant or not.
template <typename Tensors, typename Visit>
void VisitFields(Tensors* tensors, const Visit& visit) {
  visit("times", &tensors->times);
  visit("positions", &tensors->positions);
  visit("single_precision", &tensors->single_precision);
  visit("rest_positions", &tensors->mesh.rest_positions);
  visit("faces", &tensors->mesh.faces);
  visit("corner_rest", &tensors->mesh.corner_rest);
  visit("folds", &tensors->mesh.folds);
  visit("node_index", &tensors->node_index);
  visit("face_index", &tensors->face_index);
  visit("barycentric", &tensors->barycentric);
  visit("point_kind", &tensors->point_kind);
  visit("handle_index", &tensors->handle_index);
  visit("handle_positions", &tensors->handle_positions);
  visit("handle_times", &tensors->handle_times);
  visit("sigma", &tensors->sigma);
  visit("clouds", &tensors->clouds);
  visit("single_precision_clouds", &tensors->single_precision_clouds);
  visit("cloud_sigma", &tensors->cloud_sigma);
  visit("force_times", &tensors->forces.times);
  visit("force_values", &tensors->forces.values);
  visit("force_groups", &tensors->forces.groups);
  visit("force_sigma", &tensors->forces.sigma);
  visit("sequences", &tensors->sequences);
  visit("scene_text", &tensors->scene_text);
  visit("provenance", &tensors->provenance);
}

}  // namespace

py::dict PickledMotion(const PyMotion& motion) {
  py::dict state;
  state["name"] = motion.name;
  state["sha256"] = motion.sha256;
  VisitFields(motion.tensors.get(), [&](const char* name, const auto* field) { state[name] = py::cast(*field); });
  py::list links;
  for (const SeamLink& link : motion.tensors->mesh.links) {
    links.append(py::make_tuple(link.node, link.edge, link.share, link.stiffness, link.closing_time));
  }
  state["links"] = links;
  return state;
}

PyMotion UnpickledMotion(const py::dict& state) {
  MotionTensors tensors;
  VisitFields(&tensors, [&](const char* name, auto* field) {
    *field = state[name].cast<std::remove_reference_t<decltype(*field)>>();
  });
  using Link = std::tuple<int, std::array<int, 2>, double, double, double>;
  for (const auto& [node, edge, share, stiffness, time] : state["links"].cast<std::vector<Link>>()) {
    tensors.mesh.links.push_back({node, edge, share, stiffness, time});
  }
  std::string name = state["name"].cast<std::string>();
  ValidateMotionTensors(tensors, name);
  return {std::make_shared<const MotionTensors>(std::move(tensors)), std::move(name),
          state["sha256"].cast<std::string>()};
}

}  // namespace clothid
