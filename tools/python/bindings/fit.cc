// A fit: clothid.identify in its raw form, which the package gives its arguments and its result.
#include <pybind11/stl.h>

#include <map>
#include <utility>
#include <vector>

#include "identify/base/output_folder.h"
#include "identify/report/report.h"
#include "identify/report/report_page.h"
#include "identify/result/result_json.h"
#include "identify/run.h"
#include "identify/run_flags.h"
#include "tools/python/bindings/arrays.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/bindings/errors.h"
#include "tools/python/bindings/flags.h"
#include "tools/python/bindings/long_call.h"

namespace clothid {
namespace {

std::vector<RecordedMotion> ReadAll(const std::vector<PyMotion>& motions, const ReadMotionOptions& reading) {
  std::vector<RecordedMotion> result;
  for (const PyMotion& motion : motions) result.push_back(motion.Read(reading));
  return result;
}

py::dict IterationValues(const std::vector<std::string>& names, const FitIteration& iteration) {
  py::dict parameters;
  for (std::size_t i = 0; i < names.size(); ++i) {
    parameters[py::str(names[i])] = iteration.values[static_cast<Eigen::Index>(i)];
  }
  return py::dict(py::arg("iteration") = iteration.iteration, py::arg("seconds") = iteration.seconds,
                  py::arg("cost") = iteration.cost, py::arg("parameters") = parameters,
                  py::arg("gradient_norm") = iteration.gradient_norm, py::arg("rollouts") = iteration.rollouts);
}

py::dict StepValues(const EvaluationProgress& progress) {
  return py::dict(py::arg("evaluation") = progress.evaluation, py::arg("recording") = progress.recording,
                  py::arg("step") = progress.step.num_done, py::arg("num_steps") = progress.step.num_steps,
                  py::arg("seconds") = progress.seconds, py::arg("seconds_left") = progress.seconds_left);
}

// Calls of Python on the way; None: not called.
struct Callbacks {
  py::object on_finding, on_iteration, on_step;
};

// What a callback raises on a thread of a fit must not end that thread, but the fit: it is raised once that has ended.
class RaisedLater {
 public:
  explicit RaisedLater(std::atomic<bool>* stop) : stop_(stop) {}

  void Call(const std::function<void()>& callback) {
    const py::gil_scoped_acquire lock;
    if (raised_) return;
    try {
      callback();
    } catch (py::error_already_set& error) {
      raised_ = std::move(error);
      stop_->store(true);
    }
  }
  void Raise() {
    if (raised_) throw std::move(*raised_);
  }

 private:
  std::atomic<bool>* stop_;
  std::optional<py::error_already_set> raised_;
};

void SetCallbacks(const Callbacks& callbacks, RaisedLater* calls, std::vector<std::string>* names,
                  RunOptions* options) {
  options->on_problem = [names](const std::vector<std::string>& of_problem) { *names = of_problem; };
  options->on_finding = [&callbacks, calls](const std::string& recording, const Finding& finding) {
    calls->Call([&] { callbacks.on_finding(recording, finding.what, finding.value, finding.hint); });
  };
  if (!callbacks.on_iteration.is_none()) {
    options->fit.on_iteration = [&callbacks, calls, names](const FitIteration& iteration) {
      calls->Call([&] { callbacks.on_iteration(IterationValues(*names, iteration)); });
    };
  }
  if (!callbacks.on_step.is_none()) {
    options->fit.on_progress = [&callbacks, calls](const EvaluationProgress& progress) {
      calls->Call([&] { callbacks.on_step(StepValues(progress)); });
    };
  }
}

using PyFit = RunResult;

std::unique_ptr<PyFit> RunFit(const std::vector<PyMotion>& motions, const std::vector<PyMotion>& holdouts,
                              const py::dict& values, const std::string& command_line, const Callbacks& callbacks) {
  RunOptions options =
      ParseRunFlags(ToFlags<RunFlags>(values, [](RunFlags* flags, const auto& visit) { VisitRunFlags(flags, visit); }));
  options.command_line = command_line;
  options.keep_recordings = true;
  std::vector<std::string> names;
  auto result = std::make_unique<PyFit>();
  std::atomic<bool> stop{false};
  RaisedLater calls(&stop);
  SetCallbacks(callbacks, &calls, &names, &options);
  options.fit.cancel = &stop;
  RunInterruptibly(
      [&] {
        options.targets = ReadAll(motions, options.reading);
        options.holdouts = ReadAll(holdouts, options.reading);
        *result = Identify(options);
      },
      &stop);
  calls.Raise();
  if (!result->summary.has_estimate()) throw SimulationFailure("no estimate: " + result->summary.message);
  return result;
}

std::string Page(const PyFit& self) {
  const py::gil_scoped_release release;
  return ReportHtml(self.summary, self.checks, self.recordings);
}

std::vector<PyMotion> Predicted(const PyFit& self) {
  std::vector<PyMotion> motions;
  const FitSummary& summary = self.summary;
  for (std::size_t i = 0; i < self.recordings.size(); ++i) {
    const Eigen::MatrixXd forces = i < summary.forces.size() ? summary.forces[i] : Eigen::MatrixXd();
    MotionTensors tensors = PredictedMotion(self.recordings[i], summary.predicted[i], summary.parameters, forces);
    motions.push_back({std::make_shared<const MotionTensors>(std::move(tensors)), "predicted", ""});
  }
  return motions;
}

py::dict Fields(const PyFit& self) {
  py::dict fields;
  if (!self.summary.fields) return fields;
  for (const FittedField& field : self.summary.fields->fields) {
    const py::array_t<double, py::array::f_style> values({field.values.rows(), field.values.cols()},
                                                         field.values.data());
    fields[py::str(field.request.name)] = values;
  }
  return fields;
}

void SaveFit(const PyFit& self, const py::object& folder, bool page) {
  ReportOptions options;
  options.page = page;
  OutputFolder output(ToPath(folder));
  WriteReport(self.summary, self.checks, self.recordings, &output, options);
}

// What `SaveFit` has written once.
void SaveFiles(const py::object& folder, const std::map<std::string, std::string>& files) {
  OutputFolder output(ToPath(folder));
  output.RemoveOthers(IsReportFile);
  for (const auto& [name, bytes] : files) output.Write(name, bytes);
  output.Commit();
}

}  // namespace

void BindFit(py::module_* module) {
  py::class_<PyFit>(*module, "Fit", "A fit as it came out. See clothid.Result.")
      .def_property_readonly("json",
                             [](const PyFit& self) { return ResultJson(self.summary, self.checks, self.recordings); })
      .def_readonly("table", &PyFit::table)
      .def_property_readonly("message", [](const PyFit& self) { return self.summary.message; })
      .def_property_readonly("convergence_csv", [](const PyFit& self) { return ConvergenceCsv(self.summary); })
      .def_property_readonly("profile_csv", [](const PyFit& self) { return ProfileCsv(self.summary, self.checks); })
      .def_property_readonly("predicted", &Predicted)
      .def_property_readonly("fields", &Fields)
      .def("page", &Page)
      .def("save", &SaveFit, py::arg("folder"), py::arg("page"));
  module->def("save_files", &SaveFiles, py::arg("folder"), py::arg("files"));
  module->def(
      "run_fit",
      [](const std::vector<PyMotion>& motions, const std::vector<PyMotion>& holdouts, const py::dict& flags,
         const std::string& command_line, const py::object& on_finding, const py::object& on_iteration,
         const py::object& on_step) {
        return RunFit(motions, holdouts, flags, command_line, {on_finding, on_iteration, on_step});
      },
      py::arg("motions"), py::arg("holdouts"), py::arg("flags"), py::arg("command_line"), py::arg("on_finding"),
      py::arg("on_iteration"), py::arg("on_step"));
}

}  // namespace clothid
