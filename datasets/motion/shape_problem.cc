#include "datasets/motion/shape_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace clothid {
namespace {

constexpr double kCauchyScale = 3.0;  // of the Cauchy loss, in standard deviations

// The scene's cloth with bending and without air: energies, the order of its free nodes.
Scene ShapeScene(const Scene& scene) {
  Scene shape;
  shape.mesh = scene.mesh;
  shape.initial_positions = scene.initial_positions;
  shape.initial_velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
  shape.start_time = scene.start_time;
  shape.handles.nodes = scene.handles.nodes;
  shape.handles.path = scene.handles.path;
  shape.obstacles = scene.obstacles;
  shape.material.bending_stiffness = 1.0;
  shape.bending.law = scene.bending.law;
  shape.bending.is_flat_at_rest = true;
  shape.material.drag = 0.0;
  shape.material.damping = 0.0;
  return shape;
}

Eigen::Vector3d PointAt(const ObservedPoint& point, const Eigen::VectorXd& positions) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int k = 0; k < point.num_nodes; ++k) sum += point.weights[k] * positions.segment<3>(3 * point.nodes[k]);
  return sum;
}

}  // namespace

ShapeProblem::ShapeProblem(const Scene& scene, ShapeTargets targets)
    : scene_(ShapeScene(scene)),
      surfaces_(scene_, scene_.start_time),
      targets_(std::move(targets)),
      model_(scene_),
      solver_(model_.pattern()) {
  double sum = 0.0;
  for (Eigen::Index p = 0; p < targets_.weights.size(); ++p) {
    if (targets_.values.col(p).allFinite()) sum += targets_.weights[p];
  }
  data_weight_ = sum / model_.num_nodes();
  bending_diagonal_ = model_.bending()->diagonal().mean();
}

std::vector<double> ShapeProblem::Misfits(const Eigen::VectorXd& positions) const {
  std::vector<double> misfits;
  for (std::size_t p = 0; p < targets_.points->size(); ++p) {
    const double squared = Misfit(p, positions).squaredNorm();
    if (std::isfinite(squared)) misfits.push_back(targets_.weights[static_cast<Eigen::Index>(p)] * squared);
  }
  std::sort(misfits.begin(), misfits.end());
  return misfits;
}

void ShapeProblem::AddPenetrationForces(double weight, const Eigen::VectorXd& positions, Eigen::VectorXd* force,
                                        double* energy) const {
  for (const int node : model_.free_nodes()) {
    const SurfacePoint surface = Nearest(positions.segment<3>(3 * node));
    if (!(surface.gap < 0.0)) continue;
    *energy += 0.5 * weight * surface.gap * surface.gap;
    force->segment<3>(3 * node) -= weight * surface.gap * surface.normal;
  }
}

double ShapeProblem::Objective(const ShapeWeights& weights, const Eigen::VectorXd& positions,
                               Eigen::VectorXd* gradient) const {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(positions.size());
  double sum = 0.0;
  if (weights.stretch > 0.0) sum += weights.stretch * model_.stretch().AddForce(weights.stretch, positions, &force);
  sum += weights.bending * model_.bending()->AddForce(weights.bending, positions, &force);
  for (std::size_t p = 0; p < targets_.points->size(); ++p) {
    const Eigen::Vector3d misfit = Misfit(p, positions);
    if (!misfit.allFinite()) continue;
    const double weight = targets_.weights[static_cast<Eigen::Index>(p)];
    const double ratio = weight * misfit.squaredNorm() / (kCauchyScale * kCauchyScale);
    sum += 0.5 * (targets_.is_robust ? kCauchyScale * kCauchyScale * std::log1p(ratio) : weight * misfit.squaredNorm());
    const ObservedPoint& point = (*targets_.points)[p];
    for (int k = 0; k < point.num_nodes; ++k) {
      force.segment<3>(3 * point.nodes[k]) -= point.weights[k] * LossWeight(weight, misfit) * misfit;
    }
  }
  if (weights.penetration > 0.0) AddPenetrationForces(weights.penetration, positions, &force, &sum);
  if (gradient != nullptr) *gradient = -force;
  return sum;
}

Eigen::VectorXd ShapeProblem::Step(const ShapeWeights& weights, const Eigen::VectorXd& positions,
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

SurfacePoint ShapeProblem::Nearest(const Eigen::Vector3d& position) const { return surfaces_.Nearest(position); }

Eigen::Vector3d ShapeProblem::Misfit(std::size_t p, const Eigen::VectorXd& positions) const {
  return PointAt((*targets_.points)[p], positions) - targets_.values.col(static_cast<Eigen::Index>(p));
}

double ShapeProblem::LossWeight(double weight, const Eigen::Vector3d& misfit) const {
  if (!targets_.is_robust) return weight;
  return weight / (1.0 + weight * misfit.squaredNorm() / (kCauchyScale * kCauchyScale));
}

void ShapeProblem::AddTargets(const Eigen::VectorXd& positions, BlockMatrix* hessian) const {
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

void ShapeProblem::AddPenetrations(double weight, const Eigen::VectorXd& positions, BlockMatrix* hessian) const {
  for (int i = 0; i < model_.num_free(); ++i) {
    const SurfacePoint surface = Nearest(positions.segment<3>(3 * model_.free_nodes()[i]));
    if (!(surface.gap < 0.0)) continue;
    hessian->block(model_.pattern()->Diagonal(i)) += weight * surface.normal * surface.normal.transpose();
  }
}

}  // namespace clothid
