#include "datasets/motion/start_state.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "sim/cloth/cloth_model.h"
#include "sim/matrix/cholesky.h"

namespace clothid {
namespace {

constexpr double kStrain = 0.02;    // e
constexpr double kLossScale = 3.0;  // of the Cauchy loss, in standard deviations
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

// The scene's cloth with bending and without air: energies, the order of its free nodes.
Scene ShapeScene(const Scene& scene) {
  Scene shape;
  shape.mesh = scene.mesh;
  shape.initial_positions = scene.initial_positions;
  shape.initial_velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
  shape.handles = scene.handles;
  shape.obstacles = scene.obstacles;
  shape.material.bending_stiffness = 1.0;
  shape.material.drag = 0.0;
  shape.material.damping = 0.0;
  return shape;
}

Eigen::Vector3d PointAt(const ObservedPoint& point, const Eigen::VectorXd& positions) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int k = 0; k < point.num_nodes; ++k) sum += point.weights[k] * positions.segment<3>(3 * point.nodes[k]);
  return sum;
}

// What a shape is to follow.
struct Targets {
  const std::vector<ObservedPoint>* points = nullptr;
  Eigen::MatrixXd values;   // [3 x P], NaN: none
  Eigen::VectorXd weights;  // [P]
  bool is_robust = false;
};

struct EnergyWeights {
  double stretch = 0.0, bending = 0.0, penetration = 0.0;
};

// The objective over the free nodes, its gradient and a positive semidefinite Hessian.
class ShapeProblem {
 public:
  ShapeProblem(const Scene& scene, Targets targets)
      : scene_(ShapeScene(scene)), targets_(std::move(targets)), model_(scene_), solver_(model_.pattern()) {
    double sum = 0.0;
    for (Eigen::Index p = 0; p < targets_.weights.size(); ++p) {
      if (targets_.values.col(p).allFinite()) sum += targets_.weights[p];
    }
    data_weight_ = sum / model_.num_nodes();
    bending_diagonal_ = model_.bending()->diagonal().mean();
  }

  const ClothModel& model() const { return model_; }
  double data_weight() const { return data_weight_; }  // per node
  // The bending weight that counts as much as the data times `share`.
  double BendingWeight(double share) const {
    return bending_diagonal_ > 0.0 ? share * data_weight_ / bending_diagonal_ : 0.0;
  }

  // The misfits w_p |x_p - y_p|^2 of the targets, ascending.
  std::vector<double> Misfits(const Eigen::VectorXd& positions) const {
    std::vector<double> misfits;
    for (std::size_t p = 0; p < targets_.points->size(); ++p) {
      const double squared = Misfit(p, positions).squaredNorm();
      if (std::isfinite(squared)) misfits.push_back(targets_.weights[static_cast<Eigen::Index>(p)] * squared);
    }
    std::sort(misfits.begin(), misfits.end());
    return misfits;
  }

  // `gradient` [3N] may be null.
  double Objective(const EnergyWeights& weights, const Eigen::VectorXd& positions, Eigen::VectorXd* gradient) const {
    Eigen::VectorXd force = Eigen::VectorXd::Zero(positions.size());
    double sum = 0.0;
    if (weights.stretch > 0.0) sum += weights.stretch * model_.stretch().AddForce(weights.stretch, positions, &force);
    sum += weights.bending * model_.bending()->AddForce(weights.bending, positions, &force);
    for (std::size_t p = 0; p < targets_.points->size(); ++p) {
      const Eigen::Vector3d misfit = Misfit(p, positions);
      if (!misfit.allFinite()) continue;
      const double weight = targets_.weights[static_cast<Eigen::Index>(p)];
      const double ratio = weight * misfit.squaredNorm() / (kLossScale * kLossScale);
      sum += 0.5 * (targets_.is_robust ? kLossScale * kLossScale * std::log1p(ratio) : weight * misfit.squaredNorm());
      const ObservedPoint& point = (*targets_.points)[p];
      for (int k = 0; k < point.num_nodes; ++k) {
        force.segment<3>(3 * point.nodes[k]) -= point.weights[k] * LossWeight(weight, misfit) * misfit;
      }
    }
    if (weights.penetration > 0.0) {
      for (const int node : model_.free_nodes()) {
        const SurfacePoint surface = Nearest(positions.segment<3>(3 * node));
        if (!(surface.gap < 0.0)) continue;
        sum += 0.5 * weights.penetration * surface.gap * surface.gap;
        force.segment<3>(3 * node) -= weights.penetration * surface.gap * surface.normal;
      }
    }
    if (gradient != nullptr) *gradient = -force;
    return sum;
  }

  // -Hessian^-1 gradient over the free nodes [3 Nf]; empty where the Hessian is singular.
  Eigen::VectorXd Step(const EnergyWeights& weights, const Eigen::VectorXd& positions,
                       const Eigen::VectorXd& gradient) {
    BlockMatrix hessian(model_.pattern());
    if (weights.stretch > 0.0) {
      model_.stretch().AddHessian(weights.stretch, HessianKind::kClamped, positions, &hessian);
    }
    model_.bending()->AddHessian(weights.bending, &hessian);
    hessian.CompleteFromLower();
    AddTargets(positions, &hessian);
    if (weights.penetration > 0.0) AddPenetrations(weights.penetration, positions, &hessian);
    const auto factor = solver_.Factor(hessian.values);
    if (factor == nullptr) return {};
    Eigen::MatrixXd step;
    factor->Solve(-model_.Gather(gradient), &step);
    return step;
  }

  // Signed distance to what is nearest, from its contact distance; positive infinity without obstacles.
  SurfacePoint Nearest(const Eigen::Vector3d& position) const {
    SurfacePoint nearest;
    nearest.gap = std::numeric_limits<double>::infinity();
    for (const SceneObstacle& obstacle : scene_.obstacles) {
      SurfacePoint surface = obstacle.shape->Closest(position);
      surface.gap -= obstacle.contact_distance;
      if (surface.gap < nearest.gap) nearest = surface;
    }
    return nearest;
  }

 private:
  Eigen::Vector3d Misfit(std::size_t p, const Eigen::VectorXd& positions) const {
    return PointAt((*targets_.points)[p], positions) - targets_.values.col(static_cast<Eigen::Index>(p));
  }
  double LossWeight(double weight, const Eigen::Vector3d& misfit) const {
    if (!targets_.is_robust) return weight;
    return weight / (1.0 + weight * misfit.squaredNorm() / (kLossScale * kLossScale));
  }
  void AddTargets(const Eigen::VectorXd& positions, BlockMatrix* hessian) const {
    const std::vector<int>& free_index = model_.free_index();
    for (std::size_t p = 0; p < targets_.points->size(); ++p) {
      const Eigen::Vector3d misfit = Misfit(p, positions);
      if (!misfit.allFinite()) continue;
      const ObservedPoint& point = (*targets_.points)[p];
      const double weight = LossWeight(targets_.weights[static_cast<Eigen::Index>(p)], misfit);
      for (int i = 0; i < point.num_nodes; ++i) {
        for (int j = 0; j < point.num_nodes; ++j) {
          const int row = free_index[point.nodes[i]], column = free_index[point.nodes[j]];
          if (row < 0 || column < 0) continue;
          hessian->block(model_.pattern()->Find(row, column)).diagonal().array() +=
              weight * point.weights[i] * point.weights[j];
        }
      }
    }
  }
  void AddPenetrations(double weight, const Eigen::VectorXd& positions, BlockMatrix* hessian) const {
    for (int i = 0; i < model_.num_free(); ++i) {
      const SurfacePoint surface = Nearest(positions.segment<3>(3 * model_.free_nodes()[i]));
      if (!(surface.gap < 0.0)) continue;
      hessian->block(model_.pattern()->Diagonal(i)) += weight * surface.normal * surface.normal.transpose();
    }
  }

  Scene scene_;
  Targets targets_;
  ClothModel model_;
  CholeskySolver solver_;
  double data_weight_ = 0.0;
  double bending_diagonal_ = 0.0;
};

// Newton's method with a line search, from and to `positions`. Ends where it gains no more.
void Minimize(const EnergyWeights& weights, ShapeProblem* problem, Eigen::VectorXd* positions) {
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

double MeanArea(const Mesh& mesh) { return TriangleAreas(mesh).mean(); }

}  // namespace

Eigen::VectorXd SmoothStartPositions(const Scene& scene, const std::vector<ObservedPoint>& points,
                                     const FrameTrend& trend) {
  Eigen::VectorXd positions = scene.initial_positions;
  ShapeProblem problem(scene, {&points, trend.positions, trend.position_variances.cwiseInverse(), true});
  if (problem.model().num_free() == 0 || !(problem.data_weight() > 0.0)) return positions;
  MoveToPoints(problem.model(), points, trend, &positions);
  EnergyWeights weights;
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
  EnergyWeights weights;
  weights.bending = problem.BendingWeight(kVelocityBending);
  Eigen::VectorXd gradient;
  problem.Objective(weights, velocities, &gradient);
  const Eigen::VectorXd step = problem.Step(weights, velocities, gradient);
  if (step.size() > 0 && step.allFinite()) velocities += problem.model().ScatterColumns(step);
  return velocities;
}

}  // namespace clothid
