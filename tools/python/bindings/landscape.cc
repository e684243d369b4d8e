// A landscape: clothid.landscape in its raw form.
#include <pybind11/stl.h>

#include <limits>
#include <utility>

#include "identify/base/options.h"
#include "sim/scene/parameters.h"
#include "tools/landscape/landscape_plan.h"
#include "tools/landscape/landscape_scan.h"
#include "tools/landscape/landscape_summary.h"
#include "tools/python/bindings/arrays.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/bindings/errors.h"
#include "tools/python/bindings/long_call.h"

namespace clothid {
namespace {

LandscapeFlags ToLandscapeFlags(const std::map<std::string, std::string>& texts) {
  LandscapeFlags flags;
  const std::map<std::string, std::string LandscapeFlags::*> fields = {
      {"x", &LandscapeFlags::x},       {"y", &LandscapeFlags::y},         {"zoom_around", &LandscapeFlags::zoom_around},
      {"zoom", &LandscapeFlags::zoom}, {"sweep", &LandscapeFlags::sweep}, {"contact", &LandscapeFlags::contact}};
  for (const auto& [name, text] : texts) flags.*fields.at(name) = text;
  return flags;
}

// A number of every cell [settings, windows, y, x].
py::array_t<double> OfCells(const Landscape& landscape, double LandscapeCell::*number) {
  const LandscapePlan& plan = landscape.plan;
  py::array_t<double> values({plan.settings.size(), plan.windows.size(),
                              static_cast<std::size_t>(plan.windows.front().y.num_cells),
                              static_cast<std::size_t>(plan.windows.front().x.num_cells)});
  for (std::size_t i = 0; i < landscape.cells.size(); ++i) values.mutable_data()[i] = landscape.cells[i].*number;
  return values;
}

// The values of an axis [windows, cells].
py::array_t<double> AxisValues(const LandscapePlan& plan, LandscapeAxis LandscapeWindow::*which) {
  const std::size_t num_cells = static_cast<std::size_t>((plan.windows.front().*which).num_cells);
  py::array_t<double> values({plan.windows.size(), num_cells});
  for (std::size_t w = 0; w < plan.windows.size(); ++w) {
    for (std::size_t i = 0; i < num_cells; ++i) {
      values.mutable_at(w, i) = (plan.windows[w].*which).Value(static_cast<int>(i));
    }
  }
  return values;
}

py::dict Described(const Landscape& landscape) {
  const LandscapePlan& plan = landscape.plan;
  py::list settings, zooms;
  for (const LandscapeSetting& setting : plan.settings) {
    settings.append(py::make_tuple(setting.name, ContactModeName(setting.contact_mode)));
  }
  for (const LandscapeWindow& window : plan.windows) zooms.append(window.zoom);
  const LandscapeSummary summary = Summarize(landscape);
  py::dict result(
      py::arg("parameters") = py::make_tuple(plan.windows.front().x.parameter, plan.windows.front().y.parameter),
      py::arg("settings") = settings, py::arg("zooms") = zooms, py::arg("x") = AxisValues(plan, &LandscapeWindow::x),
      py::arg("y") = AxisValues(plan, &LandscapeWindow::y), py::arg("cost") = OfCells(landscape, &LandscapeCell::cost),
      py::arg("summary") = SummaryJson(summary), py::arg("table") = SummaryTable(summary));
  result["gradient_x"] = py::none();
  result["gradient_y"] = py::none();
  if (plan.has_gradients) {
    result["gradient_x"] = OfCells(landscape, &LandscapeCell::gradient_x);
    result["gradient_y"] = OfCells(landscape, &LandscapeCell::gradient_y);
  }
  return result;
}

py::dict RunLandscapeScan(const PyMotion& motion, const std::map<std::string, std::string>& texts, bool zoom_only,
                          bool gradients, const py::object& truth, const std::string& sigma, const std::string& initial,
                          int threads) {
  LandscapeFlags flags = ToLandscapeFlags(texts);
  flags.zoom_only = zoom_only;
  flags.gradients = gradients;
  if (threads < 1) FailArgument("threads", "expected a number >= 1");
  const std::map<std::string, double> true_values = ToValues(truth, "set");
  ReadMotionOptions reading;
  ParseSigma(sigma, &reading);
  reading.start = ParseStartSource(initial);
  Landscape landscape;
  RunInterruptibly([&](const std::atomic<bool>& cancel) {
    const MotionReader read = [&](const ReadMotionOptions& how) { return motion.Read(how); };
    LandscapeScanOptions scan = SetUpLandscape(flags, read, reading);
    scan.num_threads = threads;
    scan.cancel = &cancel;
    if (!true_values.empty()) MeasureTruth(true_values, &scan);
    landscape = ScanLandscape(scan);
  });
  return Described(landscape);
}

}  // namespace

void BindLandscape(py::module_* module) {
  module->def("run_landscape", &RunLandscapeScan, py::arg("motion"), py::arg("flags"), py::arg("zoom_only"),
              py::arg("gradients"), py::arg("set"), py::arg("sigma"), py::arg("initial"), py::arg("threads"));
}

}  // namespace clothid
