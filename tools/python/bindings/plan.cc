// A plan of experiments: clothid.plan in its raw form.
#include <string>
#include <utility>

#include "identify/experiment/experiment_plan.h"
#include "identify/experiment/plan_flags.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/bindings/errors.h"
#include "tools/python/bindings/flags.h"
#include "tools/python/bindings/long_call.h"

namespace clothid {
namespace {

py::dict RunPlan(const py::dict& values, const std::string& command_line) {
  PlanOptions options = ParsePlanFlags(
      ToFlags<PlanFlags>(values, [](PlanFlags* flags, const auto& visit) { VisitPlanFlags(flags, visit); }));
  options.command_line = command_line;
  Plan plan;
  RunInterruptibly([&](const std::atomic<bool>& cancel) {
    options.fit.cancel = &cancel;
    plan = PlanExperiment(options);
  });
  if (!plan.has_any()) throw SimulationFailure("no candidate: " + plan.candidates.front().failure);
  return py::dict(py::arg("json") = PlanJson(options, plan), py::arg("table") = PlanTable(plan),
                  py::arg("page") = PlanHtml(options, plan));
}

}  // namespace

void BindPlan(py::module_* module) { module->def("run_plan", &RunPlan, py::arg("flags"), py::arg("command_line")); }

}  // namespace clothid
