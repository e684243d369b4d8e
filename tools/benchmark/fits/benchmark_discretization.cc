#include "tools/benchmark/fits/benchmark_discretization.h"

#include <iomanip>
#include <limits>
#include <sstream>
#include <utility>

#include "datasets/synthetic/regrid.h"
#include "identify/base/parallel_for.h"
#include "identify/fit/problem.h"
#include "sim/base/error.h"

namespace clothid {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

void Require(bool condition, const std::string& message) {
  if (!condition) throw Error(ErrorKind::kUsage, message);
}

// The grid with `nodes` along the first axis whose cells have the shape of the scene's.
std::array<int, 2> GridOf(int nodes, const std::array<int, 2>& scene_nodes) {
  const long long cells = static_cast<long long>(scene_nodes[1] - 1) * (nodes - 1);
  const long long other = cells / (scene_nodes[0] - 1) + 1;
  Require(cells % (scene_nodes[0] - 1) == 0 && other <= kMaxNodes / nodes,
          "--nodes: " + std::to_string(nodes) + ": expected whole numbers of nodes in the proportion of the scene's " +
              std::to_string(scene_nodes[0]) + " x " + std::to_string(scene_nodes[1]) + ", at most " +
              std::to_string(kMaxNodes));
  return {nodes, static_cast<int>(other)};
}

constexpr int kStepsPerCheckpoint = 64;  // of a truth, whose other steps are not kept

std::array<int, 2> FineGridOf(const GridScene& grid_scene) {
  return {2 * grid_scene.nodes[0] - 1, 2 * grid_scene.nodes[1] - 1};
}

// What is seen of the truth on `nodes`, once per step of the scene.
RecordedMotion RecordTruth(const GridScene& grid_scene, const std::array<int, 2>& nodes, int step_divisor,
                           const std::vector<TrueParameter>& truth) {
  Scene scene = Regrid(grid_scene, nodes);
  const int num_frames = grid_scene.scene.num_steps() + 1;
  scene.integrator = Integrator::kSdirk2;
  scene.time_step /= step_divisor;
  scene.duration = (num_frames - 1) * grid_scene.scene.time_step;
  RecordedMotion motion;
  motion.name = "recording";
  motion.points = PlaceOnMesh(scene.mesh, grid_scene.scene.mesh.rest_positions);
  motion.times.resize(num_frames);
  motion.positions.resize(3 * motion.num_points(), num_frames);
  RolloutOptions options;
  options.checkpoint_interval = kStepsPerCheckpoint;
  options.visitor = [&](int step, const Eigen::VectorXd& positions) {
    if (step % step_divisor != 0) return;
    const int frame = step / step_divisor;
    motion.times[frame] = scene.start_time + frame * grid_scene.scene.time_step;
    motion.positions.col(frame) = Interpolate(motion.points, positions);
  };
  SimulateTruth(truth, grid_scene.path, scene, options);
  return motion;
}

// The fits, not yet run.
std::vector<DiscretizationFit> PlanFits(const DiscretizationOptions& options, const GridScene& grid_scene) {
  std::vector<std::array<int, 2>> grids;
  for (const int nodes : options.nodes) grids.push_back(GridOf(nodes, grid_scene.nodes));
  if (grids.empty()) grids = {grid_scene.nodes, FineGridOf(grid_scene)};
  std::vector<DiscretizationFit> fits;
  for (const bool fine : {false, true}) {
    for (const std::string& integrator : options.integrators) {
      for (const std::array<int, 2>& nodes : fine ? grids : std::vector<std::array<int, 2>>{grid_scene.nodes}) {
        for (const int divisor : options.step_divisors) {
          DiscretizationFit fit;
          fit.true_nodes = fine ? FineGridOf(grid_scene) : grid_scene.nodes;
          fit.integrator = integrator;
          fit.nodes = nodes;
          fit.time_step = grid_scene.scene.time_step / divisor;
          fits.push_back(fit);
        }
      }
    }
  }
  return fits;
}

// "16 x 16".
std::string GridName(const std::array<int, 2>& nodes) {
  return std::to_string(nodes[0]) + " x " + std::to_string(nodes[1]);
}

// Fits the model with the scene `model` to what `recording` shows.
void RunFit(const std::vector<TrueParameter>& truth, const GridScene& grid_scene, Scene model, RecordedMotion recording,
            DiscretizationFit* fit) {
  model.time_step = fit->time_step;
  model.integrator = IntegratorNamed(fit->integrator);
  recording.points = PlaceOnMesh(model.mesh, grid_scene.scene.mesh.rest_positions);
  recording.scene = std::move(model);
  FitOptions options;
  options.jacobian = JacobianMethod::kSensitivity;
  options.estimate_uncertainty = false;
  for (const TrueParameter& parameter : truth) options.parameters.push_back(parameter.name);
  FitProblem problem({recording}, options);
  const FitSummary summary = Fit(options, &problem);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    fit->value.push_back(summary.has_estimate() ? summary.parameters[i].value : kNaN);
    fit->error.push_back(fit->value[i] / truth[i].value - 1.0);
  }
  fit->rmse = summary.has_estimate() ? summary.error.rmse() : kNaN;
  fit->rollouts = summary.statistics.rollouts;
  fit->status = summary.status;
  fit->message = summary.message;
}

}  // namespace

void DiscretizationOptions::Validate() const {
  Require(!scene_path.empty(), "--scene is missing; see benchmark --help");
  Require(!truth.empty(), "--set: expected at least one parameter, as in mu=0.3,k_stretch=100");
  for (const int n : nodes) Require(n >= 2, "--nodes: expected numbers >= 2");
  Require(!step_divisors.empty(), "--steps: expected at least one number");
  for (const int divisor : step_divisors) Require(divisor >= 1, "--steps: expected numbers >= 1");
  ValidateIntegrators(integrators);
  Require(true_step_divisor >= 1, "true_step_divisor: expected a number >= 1");
  Require(num_threads >= 1, "--threads: expected a number >= 1");
}

DiscretizationBenchmark RunDiscretizationBenchmark(const DiscretizationOptions& options) {
  options.Validate();
  const GridScene grid_scene = ReadGridScene(options.scene_path);
  DiscretizationBenchmark benchmark;
  benchmark.truth = MakeTrueParameters(options.truth, grid_scene.scene);
  benchmark.true_time_step = grid_scene.scene.time_step / options.true_step_divisor;
  benchmark.frame_rate = 1.0 / grid_scene.scene.time_step;
  benchmark.fits = PlanFits(options, grid_scene);
  std::vector<Scene> models;  // before the fits, so that they do not run in vain
  for (const DiscretizationFit& fit : benchmark.fits) models.push_back(Regrid(grid_scene, fit.nodes));
  const RecordedMotion same_grid =
      RecordTruth(grid_scene, grid_scene.nodes, options.true_step_divisor, benchmark.truth);
  const RecordedMotion fine_grid =
      RecordTruth(grid_scene, FineGridOf(grid_scene), options.true_step_divisor, benchmark.truth);
  const int num_fits = static_cast<int>(benchmark.fits.size());
  ParallelFor(
      num_fits, options.num_threads,
      [&](int i) {
        DiscretizationFit* fit = &benchmark.fits[i];
        RunFit(benchmark.truth, grid_scene, models[i], fit->true_nodes == grid_scene.nodes ? same_grid : fine_grid,
               fit);
      },
      [&](int i, int num_done) {
        if (options.on_fit) options.on_fit(benchmark.fits[i], num_done, num_fits);
      });
  return benchmark;
}

std::string DiscretizationTable(const DiscretizationBenchmark& benchmark) {
  std::ostringstream out;
  out << "truths: sdirk2, steps of " << 1e3 * benchmark.true_time_step << " ms, seen at " << benchmark.frame_rate
      << " Hz\n";
  out << "truth        method  nodes        step, ms";
  for (const TrueParameter& parameter : benchmark.truth) {
    out << std::setw(12) << parameter.name << std::setw(10) << "error, %";
  }
  out << "  rmse, mm  rollouts  status\n";
  for (const DiscretizationFit& fit : benchmark.fits) {
    out << std::left << std::setw(13) << GridName(fit.true_nodes) << std::setw(8) << fit.integrator << std::setw(13)
        << GridName(fit.nodes) << std::right << std::setw(8) << 1e3 * fit.time_step;
    for (std::size_t i = 0; i < fit.value.size(); ++i) {
      out << std::setw(12) << std::setprecision(5) << fit.value[i] << std::fixed << std::showpos << std::setprecision(2)
          << std::setw(10) << 100.0 * fit.error[i] << std::defaultfloat << std::noshowpos;
    }
    out << std::fixed << std::setprecision(3) << std::setw(10) << 1e3 * fit.rmse << std::defaultfloat
        << std::setprecision(6) << std::setw(10) << fit.rollouts << "  " << FitStatusName(fit.status) << "\n";
  }
  return out.str();
}

std::string DiscretizationCsv(const DiscretizationBenchmark& benchmark) {
  std::ostringstream out;
  out << std::setprecision(std::numeric_limits<double>::max_digits10)
      << "true_nodes_0,true_nodes_1,integrator,nodes_0,nodes_1,time_step";
  for (const TrueParameter& parameter : benchmark.truth) out << "," << parameter.name << ",error_" << parameter.name;
  out << ",rmse_m,rollouts,status\n";
  for (const DiscretizationFit& fit : benchmark.fits) {
    out << fit.true_nodes[0] << "," << fit.true_nodes[1] << "," << fit.integrator << "," << fit.nodes[0] << ","
        << fit.nodes[1] << "," << fit.time_step;
    for (std::size_t i = 0; i < fit.value.size(); ++i) out << "," << fit.value[i] << "," << fit.error[i];
    out << "," << fit.rmse << "," << fit.rollouts << "," << FitStatusName(fit.status) << "\n";
  }
  return out.str();
}

}  // namespace clothid
