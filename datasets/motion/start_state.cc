#include "datasets/motion/start_state.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "datasets/motion/shape_problem.h"
#include "sim/contact/pair_geometry.h"
#include "sim/contact/self_contact_search.h"

namespace clothid {
namespace {

constexpr double kStrain = 0.02;  // e
// The grid of bending weights, relative to the data's per node.
constexpr double kBendingWeights[] = {1e-8, 1e-4, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0};
// What the data may be missed by: the median of chi-square with three degrees of freedom, less what a shape that
// follows them takes away, and its upper tenth, with room for points that are off.
constexpr double kMedianMisfit = 0.9 * 2.366;
constexpr double kUpperMisfit = 1.5 * 6.251;
constexpr double kOff = 30.0;                 // one in a million
constexpr double kVelocityBending = 1.0;      // likewise, of velocities
constexpr double kPenetrationWeight = 100.0;  // relative to the data's per node
constexpr int kMaxIterations = 50;
constexpr int kMaxHalvings = 30;
constexpr double kSmallDecrease = 1e-9;  // of the objective
constexpr int kMaxProjections = 50;
constexpr double kClearance = 1e-9;  // relative to the cloth's size: rounding does not put a node back inside

// Newton's method with a line search, from and to `positions`. Ends where it gains no more.
void Minimize(const ShapeWeights& weights, ShapeProblem* problem, Eigen::VectorXd* positions) {
  Eigen::VectorXd gradient;
  double objective = problem->Objective(weights, *positions, &gradient);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Eigen::VectorXd step = problem->Step(weights, *positions, gradient);
    if (step.size() == 0 || !step.allFinite()) return;
    const Eigen::VectorXd full = problem->model().ScatterColumns(step);
    double length = 1.0, trial_objective = objective;
    Eigen::VectorXd trial;
    for (int halving = 0; halving < kMaxHalvings; ++halving, length *= 0.5) {
      trial = *positions + length * full;
      trial_objective = problem->Objective(weights, trial, nullptr);
      if (trial_objective < objective) break;
    }
    if (!(trial_objective < objective)) return;
    const bool is_last = objective - trial_objective <= kSmallDecrease * objective;
    *positions = trial;
    if (is_last) return;
    objective = problem->Objective(weights, *positions, &gradient);
  }
}

// Moves free nodes out of the obstacles, each along its own normal.
void Project(const ShapeProblem& problem, double clearance, Eigen::VectorXd* positions) {
  for (const int node : problem.model().free_nodes()) {
    for (int i = 0; i < kMaxProjections; ++i) {
      const SurfacePoint surface = problem.Nearest(positions->segment<3>(3 * node));
      if (!(surface.gap < 0.0)) break;
      positions->segment<3>(3 * node) += (clearance - surface.gap) * surface.normal;
    }
  }
}

std::ptrdiff_t NumOff(const std::vector<double>& misfits) {
  return misfits.end() - std::upper_bound(misfits.begin(), misfits.end(), kOff);
}

// Whether ascending misfits are those of noise, but for as many that are off as there are without bending.
bool IsNoise(const std::vector<double>& misfits, std::ptrdiff_t num_off) {
  return misfits[misfits.size() / 2] <= kMedianMisfit && misfits[misfits.size() * 9 / 10] <= kUpperMisfit &&
         NumOff(misfits) <= num_off;
}

// Where every node is a point: free nodes at what their points show, where they show anything.
void MoveToPoints(const ClothModel& model, const std::vector<ObservedPoint>& points, const FrameTrend& trend,
                  Eigen::VectorXd* positions) {
  if (static_cast<int>(points.size()) != model.num_nodes()) return;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const Eigen::Vector3d position = trend.positions.col(static_cast<Eigen::Index>(p));
    const int node = points[p].nodes[0];
    if (points[p].num_nodes == 1 && model.free_index()[node] >= 0 && position.allFinite()) {
      positions->segment<3>(3 * node) = position;
    }
  }
}

constexpr int kMaxPushes = 200;
constexpr double kLayerTolerance = 1e-3;  // of the thickness

// How much nearer than `thickness` a pair was, m.
double PushApart(const PairFeatures& pair, const std::vector<bool>& is_held, double thickness,
                 Eigen::VectorXd* positions) {
  const PairGeometry geometry = EvaluatePair(pair, *positions);
  const double missing = thickness - geometry.distance;
  double square = 0.0;
  for (int i = 0; i < pair.num_nodes(); ++i) {
    if (!is_held[pair.nodes[i]]) square += geometry.weights[i] * geometry.weights[i];
  }
  if (!(missing > 0.0) || !(square > 0.0)) return 0.0;
  for (int i = 0; i < pair.num_nodes(); ++i) {
    if (is_held[pair.nodes[i]]) continue;
    positions->segment<3>(3 * pair.nodes[i]) += missing / square * geometry.weights[i] * geometry.normal;
  }
  return missing;
}

// Moves the free nodes of `positions` [3N] m along the normals of pairs that are nearer than the thickness
// (sim/contact/self_contact.h), as little as may be and one pair after the other, until none is nearer by more than a
// thousandth of it: a simulation would throw such layers apart, and without friction while they fly. Layers that have
// passed through each other stay so. Nothing without self-contact.
void KeepLayersApart(const Scene& scene, Eigen::VectorXd* positions) {
  if (!scene.self_contact) return;
  const double thickness = scene.self_contact->thickness;
  std::vector<bool> is_held(static_cast<std::size_t>(scene.mesh.num_nodes()), false);
  for (const int node : scene.handles.nodes) is_held[node] = true;
  SelfContactSearch search(scene.mesh, thickness);
  const Eigen::VectorXd at_rest = Eigen::VectorXd::Zero(positions->size());
  std::vector<PairFeatures> pairs;
  for (int sweep = 0; sweep < kMaxPushes; ++sweep) {
    search.Find(*positions, at_rest, 0.0, 0.0, &pairs);
    double worst = 0.0;
    for (const PairFeatures& pair : pairs) worst = std::max(worst, PushApart(pair, is_held, thickness, positions));
    if (worst <= kLayerTolerance * thickness) return;
  }
}

double MeanArea(const Mesh& mesh) { return TriangleAreas(mesh).mean(); }

}  // namespace

Eigen::VectorXd SmoothStartPositions(const Scene& scene, const std::vector<ObservedPoint>& points,
                                     const FrameTrend& trend) {
  Eigen::VectorXd positions = scene.initial_positions;
  ShapeProblem problem(scene, {&points, trend.positions, trend.position_variances.cwiseInverse(), true});
  if (problem.model().num_free() == 0 || !(problem.data_weight() > 0.0)) return positions;
  MoveToPoints(problem.model(), points, trend, &positions);
  ShapeWeights weights;
  weights.stretch = 1.0 / (kStrain * kStrain * MeanArea(scene.mesh));
  weights.penetration = kPenetrationWeight * (problem.data_weight() + weights.stretch);
  std::ptrdiff_t num_off = 0;
  for (const double share : kBendingWeights) {
    weights.bending = problem.BendingWeight(share);
    Eigen::VectorXd smoother = positions;
    Minimize(weights, &problem, &smoother);
    const std::vector<double> misfits = problem.Misfits(smoother);
    if (share == kBendingWeights[0]) {
      num_off = NumOff(misfits);
    } else if (!IsNoise(misfits, num_off)) {
      break;
    }
    positions = smoother;
  }
  KeepLayersApart(scene, &positions);
  Project(problem, kClearance * ClothSize(scene.mesh), &positions);
  return positions;
}

Eigen::VectorXd SmoothStartVelocities(const Scene& scene, const std::vector<ObservedPoint>& points,
                                      const FrameTrend& trend) {
  Eigen::VectorXd velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
  if (trend.velocities.size() == 0) return velocities;
  const HandlePath& path = scene.handles.path;
  if (path.num_handles() > 0) {
    const double step = scene.time_step;
    const Eigen::VectorXd own = (path.At(scene.start_time + step) - path.At(scene.start_time)) / step;
    for (std::size_t i = 0; i < scene.handles.nodes.size(); ++i) {
      velocities.segment<3>(3 * scene.handles.nodes[i]) = own.segment<3>(3 * static_cast<Eigen::Index>(i));
    }
  }
  ShapeProblem problem(scene, {&points, trend.velocities, trend.velocity_variances.cwiseInverse(), false});
  if (problem.model().num_free() == 0 || !(problem.data_weight() > 0.0)) return velocities;
  ShapeWeights weights;
  weights.bending = problem.BendingWeight(kVelocityBending);
  Eigen::VectorXd gradient;
  problem.Objective(weights, velocities, &gradient);
  const Eigen::VectorXd step = problem.Step(weights, velocities, gradient);
  if (step.size() > 0 && step.allFinite()) velocities += problem.model().ScatterColumns(step);
  return velocities;
}

}  // namespace clothid
