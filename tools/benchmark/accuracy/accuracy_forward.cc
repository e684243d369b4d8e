#include "tools/benchmark/accuracy/accuracy_forward.h"

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "datasets/synthetic/regrid.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "tools/benchmark/base/integrators.h"
#include "tools/benchmark/base/timing.h"

namespace clothid {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kEnoughSeconds = 0.5;  // of rollouts, for a median that stands

struct Trajectory {
  Mesh mesh;
  Eigen::MatrixXd frames;  // [3N x frames] m, the start first; empty where a step failed
  double seconds = 0.0;    // processor time; NaN where a step failed
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
  bool is_ok = true;
  while (is_ok && static_cast<int>(seconds.size()) < repeats &&
         std::accumulate(seconds.begin(), seconds.end(), 0.0) < kEnoughSeconds) {
    const double start = ThreadSeconds();
    const Rollout rollout = Simulate(parameters, (num_frames - 1) * divisor, &simulator, nullptr, options);
    seconds.push_back(ThreadSeconds() - start);
    trajectory.failed_steps = rollout.counts.failed_steps;
    is_ok = rollout.ok();
  }
  trajectory.seconds = is_ok ? Median(std::move(seconds)) : kNaN;
  if (!is_ok) trajectory.frames.resize(0, 0);
  return trajectory;
}

// Of frames of the same points; NaN where one of the rollouts failed.
double TrajectoryError(const Eigen::MatrixXd& frames, const Eigen::MatrixXd& reference) {
  if (frames.size() == 0 || reference.size() == 0) return kNaN;
  return (frames - reference).norm() / (reference.colwise() - reference.col(0)).norm();
}

void Fill(const Trajectory& trajectory, double tolerance, double error, AccuracyPoint* point) {
  point->threshold = tolerance;
  point->error = error;
  point->seconds = trajectory.seconds;
  point->steps_failed = trajectory.failed_steps;
}

// At the nodes of `mesh`, which lie on that of the trajectory.
Eigen::MatrixXd FramesAtNodes(const Trajectory& trajectory, const Mesh& mesh) {
  if (trajectory.frames.size() == 0) return {};
  return Interpolate(PlaceOnMesh(trajectory.mesh, mesh.rest_positions), trajectory.frames);
}

void Append(const std::vector<AccuracyPoint>& more, std::vector<AccuracyPoint>* points) {
  points->insert(points->end(), more.begin(), more.end());
}

}  // namespace

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
        Fill(trajectory, tolerance, TrajectoryError(trajectory.frames, reference.frames), &point);
        same_mesh.push_back(point);
        if (tolerance != kMeshTolerance) continue;
        point.reference = "finest/64";
        point.error = TrajectoryError(trajectory.frames, finest);
        finest_mesh.push_back(point);
      }
    }
  }
  Append(finest_mesh, &same_mesh);
  return same_mesh;
}

std::vector<AccuracyPoint> MeasureStepTolerances(const AccuracyCase& accuracy_case, int nodes, int repeats) {
  const Trajectory reference = SimulateFrames(accuracy_case, Integrator::kEuler, nodes, 1, kTightTolerance, 1);
  std::vector<AccuracyPoint> points;
  for (const double tolerance : kStepTolerances) {
    const Trajectory trajectory = SimulateFrames(accuracy_case, Integrator::kEuler, nodes, 1, tolerance, repeats);
    AccuracyPoint point = accuracy_case.MakePoint("forward", "tolerance_1e-12", "step_tolerance", nodes);
    Fill(trajectory, tolerance, TrajectoryError(trajectory.frames, reference.frames), &point);
    points.push_back(point);
  }
  return points;
}

std::vector<AccuracyPoint> MeasureMeshes(const AccuracyCase& accuracy_case, int nodes, int repeats) {
  const int cells = nodes - 1;
  const Mesh shared = accuracy_case.MakeScene(cells / 4 + 1).mesh;
  const Eigen::MatrixXd reference =
      FramesAtNodes(SimulateFrames(accuracy_case, Integrator::kEuler, 2 * cells + 1, 1, kMeshTolerance, 1), shared);
  std::vector<AccuracyPoint> points;
  for (const int coarser : {4, 2, 1}) {
    const Trajectory trajectory =
        SimulateFrames(accuracy_case, Integrator::kEuler, cells / coarser + 1, 1, kMeshTolerance, repeats);
    AccuracyPoint point = accuracy_case.MakePoint("forward", "finest_mesh", "mesh", cells / coarser + 1);
    Fill(trajectory, kMeshTolerance, TrajectoryError(FramesAtNodes(trajectory, shared), reference), &point);
    points.push_back(point);
  }
  return points;
}

std::vector<AccuracyPoint> MeasureForward(const AccuracyCase& accuracy_case,
                                          const std::vector<std::string>& integrators, int nodes, int repeats) {
  std::vector<AccuracyPoint> points = MeasureTimeSteps(accuracy_case, integrators, nodes, repeats);
  Append(MeasureStepTolerances(accuracy_case, nodes, repeats), &points);
  Append(MeasureMeshes(accuracy_case, nodes, repeats), &points);
  return points;
}

}  // namespace clothid
