#include "tools/benchmark/steps/benchmark_stability.h"

#include <algorithm>
#include <optional>

#include "identify/base/parallel_for.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "tools/benchmark/steps/stability_extremes.h"

namespace clothid {
namespace {

void Require(bool condition, const std::string& message) {
  if (!condition) throw Error(ErrorKind::kUsage, message);
}

void AddCells(Integrator integrator, const StabilityOptions& options, std::vector<StabilityCell>* cells) {
  for (const std::string& scene : options.scenes) {
    const bool has_obstacle = StabilitySceneHasObstacle(scene);
    const std::size_t num_contacts = has_obstacle ? options.contacts.size() : 1;
    const std::size_t num_frictions = has_obstacle ? options.friction_coefficients.size() : 1;
    for (std::size_t c = 0; c < num_contacts; ++c) {
      const ContactMode mode =
          has_obstacle && options.contacts[c] == "velocity" ? ContactMode::kVelocity : ContactMode::kGap;
      for (const double stiffness : options.stretch_stiffness) {
        for (const int rate : options.step_rates) {
          for (std::size_t m = 0; m < num_frictions; ++m) {
            cells->push_back({scene, mode, stiffness, 1.0 / rate, options.friction_coefficients[m], integrator});
          }
        }
      }
    }
  }
}

struct ExtremeCase {
  const StabilityExtreme* extreme;
  Integrator integrator;
};

bool Includes(const StabilityOptions& options, const std::string& setting) {
  return std::find(options.settings.begin(), options.settings.end(), setting) != options.settings.end();
}

bool IsSetting(const std::string& name) {
  const auto has_name = [&](const StabilityExtreme& extreme) { return extreme.name == name; };
  return name == "grid" || name == "extremes" ||
         std::any_of(StabilityExtremes().begin(), StabilityExtremes().end(), has_name);
}

std::string Csv(const std::vector<StabilityRow>& rows) {
  std::string text = StabilityCsvHeader();
  for (const StabilityRow& row : rows) text += StabilityCsvLine(row);
  return text;
}

}  // namespace

void StabilityOptions::Validate() const {
  for (const std::string& setting : settings) {
    Require(IsSetting(setting),
            "--settings: '" + Printable(setting) + "': expected grid, extremes or the name of an extreme");
  }
  ValidateIntegrators(integrators);
  for (const std::string& scene : scenes) StabilitySceneHasObstacle(scene);
  for (const std::string& contact : contacts) {
    Require(contact == "gap" || contact == "velocity",
            "--contact: '" + Printable(contact) + "': expected gap or velocity");
  }
  for (const double k : stretch_stiffness) Require(k > 0.0, "--k_stretch: expected numbers > 0");
  for (const int rate : step_rates) Require(rate >= 1 && rate <= 100000, "--steps: expected numbers from 1 to 100000");
  for (const double mu : friction_coefficients) Require(mu >= 0.0, "--mu: expected numbers >= 0");
  Require(nodes >= 4 && nodes <= 200, "--nodes: expected one number from 4 to 200");
  Require(num_threads >= 1, "--threads: expected a number >= 1");
}

StabilityBenchmark RunStabilityBenchmark(const StabilityOptions& options) {
  options.Validate();
  std::vector<StabilityCell> cells;
  std::vector<ExtremeCase> extremes;
  for (const std::string& name : options.integrators) {
    const Integrator integrator = IntegratorNamed(name);
    if (Includes(options, "grid")) AddCells(integrator, options, &cells);
    for (const StabilityExtreme& extreme : StabilityExtremes()) {
      if (Includes(options, "extremes") || Includes(options, extreme.name)) extremes.push_back({&extreme, integrator});
    }
  }
  std::optional<std::uint64_t> seed;
  if (options.check_gradients) seed = options.seed;
  const int num_cells = static_cast<int>(cells.size());
  std::vector<StabilityRow> rows(cells.size() + extremes.size());
  ParallelFor(
      static_cast<int>(rows.size()), options.num_threads,
      [&](int i) {
        if (i < num_cells) {
          rows[i] = RunStabilityRow(cells[i].scene, MakeStabilityScene(cells[i], options.nodes), seed);
        } else {
          const ExtremeCase& extreme = extremes[i - num_cells];
          Scene scene = extreme.extreme->scene(options.nodes);
          scene.integrator = extreme.integrator;
          rows[i] = RunStabilityRow(extreme.extreme->name, scene, seed);
        }
      },
      [&](int i, int num_done) {
        if (options.on_row) options.on_row(rows[i], num_done, static_cast<int>(rows.size()));
      });
  return {{rows.begin(), rows.begin() + num_cells}, {rows.begin() + num_cells, rows.end()}};
}

std::string StabilityCsv(const StabilityBenchmark& benchmark) { return Csv(benchmark.grid); }
std::string StabilityExtremesCsv(const StabilityBenchmark& benchmark) { return Csv(benchmark.extremes); }

}  // namespace clothid
