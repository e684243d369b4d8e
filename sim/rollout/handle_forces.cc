#include "sim/rollout/handle_forces.h"

#include <algorithm>
#include <cstddef>

#include "sim/base/error.h"
#include "sim/matrix/block_product.h"

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

Eigen::Index HandleForces::FirstRowOf(const Handle& handle) const {
  const std::vector<int>& nodes = model_.scene().handles.nodes;
  return 3 * (std::find(nodes.begin(), nodes.end(), handle.node) - nodes.begin());
}

Eigen::MatrixXd HandleForces::OverGroups(const Eigen::MatrixXd& handles) const {
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(3 * num_groups(), handles.cols());
  for (const Handle& handle : handles_) {
    sums.middleRows<3>(3 * handle.group) += handles.middleRows<3>(FirstRowOf(handle));
  }
  return sums;
}

Eigen::MatrixXd HandleForces::OverGroupsTransposed(const Eigen::MatrixXd& groups) const {
  const auto num_handles = static_cast<Eigen::Index>(model_.scene().handles.nodes.size());
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(3 * num_handles, groups.cols());
  for (const Handle& handle : handles_)
    rows.middleRows<3>(FirstRowOf(handle)) += groups.middleRows<3>(3 * handle.group);
  return rows;
}

void HandleForces::AddBending(const Bending& bending, double stiffness, const Eigen::VectorXd& positions,
                              Eigen::VectorXd* sums) const {
  sums->reshaped(3, num_groups()) +=
      stiffness * (positions.reshaped(3, positions.size() / 3) * bending.rows.transpose());
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
  for (const Bending& bending : bending_) AddBending(bending, bending.stiffness, positions, &sums);
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
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(3 * num_groups());
  if (IsOfContact(id.kind)) return sums;
  const ForceWindow window = Window(step);
  const Eigen::VectorXd positions = states[static_cast<std::size_t>(window.place)].col(0);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(positions.size());
  switch (RowOf(id.kind).term) {
    case ParameterTerm::kMembrane:
      membrane_->AddForceDerivative(id, 1.0, positions, &force);
      break;
    case ParameterTerm::kBending:
      if (const ClothPieces* pieces = model_.PiecesOf(id.kind)) {
        for (const BendingMatrix& term : pieces->bending(id.piece)) {
          if (term.kind == id.kind) AddBending({term.kind, 1.0, RowsOf(term.matrix)}, 1.0, positions, &sums);
        }
        break;
      }
      for (const Bending& bending : bending_) {
        if (bending.kind == id.kind) AddBending(bending, 1.0, positions, &sums);
      }
      break;
    case ParameterTerm::kMass:
      for (const Handle& handle : handles_) {
        Eigen::Vector3d acceleration = Acceleration(handle, states);
        if (id.kind == ParameterKind::kDensity) acceleration -= model_.scene().gravity;  // the air has no weight
        sums.segment<3>(3 * handle.group) += (*model_.MassSlopes(id))[handle.node] * acceleration;
      }
      break;
    case ParameterTerm::kWind:
      for (const Handle& handle : handles_) {
        if (model_.drag() == nullptr) break;
        const double time = model_.scene().start_time + step * time_step_;
        sums.segment<3>(3 * handle.group) -=
            AirSlope(handle, 1.0) * model_.drag()->WindDerivativeAt(handle.node, time, wind_, id);
      }
      break;
    case ParameterTerm::kDrag:
      for (const Handle& handle : handles_) {
        if (model_.drag() == nullptr) break;
        sums.segment<3>(3 * handle.group) += model_.DragAreas(id)[handle.node] * AirSpeed(step, handle, states);
      }
      break;
    case ParameterTerm::kSize:
      throw Error(ErrorKind::kUsage, "size.x and size.y: no parameters of a recording with forces at its handles");
    case ParameterTerm::kDamping:
      if (damping_) DampingOf(id).AddForce(1.0, time_step_, StartMetrics(window, states), positions, &force);
      break;
    case ParameterTerm::kDirectionalDrag:  // the constructor refuses scenes that have it
    case ParameterTerm::kFriction:
    case ParameterTerm::kSelfFriction:
    case ParameterTerm::kPlacement:
      break;  // of contact: above
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
