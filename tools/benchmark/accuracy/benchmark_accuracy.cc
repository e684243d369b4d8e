#include "tools/benchmark/accuracy/benchmark_accuracy.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>

#include "sim/base/error.h"
#include "sim/scene/mesh.h"
#include "tools/benchmark/accuracy/accuracy_case.h"
#include "tools/benchmark/accuracy/accuracy_fit.h"
#include "tools/benchmark/accuracy/accuracy_forward.h"
#include "tools/benchmark/accuracy/accuracy_gradient.h"

namespace clothid {
namespace {

// Of the second table.
const std::vector<double> kErrorLevels = {1e-1, 1e-2, 1e-3, 1e-5, 1e-7};
const std::vector<std::string> kWholeReferences = {"time_step/64", "finest/64", "direct", "truth"};

void Require(bool condition, const std::string& message) {
  if (!condition) throw Error(ErrorKind::kUsage, message);
}

std::vector<AccuracyPoint> Measure(const AccuracyCase& accuracy_case, const std::string& quantity,
                                   const AccuracyOptions& options) {
  if (quantity == "forward") return MeasureForward(accuracy_case, options.integrators, options.nodes, options.repeats);
  if (quantity == "gradient") return MeasureGradients(accuracy_case, options.nodes, options.repeats);
  return MeasureFits(accuracy_case, (options.nodes + 1) / 2, options.repeats);
}

using Points = std::vector<AccuracyPoint>;

// Runs of points, in their order, that are alike.
template <typename AreAlike>
std::vector<Points> Group(const Points& points, AreAlike are_alike) {
  std::vector<Points> groups;
  for (const AccuracyPoint& point : points) {
    if (groups.empty() || !are_alike(groups.back().back(), point)) groups.emplace_back();
    groups.back().push_back(point);
  }
  return groups;
}

void PutCase(const AccuracyPoint& point, std::ostream& out) {
  out << std::left << std::setw(7) << point.scene << std::setw(10) << point.setting << std::setw(9) << point.quantity;
}

// The largest and the least of the values above zero, and their distance in decades; dashes where there is none.
void PutRange(std::vector<double> values, double unit, std::ostream& out) {
  values.erase(std::remove_if(values.begin(), values.end(), [](double value) { return !(value > 0.0); }), values.end());
  if (values.empty()) {
    out << std::setw(10) << "-" << std::setw(10) << "-" << std::setw(9) << "-";
    return;
  }
  const auto [least, largest] = std::minmax_element(values.begin(), values.end());
  out << std::setprecision(2) << std::setw(10) << unit * *largest << std::setw(10) << unit * *least << std::fixed
      << std::setprecision(1) << std::setw(9) << std::log10(*largest / *least) << std::defaultfloat;
}

void WriteCurve(const Points& curve, std::ostream& out) {
  std::vector<double> errors, seconds;
  int failed = 0;
  for (const AccuracyPoint& point : curve) {
    errors.push_back(point.error);
    seconds.push_back(point.seconds);
    failed += std::isnan(point.error);
  }
  PutCase(curve.front(), out);
  out << std::setw(16) << curve.front().method << std::setw(17) << curve.front().reference << std::right << std::setw(6)
      << curve.size() << std::setw(8) << failed;
  PutRange(errors, 1.0, out);
  PutRange(seconds, 1e3, out);
  out << "\n";
}

// "h/4 1e-06", "kept 0.01", "sensitivity"; then the milliseconds.
std::string Describe(const AccuracyPoint* point) {
  if (point == nullptr) return "-";
  std::ostringstream text;
  if (point->quantity == "forward") {
    const long divisor = std::lround(FindBackpropSetting(point->setting).time_step / point->time_step);
    text << point->method << " " << (divisor == 1 ? "h" : "h/" + std::to_string(divisor));
  } else {
    text << point->method;
  }
  if (point->quantity != "fit" && !std::isnan(point->threshold)) text << " " << point->threshold;
  text << std::setprecision(3) << "  " << 1e3 * point->seconds;
  return text.str();
}

void WriteCheapest(const Points& points, std::ostream& out) {
  PutCase(points.front(), out);
  out << std::setw(14) << points.front().reference;
  for (const double level : kErrorLevels) {
    const bool is_last = level == kErrorLevels.back();
    out << std::setw(is_last ? 0 : 25) << Describe(FindCheapest(points, level));
  }
  out << "\n";
}

bool IsWhole(const AccuracyPoint& point) {
  return std::find(kWholeReferences.begin(), kWholeReferences.end(), point.reference) != kWholeReferences.end();
}

}  // namespace

void AccuracyOptions::Validate() const {
  RequireKnown(scenes, kBenchmarkScenes, "--scene");
  RequireKnown(settings, BackpropSettingNames(), "--settings");
  ValidateIntegrators(integrators);
  RequireKnown(quantities, kAccuracyQuantities, "--quantities");
  Require(nodes >= 5 && nodes % 4 == 1 && nodes <= kMaxNodes / nodes / 4,
          "--nodes: expected one number of nodes, 5, 9, 13, .., not too large");
  Require(repeats >= 1, "--repeats: expected a number >= 1");
}

AccuracyBenchmark RunAccuracyBenchmark(const AccuracyOptions& options) {
  options.Validate();
  AccuracyBenchmark benchmark;
  const int num_items = static_cast<int>(options.scenes.size() * options.settings.size() * options.quantities.size());
  int num_done = 0;
  for (const std::string& scene : options.scenes) {
    for (const std::string& setting : options.settings) {
      for (const std::string& quantity : options.quantities) {
        const Points points = Measure({scene, FindBackpropSetting(setting)}, quantity, options);
        benchmark.points.insert(benchmark.points.end(), points.begin(), points.end());
        if (options.on_measured) options.on_measured(scene + ", " + setting + ", " + quantity, ++num_done, num_items);
      }
    }
  }
  return benchmark;
}

std::string AccuracyTable(const AccuracyBenchmark& benchmark) {
  std::ostringstream out;
  out << "                                                                        error                        "
         "ms\n"
         "scene  setting   quantity method          error against    points  failed   largest     least  decades   "
         "largest     least  decades\n";
  const auto same_curve = [](const AccuracyPoint& a, const AccuracyPoint& b) {
    return AreComparable(a, b) && a.method == b.method;
  };
  for (const Points& curve : Group(benchmark.points, same_curve)) WriteCurve(curve, out);
  out << "\nthe cheapest with an error of at most .., and its ms; h: the time step of the setting, with the step "
         "tolerance; gradient: the sweep alone\n"
         "scene  setting   quantity against       ";
  for (const double level : kErrorLevels) out << std::left << std::setw(level == kErrorLevels.back() ? 0 : 25) << level;
  out << "\n";
  for (const Points& points : Group(benchmark.points, AreComparable)) {
    if (IsWhole(points.front())) WriteCheapest(points, out);
  }
  return out.str();
}

std::string AccuracyCsv(const AccuracyBenchmark& benchmark) {
  std::ostringstream out;
  out << std::setprecision(std::numeric_limits<double>::max_digits10)
      << "scene,quantity,method,threshold,error,seconds,steps_failed,setting,reference,nodes,time_step,iteration,"
         "pareto\n";
  const std::vector<bool> front = ParetoFront(benchmark.points);
  for (std::size_t i = 0; i < benchmark.points.size(); ++i) {
    const AccuracyPoint& point = benchmark.points[i];
    out << point.scene << "," << point.quantity << "," << point.method << "," << point.threshold << "," << point.error
        << "," << point.seconds << "," << point.steps_failed << "," << point.setting << "," << point.reference << ","
        << point.nodes << "," << point.time_step << "," << point.iteration << "," << front[i] << "\n";
  }
  return out.str();
}

}  // namespace clothid
