// The text of `benchmark stability`.
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>

#include "tools/benchmark/steps/benchmark_stability.h"

namespace clothid {
namespace {

constexpr double kStiff = 3e4;  // N/m, between the bands
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Of several rows.
struct Band {
  int cells = 0, failed_cells = 0, gaining_cells = 0, checkable_cells = 0, silent = 0;
  bool checks_gradients = false;
  RolloutCounts counts;
  double penetration = 0.0;      // m
  double excess = kNaN;          // relative, the largest
  double contact_gain = kNaN;    // of a step, relative, the largest
  double gradient_error = kNaN;  // the largest

  void Add(const StabilityRow& row) {
    ++cells;
    failed_cells += !row.ok();
    gaining_cells += row.gains_energy();
    checkable_cells += row.gradient.is_checkable();
    checks_gradients |= row.gradient.is_checkable() || !row.gradient.Reasons().empty();
    silent += row.silent_failures();
    counts += row.counts;
    penetration = std::max(penetration, row.audit.penetration);
    if (row.energy.excess > row.energy.total.tolerance) excess = std::fmax(excess, row.energy.relative_excess());
    contact_gain = std::fmax(contact_gain, row.energy.relative_contact_gain());
    gradient_error = std::fmax(gradient_error, row.gradient.error());
  }
};

// NaN: a dash.
void Put(double value, int width, int digits, std::ostream& out) {
  std::ostringstream text;
  if (std::isnan(value)) {
    text << "-";
  } else {
    text << std::fixed << std::setprecision(digits) << value;
  }
  out << std::setw(width) << text.str();
}

void PutScientific(double value, int width, std::ostream& out) {
  std::ostringstream text;
  if (std::isnan(value)) {
    text << "-";
  } else {
    text << std::scientific << std::setprecision(1) << value;
  }
  out << std::setw(width) << text.str();
}

void PutName(const std::string& name, int width, std::ostream& out) {
  out << std::left << std::setw(width) << name << std::right;
}

// "drape, gap, k 1000, h 5 ms, mu 0.35".
std::string Where(const StabilityRow& row) {
  std::ostringstream text;
  text << row.name << ", " << row.contact << ", " << row.integrator << ", k " << row.stretch_stiffness << ", h "
       << 1e3 * row.time_step << " ms";
  if (!std::isnan(row.friction_coefficient)) text << ", mu " << row.friction_coefficient;
  return text.str();
}

double PerStep(int count, const RolloutCounts& counts) {
  const int steps = counts.steps + counts.failed_steps;
  return steps > 0 ? static_cast<double>(count) / steps : kNaN;
}

void WriteBand(const std::string& integrator, const std::string& scene, const std::string& contact, bool stiff,
               const StabilityBenchmark& benchmark, std::ostream& out) {
  Band band;
  for (const StabilityRow& row : benchmark.grid) {
    if (row.integrator == integrator && row.name == scene && row.contact == contact &&
        (row.stretch_stiffness > kStiff) == stiff)
      band.Add(row);
  }
  if (band.cells == 0) return;
  PutName(integrator, 8, out);
  PutName(scene, 8, out);
  PutName(contact, 10, out);
  PutName(stiff ? "> 1e4" : "<= 1e4", 8, out);
  out << std::setw(6) << band.cells << std::setw(8) << band.failed_cells << std::setw(8) << band.counts.steps;
  Put(100.0 * PerStep(band.counts.failed_steps, band.counts), 10, 3, out);
  out << std::setw(11) << band.counts.fallbacks << std::setw(10) << band.counts.substeps;
  Put(PerStep(band.counts.newton_iterations, band.counts), 12, 1, out);
  PutScientific(band.penetration, 10, out);
  out << std::setw(7) << band.gaining_cells;
  PutScientific(band.excess, 10, out);
  PutScientific(band.contact_gain, 13, out);
  Put(band.checks_gradients ? 100.0 * band.checkable_cells / band.cells : kNaN, 11, 1, out);
  PutScientific(band.gradient_error, 10, out);
  out << std::setw(8) << band.silent << "\n";
}

void WriteGrid(const StabilityBenchmark& benchmark, std::ostream& out) {
  out << "                           k,            failed           failed                        iterations    "
         "deepest   "
         "energy gained  at contacts,  gradient checked     silent\n"
         "method  scene   contact   N/m      cells   cells   steps   steps, %  fallbacks  substeps    per step         "
         "m  "
         "cells  at most      at most   cells, %  at most  failures\n";
  for (const std::string& integrator : kIntegratorNames) {
    for (const std::string& scene : kStabilityScenes) {
      for (const char* contact : {"gap", "velocity"}) {
        for (const bool stiff : {false, true}) WriteBand(integrator, scene, contact, stiff, benchmark, out);
      }
    }
  }
}

void WriteExtremes(const StabilityBenchmark& benchmark, std::ostream& out) {
  out << "                                                         iterations   deepest    energy, J                   "
         "      "
         "gained,   gradient   silent\n"
         "method  extreme          steps   done  fallbacks  substeps   per step         m     start    change      "
         "work   "
         "relative    off by  failures\n";
  for (const StabilityRow& row : benchmark.extremes) {
    PutName(row.integrator, 8, out);
    PutName(row.name, 15, out);
    out << std::setw(7) << row.num_steps << std::setw(7) << row.counts.steps << std::setw(11) << row.counts.fallbacks
        << std::setw(10) << row.counts.substeps;
    Put(PerStep(row.counts.newton_iterations, row.counts), 11, 1, out);
    PutScientific(row.audit.penetration, 10, out);
    PutScientific(row.energy.start_energy, 10, out);
    PutScientific(row.energy.total.change, 10, out);
    PutScientific(row.energy.total.work(), 10, out);
    PutScientific(row.gains_energy() ? row.energy.relative_excess() : kNaN, 11, out);
    PutScientific(row.gradient.error(), 10, out);
    out << std::setw(10) << row.silent_failures() << "\n";
  }
}

// The rows that `says` has something to say of.
template <typename Says>
void WriteList(const std::string& title, const StabilityBenchmark& benchmark, const Says& says, std::ostream& out) {
  std::ostringstream lines;
  int count = 0;
  for (const auto* rows : {&benchmark.grid, &benchmark.extremes}) {
    for (const StabilityRow& row : *rows) {
      const std::string text = says(row);
      if (text.empty()) continue;
      lines << "  " << Where(row) << ": " << text << "\n";
      ++count;
    }
  }
  if (count > 0) out << "\n" << title << " (" << count << "):\n" << lines.str();
}

std::string DescribeGain(const StabilityRow& row) {
  if (!row.gains_energy()) return "";
  std::ostringstream text;
  text << std::scientific << std::setprecision(1) << row.energy.excess << " J at " << std::defaultfloat
       << row.energy.excess_time << " s, " << std::scientific << row.energy.relative_excess() << " of the largest";
  return text.str();
}

std::string DescribeSilence(const StabilityRow& row) {
  if (row.silent_failures() == 0) return "";
  const RolloutAudit& audit = row.audit;
  std::ostringstream text;
  text << audit.not_finite << " not finite, " << audit.inconsistent << " inconsistent, " << audit.unsolved
       << " unsolved, " << audit.too_deep << " too deep, " << audit.missing_steps << " missing, "
       << row.energy.unexplained_steps << " with unexplained energy";
  return text.str();
}

}  // namespace

std::string StabilityTable(const StabilityBenchmark& benchmark) {
  std::ostringstream out;
  if (!benchmark.grid.empty()) WriteGrid(benchmark, out);
  if (!benchmark.grid.empty() && !benchmark.extremes.empty()) out << "\n";
  if (!benchmark.extremes.empty()) WriteExtremes(benchmark, out);
  WriteList("silent failures", benchmark, DescribeSilence, out);
  WriteList(
      "failed", benchmark, [](const StabilityRow& row) { return row.error; }, out);
  WriteList("energy gained without work: compressed cloth that buckles within a step, or the error of an sdirk2 step",
            benchmark, DescribeGain, out);
  WriteList(
      "gradient not checked", benchmark, [](const StabilityRow& row) { return row.gradient.Reasons(); }, out);
  return out.str();
}

}  // namespace clothid
