#include "tools/benchmark/accuracy/accuracy_curves.h"

#include <Eigen/Core>
#include <numeric>
#include <utility>

#include "datasets/synthetic/regrid.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "tools/benchmark/base/benchmark_scene.h"
#include "tools/benchmark/base/timing.h"

namespace clothid {
namespace {

constexpr double kSlopeTension = 0.4;  // N/m, along both axes: as much as friction puts on the cloth
constexpr int kReferenceDivisor = 64;
constexpr int kGradientSteps = 20;
constexpr double kEnoughSeconds = 0.5;  // of rollouts, for a median that stands

struct Trajectory {
  Mesh mesh;
  Eigen::MatrixXd frames;      // [3N x frames] m, the start first; empty where a step failed
  double seconds = kNoNumber;  // processor time; NaN where a step failed
  int failed_steps = 0;
};

// `accuracy_case` with steps of h/divisor, solved to `tolerance`.
Trajectory SimulateFrames(const AccuracyCase& accuracy_case, Integrator integrator, int nodes, int divisor,
                          double tolerance, int repeats) {
  Scene scene = accuracy_case.MakeScene(nodes);
  scene.integrator = integrator;
  const int num_frames = scene.num_steps() + 1;
  scene.time_step /= divisor;
  scene.solver.step_tolerance = tolerance;
  Trajectory trajectory;
  trajectory.mesh = scene.mesh;
  trajectory.frames.resize(scene.initial_positions.size(), num_frames);
  RolloutOptions options;
  options.visitor = [&](int step, const Eigen::VectorXd& positions) {
    if (step % divisor == 0) trajectory.frames.col(step / divisor) = positions;
  };
  const Parameters parameters = scene.nominal_parameters();
  Simulator simulator(std::move(scene));
  std::vector<double> seconds;
  while (static_cast<int>(seconds.size()) < repeats &&
         std::accumulate(seconds.begin(), seconds.end(), 0.0) < kEnoughSeconds) {
    const double start = ThreadSeconds();
    const Rollout rollout = Simulate(parameters, (num_frames - 1) * divisor, &simulator, nullptr, options);
    seconds.push_back(ThreadSeconds() - start);
    trajectory.failed_steps = rollout.counts.failed_steps;
    if (rollout.ok()) continue;
    trajectory.frames.resize(0, 0);
    return trajectory;
  }
  trajectory.seconds = MedianOfRuns(std::move(seconds));
  return trajectory;
}

// Of frames of the same points; NaN where one of the rollouts failed.
double TrajectoryError(const Eigen::MatrixXd& frames, const Eigen::MatrixXd& reference) {
  if (frames.size() == 0 || reference.size() == 0) return kNoNumber;
  return (frames - reference).norm() / (reference.colwise() - reference.col(0)).norm();
}

// At the nodes of `mesh`, which lie on that of the trajectory.
Eigen::MatrixXd FramesAtNodes(const Trajectory& trajectory, const Mesh& mesh) {
  if (trajectory.frames.size() == 0) return {};
  return Interpolate(PlaceOnMesh(trajectory.mesh, mesh.rest_positions), trajectory.frames);
}

struct GradientMethod {
  const char* name;
  AdjointMethod method;
  bool use_kept_factors = true;  // see AdjointOptions
};

constexpr GradientMethod kGradientMethods[] = {
    {"umfpack", AdjointMethod::kLu},        {"fixed_point", AdjointMethod::kFixedPoint},
    {"gmres", AdjointMethod::kSystemGmres}, {"reduced", AdjointMethod::kReduced, /*use_kept_factors=*/false},
    {"kept", AdjointMethod::kReduced},
};

}  // namespace

Scene AccuracyCase::MakeScene(int nodes) const {
  Scene made = MakeBenchmarkScene(scene, nodes, setting.stretch_stiffness, setting.time_step);
  made.duration = setting.stretch_stiffness > 1e4 ? 0.1 : 0.2;
  if (scene == "slope") {
    Eigen::Map<Eigen::Matrix3Xd> positions(made.initial_positions.data(), 3, made.mesh.num_nodes());
    const Eigen::Vector3d center = positions.rowwise().mean();
    positions = ((1.0 + kSlopeTension / setting.stretch_stiffness) * (positions.colwise() - center)).colwise() + center;
  }
  return made;
}

AccuracyPoint AccuracyCase::MakePoint(const std::string& quantity, const std::string& reference,
                                      const std::string& method, int nodes) const {
  AccuracyPoint point;
  point.scene = scene;
  point.setting = setting.name;
  point.quantity = quantity;
  point.reference = reference;
  point.method = method;
  point.nodes = nodes;
  point.time_step = setting.time_step;
  return point;
}

std::vector<AccuracyPoint> MeasureTimeSteps(const AccuracyCase& accuracy_case,
                                            const std::vector<std::string>& integrators, int nodes, int repeats) {
  const Trajectory reference =
      SimulateFrames(accuracy_case, Integrator::kSdirk2, nodes, kReferenceDivisor, kTightTolerance, 1);
  const Eigen::MatrixXd finest = FramesAtNodes(
      SimulateFrames(accuracy_case, Integrator::kSdirk2, 2 * nodes - 1, kReferenceDivisor, kMeshTolerance, 1),
      reference.mesh);
  std::vector<AccuracyPoint> same_mesh, finest_mesh;
  for (const std::string& name : integrators) {
    for (const int divisor : kStepDivisors) {
      for (const double tolerance : kDivisorTolerances) {
        const Trajectory trajectory =
            SimulateFrames(accuracy_case, IntegratorNamed(name), nodes, divisor, tolerance, repeats);
        AccuracyPoint point = accuracy_case.MakePoint("forward", "time_step/64", name, nodes);
        point.time_step /= divisor;
        point.threshold = tolerance;
        point.error = TrajectoryError(trajectory.frames, reference.frames);
        point.seconds = trajectory.seconds;
        point.steps_failed = trajectory.failed_steps;
        same_mesh.push_back(point);
        if (tolerance != kMeshTolerance) continue;
        point.reference = "finest/64";
        point.error = TrajectoryError(trajectory.frames, finest);
        finest_mesh.push_back(point);
      }
    }
  }
  same_mesh.insert(same_mesh.end(), finest_mesh.begin(), finest_mesh.end());
  return same_mesh;
}

std::vector<AccuracyPoint> MeasureGradients(const AccuracyCase& accuracy_case, int nodes, int repeats) {
  BackpropCase backprop({accuracy_case.scene, accuracy_case.setting.name, nodes, kGradientSteps});
  backprop.SetStepTolerance(kTightTolerance);
  const RolloutGradient reference = backprop.Differentiate({AdjointMethod::kLu});
  std::vector<AccuracyPoint> points;
  for (const GradientMethod& method : kGradientMethods) {
    const bool is_direct = method.method == AdjointMethod::kLu;
    for (const double threshold : is_direct ? std::vector<double>{kNoNumber} : kGradientThresholds) {
      AccuracyPoint point = accuracy_case.MakePoint("gradient", "direct", method.name, nodes);
      point.threshold = threshold;
      std::vector<double> seconds;
      for (int repeat = 0; repeat < repeats; ++repeat) {
        const double start = ThreadSeconds();
        const RolloutGradient gradient = backprop.Differentiate({method.method, threshold, method.use_kept_factors});
        seconds.push_back(ThreadSeconds() - start);
        point.error = backprop.Compare(gradient, reference).Worst();
        point.steps_failed = gradient.work.failed_solves;
      }
      point.seconds = MedianOfRuns(std::move(seconds));
      points.push_back(point);
    }
  }
  return points;
}

}  // namespace clothid
