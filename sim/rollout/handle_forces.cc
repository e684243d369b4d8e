#include "sim/rollout/handle_forces.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <string>

#include "sim/base/error.h"
#include "sim/cloth/field_terms.h"
#include "sim/matrix/block_product.h"
#include "sim/scene/material_field.h"
#include "sim/scene/warp.h"

namespace clothid {
namespace {

constexpr std::array<double, 3> kCurvature = {1.0, -2.0, 1.0};  // of a, 1/h^2
// Of v, 1/h: of the parabola through the window, at its steps; and of a step of backward Euler.
constexpr std::array<std::array<double, 3>, 3> kParabola = {{{-1.5, 2.0, -0.5}, {-0.5, 0.0, 0.5}, {0.5, -2.0, 1.5}}};
constexpr std::array<double, 3> kLastStep = {0.0, -1.0, 1.0};

std::array<double, 3> Scaled(std::array<double, 3> weights, double factor) {
  for (double& weight : weights) weight *= factor;
  return weights;
}

// What the factors of a field of `kind` are; nothing where there is none.
const Eigen::VectorXd* LogFactors(const Parameters& parameters, ParameterKind kind) {
  if (parameters.fields == nullptr) return nullptr;
  for (const FieldFactors& field : *parameters.fields) {
    if (field.kind == kind) return &field.log_factors;
  }
  return nullptr;
}

}  // namespace

ForceWindow WindowOfForce(int step, int num_steps, Integrator integrator, double time_step) {
  const bool is_euler = integrator == Integrator::kEuler;
  ForceWindow window;
  window.first_step = std::clamp(is_euler ? step - 2 : step - 1, 0, num_steps - kFewestForceSteps);
  window.place = step - window.first_step;
  const std::array<double, 3>& rates =
      is_euler && window.place == 2 ? kLastStep : kParabola[static_cast<std::size_t>(window.place)];
  window.rates = Scaled(rates, 1.0 / time_step);
  return window;
}

HandleForces::HandleForces(const ClothModel& model, const Parameters& parameters, int num_steps,
                           const std::vector<std::vector<int>>& groups)
    : model_(model),
      material_(parameters.material),
      wind_(parameters.wind),
      num_steps_(num_steps),
      time_step_(model.scene().time_step),
      groups_(groups) {
  if (model.directional_drag() != nullptr) {
    throw Error(ErrorKind::kBadData, "forces at handles: expected a scene without drag_normal and drag_tangential");
  }
  for (const BendingTerm& term : model.bending_terms()) {
    if (term.curvature == nullptr) continue;
    throw Error(ErrorKind::kBadData, "forces at handles: expected a cloth that is flat at rest");
  }
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (groups[g].empty()) throw Error(ErrorKind::kBadData, "group " + std::to_string(g) + " of handles: has no node");
    for (const int node : groups[g]) {
      const bool is_handle = node >= 0 && node < model.num_nodes() && model.free_index()[node] < 0;
      if (!is_handle) {
        throw Error(ErrorKind::kBadData,
                    "group " + std::to_string(g) + " of handles: node " + std::to_string(node) + " is no handle");
      }
      const double drag_area = model.drag() != nullptr ? model.drag()->areas()[node] : 0.0;
      handles_.push_back(
          {static_cast<int>(g), node, -1, model.mass_areas()[node], model.mass(material_, node), drag_area});
    }
  }
  FindNodes(groups);
  MakeTriangles(parameters);
  MakeBending();
}

// The corners of the triangles at handles, and what bending couples handles with.
void HandleForces::FindNodes(const std::vector<std::vector<int>>& groups) {
  const Mesh& mesh = model_.scene().mesh;
  std::vector<bool> is_held(static_cast<std::size_t>(mesh.num_nodes())), is_near = is_held;
  for (const std::vector<int>& group : groups) {
    for (const int node : group) is_held[node] = is_near[node] = true;
  }
  for (int f = 0; f < mesh.num_faces(); ++f) {
    const Eigen::Vector3i corners = mesh.faces.col(f);
    if (!is_held[corners[0]] && !is_held[corners[1]] && !is_held[corners[2]]) continue;
    faces_.push_back(f);
    for (const int node : corners) is_near[node] = true;
  }
  for (const BendingTerm& term : model_.bending_terms()) {
    const Eigen::SparseMatrix<double>& matrix = term.energy.matrix();
    for (const Handle& handle : handles_) {
      for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, handle.node); it; ++it) is_near[it.row()] = true;
    }
  }
  local_.assign(is_near.size(), -1);
  for (int node = 0; node < mesh.num_nodes(); ++node) {
    if (!is_near[node]) continue;
    local_[node] = static_cast<int>(nodes_.size());
    nodes_.push_back(node);
  }
  selection_ = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(nodes_.size()), 3 * num_groups());
  for (Handle& handle : handles_) {
    handle.local = local_[handle.node];
    selection_.block<3, 3>(3 * handle.local, 3 * handle.group) += Eigen::Matrix3d::Identity();
  }
}

void HandleForces::MakeTriangles(const Parameters& parameters) {
  const Scene& scene = model_.scene();
  Mesh mesh;
  mesh.rest_positions = scene.mesh.rest_positions(Eigen::all, nodes_);
  mesh.faces = scene.mesh.faces(Eigen::all, faces_);
  for (int& node : mesh.faces.reshaped()) node = local_[node];
  std::vector<std::vector<int>> neighbours(nodes_.size());
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        if (i != j) neighbours[mesh.faces(i, f)].push_back(mesh.faces(j, f));
      }
    }
  }
  pattern_ = std::make_shared<const BlockPattern>(neighbours);
  std::vector<int> index(nodes_.size());
  std::iota(index.begin(), index.end(), 0);
  Eigen::Matrix3Xd warp;
  const bool has_axes = scene.membrane == MembraneLaw::kOrthotropic;
  if (has_axes) warp = WarpDirections(scene.warp, scene.mesh)(Eigen::all, faces_);
  std::shared_ptr<const TriangleElements> triangles = std::make_shared<const TriangleElements>(
      MakeTriangleElements(mesh, index, *pattern_, has_axes ? &warp : nullptr));
  if (model_.damping() != nullptr) damping_.emplace(triangles);
  if (const Eigen::VectorXd* factors = LogFactors(parameters, ParameterKind::kStretchStiffness)) {
    triangles = WeightedTriangles(*triangles, (*factors)(faces_).array().exp());
  }
  membrane_.emplace(scene.membrane, triangles);
}

void HandleForces::MakeBending() {
  for (const BendingTerm& term : model_.bending_terms()) {
    std::vector<Eigen::Triplet<double>> entries;
    for (const Handle& handle : handles_) {
      // Q is symmetric.
      for (Eigen::SparseMatrix<double>::InnerIterator it(term.energy.matrix(), handle.node); it; ++it) {
        entries.emplace_back(handle.group, local_[it.row()], it.value());
      }
    }
    Bending bending{term.kind, term.stiffness(material_), {num_groups(), static_cast<Eigen::Index>(nodes_.size())}};
    bending.rows.setFromTriplets(entries.begin(), entries.end());
    bending_.push_back(std::move(bending));
  }
}

Eigen::MatrixXd HandleForces::Gather(const Eigen::Ref<const Eigen::MatrixXd>& all) const {
  Eigen::MatrixXd near(3 * static_cast<Eigen::Index>(nodes_.size()), all.cols());
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    near.middleRows<3>(3 * static_cast<Eigen::Index>(i)) = all.middleRows<3>(3 * nodes_[i]);
  }
  return near;
}

ForceWindow HandleForces::Window(int step) const {
  return WindowOfForce(step, num_steps_, model_.scene().integrator, time_step_);
}

Eigen::Vector3d HandleForces::Derivative(const std::array<double, 3>& weights, const Handle& handle,
                                         const States& states) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k) sum += weights[k] * states[k].col(0).segment<3>(3 * handle.local);
  return sum;
}

Eigen::Vector3d HandleForces::Acceleration(const Handle& handle, const States& states) const {
  return Derivative(Scaled(kCurvature, 1.0 / (time_step_ * time_step_)), handle, states);
}

Eigen::Vector3d HandleForces::AirSpeed(int step, const Handle& handle, const States& states) const {
  const double time = model_.scene().start_time + step * time_step_;
  return Derivative(Window(step).rates, handle, states) - model_.drag()->WindAt(handle.node, time, wind_);
}

std::array<double, 3> HandleForces::MetricShares(const ForceWindow& window) const {
  std::array<double, 3> shares = Scaled(window.rates, -time_step_);
  shares[static_cast<std::size_t>(window.place)] += 1.0;
  return shares;
}

std::vector<MetricBatch> HandleForces::StartMetrics(const ForceWindow& window, const States& states) const {
  const std::array<double, 3> shares = MetricShares(window);
  std::vector<MetricBatch> sum, one;
  for (std::size_t k = 0; k < 3; ++k) {
    damping_->SetMetrics(states[k].col(0), &one);
    if (k == 0) sum.assign(one.size(), MetricBatch{});
    for (std::size_t b = 0; b < one.size(); ++b) {
      for (int i = 0; i < 3; ++i) {
        for (int lane = 0; lane < kLanes; ++lane) {
          sum[b].values[i][lane] += shares[k] * one[b].values[i][lane];
        }
      }
    }
  }
  return sum;
}

void HandleForces::SubtractSums(const Eigen::VectorXd& force, Eigen::VectorXd* sums) const {
  for (const Handle& handle : handles_) sums->segment<3>(3 * handle.group) -= force.segment<3>(3 * handle.local);
}

Eigen::VectorXd HandleForces::At(int step, const States& states) const {
  const ForceWindow window = Window(step);
  const Eigen::VectorXd positions = states[static_cast<std::size_t>(window.place)].col(0);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(positions.size());
  membrane_->AddForce(material_, positions, &force);
  if (damping_) {
    damping_->AddForce(material_.damping, time_step_, StartMetrics(window, states), positions, &force);
  }
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(3 * num_groups());
  SubtractSums(force, &sums);
  for (const Bending& bending : bending_) {
    sums.reshaped(3, num_groups()) +=
        bending.stiffness * (positions.reshaped(3, positions.size() / 3) * bending.rows.transpose());
  }
  const Scene& scene = model_.scene();
  for (const Handle& handle : handles_) {
    auto sum = sums.segment<3>(3 * handle.group);
    sum += handle.inertia * Acceleration(handle, states) - material_.density * handle.mass_area * scene.gravity -
           scene.node_force;
    if (model_.drag() != nullptr) sum += AirSlope(handle, 1.0) * AirSpeed(step, handle, states);
  }
  return sums;
}

std::array<Eigen::MatrixXd, 3> HandleForces::Jacobian(int step, const States& states) const {
  const ForceWindow window = Window(step);
  const auto place = static_cast<std::size_t>(window.place);
  const Eigen::VectorXd positions = states[place].col(0);
  BlockMatrix hessian(pattern_);
  membrane_->AddHessian(1.0, material_, HessianKind::kExact, positions, &hessian);
  std::array<Eigen::MatrixXd, 3> transposed;
  transposed.fill(Eigen::MatrixXd::Zero(selection_.rows(), selection_.cols()));
  if (damping_) {
    damping_->AddHessian(material_.damping, time_step_, HessianKind::kExact, StartMetrics(window, states), positions,
                         &hessian);
    const std::array<double, 3> shares = MetricShares(window);
    for (std::size_t k = 0; k < 3; ++k) {
      if (shares[k] == 0.0) continue;
      damping_->AddMixedProduct(shares[k] * material_.damping, time_step_, states[k].col(0), positions, selection_,
                                &transposed[k]);
    }
  }
  hessian.CompleteFromLower();
  transposed[place] += MultiplySymmetric(hessian, selection_);
  for (const Bending& bending : bending_) {
    for (int node = 0; node < bending.rows.outerSize(); ++node) {
      for (Eigen::SparseMatrix<double>::InnerIterator it(bending.rows, node); it; ++it) {
        transposed[place].block<3, 3>(3 * it.col(), 3 * it.row()).diagonal().array() += bending.stiffness * it.value();
      }
    }
  }
  for (std::size_t k = 0; k < 3; ++k) {
    for (const Handle& handle : handles_) {
      transposed[k].block<3, 3>(3 * handle.local, 3 * handle.group).diagonal().array() +=
          handle.inertia * kCurvature[k] / (time_step_ * time_step_) + AirSlope(handle, window.rates[k]);
    }
    transposed[k] = transposed[k].transpose().eval();
  }
  return transposed;
}

Eigen::VectorXd HandleForces::ParameterDerivative(ParameterId id, int step, const States& states) const {
  const ForceWindow window = Window(step);
  const Eigen::VectorXd positions = states[static_cast<std::size_t>(window.place)].col(0);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(positions.size());
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(3 * num_groups());
  switch (id.kind) {
    case ParameterKind::kFriction:
      break;
    case ParameterKind::kStretchStiffness:
    case ParameterKind::kWarpStiffness:
    case ParameterKind::kWeftStiffness:
    case ParameterKind::kShearStiffness:
    case ParameterKind::kPoissonStiffness:
      membrane_->AddForceDerivative(id.kind, 1.0, positions, &force);
      break;
    case ParameterKind::kBendingStiffness:
    case ParameterKind::kWarpBending:
    case ParameterKind::kWeftBending:
    case ParameterKind::kTwistBending:
      for (const Bending& bending : bending_) {
        if (bending.kind != id.kind) continue;
        sums.reshaped(3, num_groups()) += positions.reshaped(3, positions.size() / 3) * bending.rows.transpose();
      }
      break;
    case ParameterKind::kDensity:
      for (const Handle& handle : handles_) {
        sums.segment<3>(3 * handle.group) += handle.mass_area * (Acceleration(handle, states) - model_.scene().gravity);
      }
      break;
    case ParameterKind::kAddedMass:
      for (const Handle& handle : handles_) {
        sums.segment<3>(3 * handle.group) += model_.node_areas()[handle.node] * Acceleration(handle, states);
      }
      break;
    case ParameterKind::kNormalDrag:
    case ParameterKind::kTangentialDrag:
      break;  // the constructor refuses scenes that have them
    case ParameterKind::kWindX:
    case ParameterKind::kWindY:
    case ParameterKind::kWindZ:
    case ParameterKind::kGustX:
    case ParameterKind::kGustY:
    case ParameterKind::kGustZ:
    case ParameterKind::kGustFrequency:
    case ParameterKind::kGustPhase:
      for (const Handle& handle : handles_) {
        if (model_.drag() == nullptr) break;
        const double time = model_.scene().start_time + step * time_step_;
        sums.segment<3>(3 * handle.group) -=
            AirSlope(handle, 1.0) * model_.drag()->WindDerivativeAt(handle.node, time, wind_, id);
      }
      break;
    case ParameterKind::kDrag:
      for (const Handle& handle : handles_) {
        if (model_.drag() == nullptr) break;
        sums.segment<3>(3 * handle.group) += handle.drag_area * AirSpeed(step, handle, states);
      }
      break;
    case ParameterKind::kDamping:
      if (damping_) damping_->AddForce(1.0, time_step_, StartMetrics(window, states), positions, &force);
      break;
  }
  SubtractSums(force, &sums);
  return sums;
}

HandleForces::States HandleForces::StatesAt(int step, const Eigen::MatrixXd& positions) const {
  const int first = Window(step).first_step;
  return {positions.col(first), positions.col(first + 1), positions.col(first + 2)};
}

Eigen::MatrixXd HandleForces::Over(const Eigen::MatrixXd& positions) const {
  Eigen::MatrixXd forces(3 * num_groups(), num_steps_ + 1);
  for (int step = 0; step <= num_steps_; ++step) forces.col(step) = At(step, StatesAt(step, positions));
  return forces;
}

}  // namespace clothid
