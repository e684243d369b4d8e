#include "sim/rollout/handle_forces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>

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

HandleForces::HandleForces(WithoutPart, const ClothModel& model, const Parameters& parameters, int num_steps,
                           const std::vector<std::vector<int>>& groups)
    : model_(model),
      parameters_(parameters),
      num_steps_(num_steps),
      time_step_(model.scene().time_step),
      groups_(groups) {
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (groups[g].empty()) throw Error(ErrorKind::kBadData, "group " + std::to_string(g) + " of handles: has no node");
    for (const int node : groups[g]) {
      const bool is_handle = node >= 0 && node < model.num_nodes() && model.free_index()[node] < 0;
      if (!is_handle) {
        throw Error(ErrorKind::kBadData,
                    "group " + std::to_string(g) + " of handles: node " + std::to_string(node) + " is no handle");
      }
      handles_.push_back({static_cast<int>(g), node, -1});
    }
  }
}

// Of all sizes the nodes are the same: those that any of them couples.
HandleForces::HandleForces(const ClothModel& model, const Parameters& parameters, int num_steps,
                           const std::vector<std::vector<int>>& groups, const std::vector<ParameterId>& ids)
    : HandleForces(WithoutPart(), model, parameters, num_steps, groups) {
  sized_models_ = SizedModels(parameters, ids, model);
  std::vector<std::vector<int>> coupled = model.forces().CoupledWith(HandleNodes(), model.num_nodes());
  for (const SizedModel& sized : sized_models_) {
    for (std::vector<int>& set : sized.model->forces().CoupledWith(HandleNodes(), model.num_nodes())) {
      coupled.push_back(std::move(set));
    }
  }
  SetPart(coupled);
  for (const SizedModel& sized : sized_models_) {
    std::unique_ptr<HandleForces> forces(new HandleForces(WithoutPart(), *sized.model, parameters, num_steps, groups));
    forces->SetPart(coupled);
    sized_.push_back({sized.id, sized.weight, std::move(forces)});
  }
}

std::vector<int> HandleForces::HandleNodes() const {
  std::vector<int> nodes;
  for (const Handle& handle : handles_) nodes.push_back(handle.node);
  return nodes;
}

void HandleForces::SetPart(const std::vector<std::vector<int>>& coupled) {
  part_ = MakeForcePart(model_.scene(), HandleNodes(), coupled);
  forces_ = model_.forces().PartOf(part_);
  selection_ = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(part_.nodes.size()), 3 * num_groups());
  for (Handle& handle : handles_) {
    handle.local = part_.index[handle.node];
    selection_.block<3, 3>(3 * handle.local, 3 * handle.group) += Eigen::Matrix3d::Identity();
  }
}

Eigen::MatrixXd HandleForces::Gather(const Eigen::Ref<const Eigen::MatrixXd>& all) const {
  Eigen::MatrixXd near(3 * static_cast<Eigen::Index>(nodes().size()), all.cols());
  for (std::size_t i = 0; i < nodes().size(); ++i) {
    near.middleRows<3>(3 * static_cast<Eigen::Index>(i)) = all.middleRows<3>(3 * nodes()[i]);
  }
  return near;
}

ForceWindow HandleForces::Window(int step) const {
  return WindowOfForce(step, num_steps_, model_.scene().integrator, time_step_);
}

std::array<double, 3> HandleForces::PredictionShares(const ForceWindow& window) const {
  std::array<double, 3> shares = {0.0, 0.0, 0.0};
  const bool is_of_step = model_.scene().integrator == Integrator::kEuler && window.place == 2;
  if (is_of_step) return {-1.0, 2.0, 0.0};
  shares[static_cast<std::size_t>(window.place)] = 1.0;
  return shares;
}

std::array<double, 3> HandleForces::OriginShares(const ForceWindow& window) const {
  std::array<double, 3> shares = Scaled(window.rates, -time_step_);
  shares[static_cast<std::size_t>(window.place)] += 1.0;
  return shares;
}

HandleForces::Place HandleForces::PlaceOf(int step, const States& states) const {
  Place place{Window(step), model_.scene().start_time + step * time_step_, {}, {}, {}};
  for (std::size_t k = 0; k < 3; ++k) place.steps[k] = states[k].col(0);
  const std::array<double, 3>& rates = place.window.rates;
  place.velocities = rates[0] * place.steps[0] + rates[1] * place.steps[1] + rates[2] * place.steps[2];
  ForceStart& start = place.held.start;
  if (forces_.needs_origins()) {
    const std::array<double, 3> shares = OriginShares(place.window);
    for (std::size_t k = 0; k < 3; ++k) start.origins.push_back({&place.steps[k], shares[k]});
  }
  if (forces_.needs_prediction()) {
    const std::array<double, 3> shares = PredictionShares(place.window);
    start.predicted = shares[0] * place.steps[0] + shares[1] * place.steps[1] + shares[2] * place.steps[2];
    const Eigen::VectorXd& own = place.steps[static_cast<std::size_t>(place.window.place)];
    for (std::size_t i = 0; i < part_.nodes.size(); ++i) {
      const auto row = 3 * static_cast<Eigen::Index>(i);
      if (model_.free_index()[part_.nodes[i]] < 0) start.predicted.segment<3>(row) = own.segment<3>(row);
    }
  }
  forces_.Hold(parameters_, place.time, &place.held);
  return place;
}

NodeMotion HandleForces::MotionAt(const Handle& handle, const Place& place) const {
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    acceleration += kCurvature[k] / (time_step_ * time_step_) * place.steps[k].segment<3>(3 * handle.local);
  }
  return {handle.node, /*time_step=*/1.0, place.time, acceleration, place.velocities.segment<3>(3 * handle.local)};
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

Eigen::VectorXd HandleForces::ForceAt(const Place& place) const {
  const ForcePoint point = PointOf(place);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(point.positions.size());
  for (const ForceGroup group : {ForceGroup::kElastic, ForceGroup::kAir, ForceGroup::kViscous}) {
    forces_.AddForce(group, point, place.held, &force);
  }
  return force;
}

Eigen::VectorXd HandleForces::At(int step, const States& states) const {
  const Place place = PlaceOf(step, states);
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(3 * num_groups());
  SubtractSums(ForceAt(place), &sums);
  for (const Handle& handle : handles_) {
    sums.segment<3>(3 * handle.group) += model_.nodes().Impulse(MotionAt(handle, place), parameters_);
  }
  return sums;
}

Eigen::VectorXd HandleForces::MomentsAt(int step, const States& states) const {
  const Place place = PlaceOf(step, states);
  const ForcePoint point = PointOf(place);
  const Eigen::VectorXd force = ForceAt(place);
  Eigen::Matrix3Xd centres = Eigen::Matrix3Xd::Zero(3, num_groups()), moments = centres;
  for (const Handle& handle : handles_) {
    const auto num_nodes = static_cast<double>(groups_[static_cast<std::size_t>(handle.group)].size());
    centres.col(handle.group) += point.positions.segment<3>(3 * handle.local) / num_nodes;
  }
  for (const Handle& handle : handles_) {
    const Eigen::Vector3d arm = point.positions.segment<3>(3 * handle.local) - centres.col(handle.group);
    const Eigen::Vector3d upon = model_.nodes().Impulse(MotionAt(handle, place), parameters_);
    moments.col(handle.group) += arm.cross(Eigen::Vector3d(upon - force.segment<3>(3 * handle.local)));
  }
  const Handles& handles = model_.scene().handles;
  if (handles.clamped.empty()) return moments.reshaped();
  const Eigen::VectorXd slopes = handles.slopes.At(place.time);
  Eigen::VectorXd upon_slopes = Eigen::VectorXd::Zero(slopes.size());
  forces_.AddSlopeForce(point, &upon_slopes);
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const auto holds = [&](int node) {
      return std::find(groups_[g].begin(), groups_[g].end(), node) != groups_[g].end();
    };
    for (std::size_t k = 0; k < handles.clamped.size(); ++k) {
      if (!holds(handles.clamped[k].nodes[0]) || !holds(handles.clamped[k].nodes[1])) continue;
      const auto row = 3 * static_cast<Eigen::Index>(k);
      moments.col(static_cast<Eigen::Index>(g)) -= slopes.segment<3>(row).cross(upon_slopes.segment<3>(row));
    }
  }
  return moments.reshaped();
}

std::array<Eigen::MatrixXd, 3> HandleForces::Jacobian(int step, const States& states) const {
  const Place place = PlaceOf(step, states);
  const ForcePoint point = PointOf(place);
  const auto own = static_cast<std::size_t>(place.window.place);
  const std::array<double, 3>&rates = place.window.rates, origins = OriginShares(place.window);
  BlockMatrix hessian(part_.pattern);
  forces_.SetHessian(HessianKind::kExact, point, place.held, 1.0, rates[own], &hessian);
  std::array<Eigen::MatrixXd, 3> transposed;
  transposed.fill(Eigen::MatrixXd::Zero(selection_.rows(), selection_.cols()));
  transposed[own] = MultiplySymmetric(hessian, selection_);
  Eigen::MatrixXd by_prediction;  // x^
  if (forces_.needs_prediction()) {
    by_prediction.setZero(selection_.rows(), selection_.cols());
    forces_.AddPredictionProductTransposed(-1.0, point, place.held, selection_, &by_prediction);
  }
  const std::array<double, 3> predictions = PredictionShares(place.window);
  const Material& material = parameters_.material;
  for (std::size_t k = 0; k < 3; ++k) {
    if (k != own) forces_.AddVelocityProduct(rates[k], point, place.held, selection_, &transposed[k]);
    if (origins[k] != 0.0) {
      forces_.AddOriginProductTransposed(origins[k], point, place.steps[k], selection_, &transposed[k]);
    }
    for (std::size_t i = 0; by_prediction.size() > 0 && i < part_.nodes.size(); ++i) {
      const auto row = 3 * static_cast<Eigen::Index>(i);
      const bool is_handle = model_.free_index()[part_.nodes[i]] < 0;
      const double share = is_handle ? (k == own ? 1.0 : 0.0) : predictions[k];
      transposed[k].middleRows<3>(row) += share * by_prediction.middleRows<3>(row);
    }
    for (const Handle& handle : handles_) {
      transposed[k].block<3, 3>(3 * handle.local, 3 * handle.group).diagonal().array() +=
          model_.mass(material, handle.node) * kCurvature[k] / (time_step_ * time_step_) +
          model_.nodes().drag(material, handle.node) * rates[k];
    }
    transposed[k] = transposed[k].transpose().eval();
  }
  return transposed;
}

Eigen::VectorXd HandleForces::ParameterDerivative(ParameterId id, int step, const States& states) const {
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(3 * num_groups());
  if (IsOfContact(id.kind)) return sums;
  if (IsSize(id.kind)) {
    bool is_known = false;
    for (const Sized& sized : sized_) {
      if (!(sized.id == id)) continue;
      sums += sized.weight * sized.forces->At(step, states);
      is_known = true;
    }
    if (!is_known) throw std::logic_error("the derivative of forces by a size that was not asked for");
    return sums;
  }
  const Place place = PlaceOf(step, states);
  const ForcePoint point = PointOf(place);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(point.positions.size());
  forces_.AddDerivative(id, 1.0, point, place.held, &force);
  SubtractSums(force, &sums);
  for (const Handle& handle : handles_) {
    sums.segment<3>(3 * handle.group) += model_.nodes().ImpulseDerivative(id, MotionAt(handle, place), parameters_);
  }
  return sums;
}

Eigen::MatrixXd HandleForces::FieldDerivative(int step, const States& states) const {
  if (parameters_.fields == nullptr) return Eigen::MatrixXd(3 * num_groups(), 0);
  const Eigen::Index num_faces = model_.scene().mesh.num_faces();
  const auto num_fields = static_cast<Eigen::Index>(parameters_.fields->size());
  Eigen::MatrixXd derivative = Eigen::MatrixXd::Zero(3 * num_groups(), num_fields * num_faces);
  const Place place = PlaceOf(step, states);
  Eigen::Index first = 0;
  for (const FieldFactors& field : *parameters_.fields) {
    auto columns = derivative.middleCols(first, num_faces);
    Eigen::MatrixXd products = Eigen::MatrixXd::Zero(num_faces, selection_.cols());
    forces_.AddFieldProducts(field, 1.0, PointOf(place), selection_, products);
    columns -= products.transpose();
    if (field.kind == ParameterKind::kDensity) AddMassColumns(field, place, columns);
    first += num_faces;
  }
  return derivative;
}

void HandleForces::AddMassColumns(const FieldFactors& field, const Place& place,
                                  Eigen::Ref<Eigen::MatrixXd> derivative) const {
  const Mesh& mesh = model_.scene().mesh;
  const Eigen::VectorXd areas = TriangleAreas(mesh);
  for (const Handle& handle : handles_) {
    const Eigen::Vector3d gain = MotionAt(handle, place).change - model_.scene().gravity;
    for (const int face : part_.faces) {
      if ((mesh.faces.col(face).array() != handle.node).all()) continue;
      const double mass = parameters_.material.density / 3.0 * areas[face] * std::exp(field.log_factors[face]);
      derivative.col(face).segment<3>(3 * handle.group) += mass * gain;
    }
  }
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

Eigen::MatrixXd HandleForces::MomentsOver(const Eigen::MatrixXd& positions) const {
  Eigen::MatrixXd moments(3 * num_groups(), num_steps_ + 1);
  for (int step = 0; step <= num_steps_; ++step) moments.col(step) = MomentsAt(step, StatesAt(step, positions));
  return moments;
}

}  // namespace clothid
