// clothid.simulate.
#include <utility>

#include "datasets/synthetic/synthetic.h"
#include "datasets/synthetic/true_parameters.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/bindings/errors.h"
#include "tools/python/bindings/long_call.h"

namespace clothid {
namespace {

constexpr char kSimulateDoc[] =
    R"(simulate(scene, parameters=None, *, noise=0.0, frame_rate=0.0, drop=0.0, markers=0, cloud=0,
         float32=False, seed=1, progress=None) -> Motion

Runs a scene with the given parameters {name: value}, its nominal values for all others, and returns what a sensor
would have seen, as the program `simulate` does, in the same bytes: noise in m, frame_rate in Hz (0: a frame per step),
drop the fraction of points that are missing, markers the number of nodes seen (0: all), cloud that of the points per
frame of an unordered cloud in place of the nodes. progress(step, num_steps) is called after every step; what it raises
ends the simulation. Raises UsageError, SimulationError where a step does not converge.)";

// Calls `progress` after every step.
RolloutOptions Watched(const py::object& progress, int num_steps) {
  RolloutOptions options;
  if (progress.is_none()) return options;
  options.visitor = [&progress, num_steps](int step, const Eigen::VectorXd&) {
    const py::gil_scoped_acquire lock;
    if (step > 0) progress(step, num_steps);
  };
  return options;
}

}  // namespace

PyMotion SimulateMotion(const py::object& scene_like, const py::object& values, const SyntheticOptions& options,
                        const py::object& progress) {
  const PyScene scene = ToScene(scene_like);
  Scene true_scene = *scene.scene;
  const Parameters truth = SetTrueParameters(ToValues(values, "parameters"), "parameters", scene.source, &true_scene);
  CheckSyntheticOptions(options, true_scene, scene.text);
  const RolloutOptions watched = Watched(progress, true_scene.num_steps());
  auto tensors = std::make_shared<MotionTensors>();
  RunInterruptibly([&](const std::atomic<bool>& cancel) {
    Simulator simulator(true_scene);
    const Rollout rollout = Simulate(truth, true_scene.num_steps(), &simulator, &cancel, watched);
    if (!rollout.ok()) throw SimulationFailure(rollout.failure->ToString());
    *tensors = RecordRollout(rollout, true_scene, scene.text, options);
  });
  return {std::move(tensors), "recording", ""};
}

void BindSimulate(py::module_* module) {
  module->def(
      "simulate",
      [](const py::object& scene, const py::object& parameters, double noise, double frame_rate, double drop,
         int markers, int cloud, bool float32, std::uint64_t seed, const py::object& progress) {
        SyntheticOptions options;
        options.noise_sigma = noise;
        options.frame_rate = frame_rate;
        options.drop_fraction = drop;
        options.num_markers = markers;
        options.num_cloud_points = cloud;
        options.single_precision = float32;
        options.seed = seed;
        return SimulateMotion(scene, parameters, options, progress);
      },
      kSimulateDoc, py::arg("scene"), py::arg("parameters") = py::none(), py::kw_only(), py::arg("noise") = 0.0,
      py::arg("frame_rate") = 0.0, py::arg("drop") = 0.0, py::arg("markers") = 0, py::arg("cloud") = 0,
      py::arg("float32") = false, py::arg("seed") = 1, py::arg("progress") = py::none());
}

}  // namespace clothid
