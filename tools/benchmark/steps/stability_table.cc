// The text of `benchmark stability`.
#include <algorithm>
#include <cmath>

#include "tools/benchmark/steps/benchmark_stability.h"

namespace clothid {
namespace {

constexpr double kStiff = 3e4;  // N/m, between the bands

// Of several rows.
struct Band {
  int cells = 0, failed_cells = 0, gaining_cells = 0, silent = 0;
  RolloutCounts counts;
  double penetration = 0.0;  // m
  double gain = 0.0;         // relative, the largest

  void Add(const StabilityRow& row) {
    ++cells;
    failed_cells += !row.ok();
    gaining_cells += row.gains_energy();
    silent += row.audit.violations();
    counts += row.counts;
    penetration = std::max(penetration, row.audit.penetration);
    gain = std::max(gain, row.gain.share());
  }
};

double PerStep(int count, const RolloutCounts& counts) {
  const int steps = counts.steps + counts.failed_steps;
  return steps > 0 ? static_cast<double>(count) / steps : kNoNumber;
}

std::string BandLine(const std::string& integrator, const std::string& scene, const std::string& contact, bool stiff,
                     const StabilityBenchmark& benchmark) {
  Band band;
  for (const StabilityRow& row : benchmark.grid) {
    const bool is_in = row.integrator == integrator && row.name == scene && row.contact == contact;
    if (is_in && (row.stretch_stiffness > kStiff) == stiff) band.Add(row);
  }
  if (band.cells == 0) return "";
  const RolloutCounts& counts = band.counts;
  return Format("%-8s%-8s%-10s%-8s", integrator.c_str(), scene.c_str(), contact.c_str(), stiff ? "> 1e4" : "<= 1e4") +
         Format("%6d%8d%8d%10.3f%11d%10d%12.1f%10.1e", band.cells, band.failed_cells, counts.steps,
                100.0 * PerStep(counts.failed_steps, counts), counts.fallbacks, counts.substeps,
                PerStep(counts.newton_iterations, counts), band.penetration) +
         Format("%7d%10.1e%8d\n", band.gaining_cells, band.gain, band.silent);
}

std::string GridTable(const StabilityBenchmark& benchmark) {
  std::string table =
      "                           k,            failed           failed                        iterations    deepest"
      "    gaining 1 %  silent\n"
      "method  scene   contact   N/m      cells   cells   steps   steps, %  fallbacks  substeps    per step         m"
      "  cells  at most failures\n";
  for (const std::string& integrator : kIntegratorNames) {
    for (const std::string& scene : kStabilityScenes) {
      for (const char* contact : {"gap", "velocity"}) {
        for (const bool stiff : {false, true}) table += BandLine(integrator, scene, contact, stiff, benchmark);
      }
    }
  }
  return table;
}

// The rows of the grid with this integrator and scene, soft or stiff, that meet themselves; empty where there are none.
std::string SelfContactLine(const std::string& integrator, const std::string& scene, bool stiff,
                            const StabilityBenchmark& benchmark) {
  int cells = 0, cut_cells = 0, steps = 0;
  double push = 0.0;  // of the largest energy
  RolloutCounts counts;
  SelfContactAudit sum;
  for (const StabilityRow& row : benchmark.grid) {
    const bool is_in = row.integrator == integrator && row.name == scene && row.meets_itself;
    if (!is_in || (row.stretch_stiffness > kStiff) != stiff) continue;
    const SelfContactAudit& audit = row.audit.self_contact;
    ++cells;
    cut_cells += audit.num_cut > 0;
    steps += row.counts.steps;
    counts += row.counts;
    sum.dependent_steps += audit.dependent_steps;
    sum.num_cut += audit.num_cut;
    sum.intersections += audit.intersections;
    sum.violation = std::max(sum.violation, audit.violation);
    if (audit.push > 0.0) push = std::max(push, audit.push / row.gain.largest_energy);
  }
  if (cells == 0) return "";
  return Format("%-8s%-8s%-8s%6d%8d%10d%10d%11d%7d%7d%8d%10.1e%10.1e\n", integrator.c_str(), scene.c_str(),
                stiff ? "> 1e4" : "<= 1e4", cells, steps, counts.self_contacts, counts.second_solves,
                sum.dependent_steps, cut_cells, sum.num_cut, sum.intersections, sum.violation, push);
}

// Empty where no cloth of the grid meets itself.
std::string SelfContactTable(const StabilityBenchmark& benchmark) {
  std::string lines;
  for (const std::string& integrator : kIntegratorNames) {
    for (const std::string& scene : kStabilityScenes) {
      for (const bool stiff : {false, true}) lines += SelfContactLine(integrator, scene, stiff, benchmark);
    }
  }
  if (lines.empty()) return "";
  return "\n                k,                       pairs,    solves  dependent    cut    cut   pairs    nearer  "
         "energy by\n"
         "method  scene   N/m      cells   steps contacts  repeated      steps  cells  steps    that      by m    "
         "pushing\n" +
         lines;
}

std::string ExtremesTable(const StabilityBenchmark& benchmark) {
  std::string table =
      "                                                         iterations   deepest   energy    silent\n"
      "method  extreme          steps   done  fallbacks  substeps   per step         m   gained  failures\n";
  for (const StabilityRow& row : benchmark.extremes) {
    table += Format("%-8s%-15s%7d%7d%11d%10d%11s%10.1e%9.1e%10d\n", row.integrator.c_str(), row.name.c_str(),
                    row.num_steps, row.counts.steps, row.counts.fallbacks, row.counts.substeps,
                    FixedNumber(PerStep(row.counts.newton_iterations, row.counts), 1).c_str(), row.audit.penetration,
                    row.gain.share(), row.audit.violations());
  }
  return table;
}

// The rows that `says` has something to say of.
template <typename Says>
std::string ListRows(const std::string& title, const StabilityBenchmark& benchmark, const Says& says) {
  std::string lines;
  int count = 0;
  for (const auto* rows : {&benchmark.grid, &benchmark.extremes}) {
    for (const StabilityRow& row : *rows) {
      const std::string text = says(row);
      if (text.empty()) continue;
      lines += "  " + DescribeRow(row) + ": " + text + "\n";
      ++count;
    }
  }
  return count > 0 ? Format("\n%s (%d):\n", title.c_str(), count) + lines : "";
}

}  // namespace

std::string DescribeRow(const StabilityRow& row) {
  std::string text = Format("%s, %s, %s, k %g, h %g ms", row.name.c_str(), row.contact.c_str(), row.integrator.c_str(),
                            row.stretch_stiffness, 1e3 * row.time_step);
  if (!std::isnan(row.friction_coefficient)) text += Format(", mu %g", row.friction_coefficient);
  return text;
}

std::string StabilityTable(const StabilityBenchmark& benchmark) {
  std::string table;
  if (!benchmark.grid.empty()) table += GridTable(benchmark) + SelfContactTable(benchmark);
  if (!benchmark.grid.empty() && !benchmark.extremes.empty()) table += "\n";
  if (!benchmark.extremes.empty()) table += ExtremesTable(benchmark);
  table += ListRows("silent failures", benchmark, [](const StabilityRow& row) {
    const RolloutAudit& audit = row.audit;
    if (audit.violations() == 0) return std::string();
    return Format("%d not finite, %d inconsistent, %d unsolved, %d too deep, %d missing", audit.not_finite,
                  audit.inconsistent, audit.unsolved, audit.too_deep, audit.missing_steps);
  });
  table += ListRows("the cloth cuts itself", benchmark, [](const StabilityRow& row) {
    const SelfContactAudit& audit = row.audit.self_contact;
    if (audit.num_cut == 0) return std::string();
    return Format("%d pairs of triangles over %d steps, from step %d on", audit.intersections, audit.num_cut,
                  audit.first_cut);
  });
  table += ListRows("failed", benchmark, [](const StabilityRow& row) { return row.error; });
  table += ListRows("energy gained: compressed cloth that buckles within a step, or the error of an sdirk2 step",
                    benchmark, [](const StabilityRow& row) {
                      return row.gains_energy() ? Format("%.1e J at %g s, %.1e of the largest", row.gain.energy,
                                                         row.gain.time, row.gain.share())
                                                : std::string();
                    });
  return table;
}

}  // namespace clothid
