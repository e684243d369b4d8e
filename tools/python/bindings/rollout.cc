// clothid.Rollout: a simulated motion with its exact derivatives.
#include "sim/rollout/rollout.h"

#include <pybind11/stl.h>

#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "costs/assimilation/recording_correction.h"
#include "datasets/observation/observation.h"
#include "datasets/synthetic/true_parameters.h"
#include "sim/derivative/adjoint.h"
#include "sim/derivative/sensitivity.h"
#include "sim/rollout/simulator.h"
#include "tools/python/bindings/arrays.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/bindings/errors.h"
#include "tools/python/bindings/long_call.h"

namespace clothid {
namespace {

constexpr char kRolloutDoc[] = R"(A simulated motion of every node, with its exact derivatives.

Rollout(scene, parameters=None, recording=None, memory=None): simulates `scene` with the given parameters {name: value},
its nominal values for all others. `recording`, a Motion of the same cloth, corrects the state after each of its frames:
errors of the state are forgotten within `memory` s, and positions are the predictions before each correction. Raises
UsageError, and SimulationError where a step does not converge. For optimisers of your own: see pull_back and
push_forward. Calls of one Rollout take turns.)";

constexpr char kPullBackDoc[] = R"(pull_back(dcost_dpositions, parameters) -> ndarray (P,)

The gradient of a scalar with respect to the named parameters, each in its own unit, by one reverse sweep.
dcost_dpositions (T + 1, N, 3): its derivative with respect to `positions`, in units of the scalar per m.)";

constexpr char kPushForwardDoc[] = R"(push_forward(parameters) -> ndarray (T + 1, N, 3, P)

The derivative of `positions` with respect to the named parameters, in m per their units, by one forward sweep.)";

// Interrupts a reverse sweep, which has no other way to end.
struct Interrupted {};

struct PyRollout {
  std::shared_ptr<const Scene> scene;
  std::unique_ptr<Simulator> simulator;
  Rollout rollout;
  Eigen::MatrixXd positions;  // [3N x (T + 1)]
  std::mutex mutex;           // of the simulator
};

std::vector<ParameterId> ToParameters(const py::object& names, const Scene& scene) {
  std::vector<ParameterId> parameters;
  if (py::isinstance<py::str>(names)) FailArgument("parameters", "expected a list of names");
  for (const py::handle name : py::iter(names)) parameters.push_back(ParseParameter(name.cast<std::string>(), scene));
  if (parameters.empty()) FailArgument("parameters", "expected a name");
  return parameters;
}

// How `recording` corrects rollouts of the scene of `simulator`; null without one.
std::shared_ptr<const Correction> CorrectionBy(const std::optional<PyMotion>& recording, std::optional<double> memory,
                                               const Simulator& simulator) {
  if (recording.has_value() != memory.has_value()) FailArgument("memory", "expected with a recording, and only there");
  if (!recording) return nullptr;
  if (!(*memory > 0.0 && std::isfinite(*memory))) FailArgument("memory", "expected a number > 0 in s");
  RecordedMotion motion = recording->Read({});
  if (motion.scene.initial_positions.size() != simulator.scene().initial_positions.size()) {
    FailArgument("recording", "expected one of the scene's cloth, with as many nodes");
  }
  motion.scene = simulator.scene();
  const Observation observation(motion);
  return std::make_shared<const RecordingCorrection>(Assimilation{*memory}, InfluenceOf(), observation, motion.times,
                                                     simulator.model());
}

std::unique_ptr<PyRollout> MakeRollout(const py::object& scene_like, const py::object& values,
                                       const std::optional<PyMotion>& recording, std::optional<double> memory) {
  const PyScene scene = ToScene(scene_like);
  auto self = std::make_unique<PyRollout>();
  Scene true_scene = *scene.scene;
  const Parameters truth = SetTrueParameters(ToValues(values, "parameters"), "parameters", scene.source, &true_scene);
  self->scene = std::make_shared<const Scene>(std::move(true_scene));
  RunInterruptibly([&](const std::atomic<bool>& cancel) {
    const int num_steps = self->scene->num_steps();
    self->simulator = std::make_unique<Simulator>(*self->scene);
    self->positions.resize(self->scene->initial_positions.size(), num_steps + 1);
    RolloutOptions options;
    options.correction = CorrectionBy(recording, memory, *self->simulator);
    options.visitor = [&](int step, const Eigen::VectorXd& positions) { self->positions.col(step) = positions; };
    self->rollout = Simulate(truth, num_steps, self->simulator.get(), &cancel, options);
    if (!self->rollout.ok()) throw SimulationFailure(self->rollout.failure->ToString());
  });
  return self;
}

py::array_t<double> PullBackPositions(PyRollout* self, const py::object& dcost, const py::object& names) {
  const std::vector<ParameterId> parameters = ToParameters(names, *self->scene);
  const Eigen::Index num_steps = self->positions.cols(), num_nodes = self->positions.rows() / 3;
  const py::array_t<double> array =
      ToDoubles(dcost, "dcost_dpositions", {num_steps, num_nodes, 3}, "(T + 1, N, 3), that of positions");
  const Eigen::Map<const Eigen::MatrixXd> gradients(array.data(), self->positions.rows(), num_steps);
  if (!gradients.allFinite()) FailArgument("dcost_dpositions", "expected finite numbers");
  RolloutGradient result;
  RunInterruptibly([&](const std::atomic<bool>& cancel) {
    const std::lock_guard<std::mutex> lock(self->mutex);
    const auto add = [&](int step, Eigen::MatrixXd* gradient) {
      if (cancel) throw Interrupted();
      gradient->col(0) += gradients.col(step);
    };
    result = PullBack(self->rollout, parameters, 1, add, self->simulator.get());
  });
  return FromVector(result.parameters.col(0));
}

py::array_t<double> PushForwardPositions(PyRollout* self, const py::object& names) {
  const std::vector<ParameterId> parameters = ToParameters(names, *self->scene);
  const Eigen::Index rows = self->positions.rows(), num_parameters = static_cast<Eigen::Index>(parameters.size());
  py::array_t<double> result({self->positions.cols(), rows / 3, Eigen::Index{3}, num_parameters});
  double* const data = result.mutable_data();
  RunInterruptibly([&](const std::atomic<bool>& cancel) {
    const std::lock_guard<std::mutex> lock(self->mutex);
    const auto keep = [&](int step, const Eigen::VectorXd&, const Eigen::MatrixXd& derivative) {
      if (cancel) throw Interrupted();
      // Parameters last: rows of [P] one after the other.
      Eigen::Map<Eigen::MatrixXd>(data + step * rows * num_parameters, num_parameters, rows) = derivative.transpose();
    };
    PushForward(self->rollout, {parameters, {}, {}, {}}, keep, self->simulator.get());
  });
  return result;
}

}  // namespace

void BindRollout(py::module_* module) {
  py::class_<PyRollout> rollout(*module, "Rollout", kRolloutDoc);
  rollout.def(py::init(&MakeRollout), py::arg("scene"), py::arg("parameters") = py::none(),
              py::arg("recording") = py::none(), py::arg("memory") = py::none());
  rollout.def_property_readonly(
      "positions", [](const py::object& self) { return ViewOfTracks(self.cast<const PyRollout&>().positions, self); },
      "(T + 1, N, 3) m: every node at the start and after every step; a read-only view, no copy.");
  rollout.def_property_readonly(
      "times",
      [](const PyRollout& self) {
        const Eigen::Index count = self.positions.cols();
        return FromVector(self.rollout.start_time +
                          self.rollout.time_step *
                              Eigen::ArrayXd::LinSpaced(count, 0.0, static_cast<double>(count - 1)));
      },
      "(T + 1,) s.");
  rollout.def("pull_back", &PullBackPositions, kPullBackDoc, py::arg("dcost_dpositions"), py::arg("parameters"));
  rollout.def("push_forward", &PushForwardPositions, kPushForwardDoc, py::arg("parameters"));
}

}  // namespace clothid
