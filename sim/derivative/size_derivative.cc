#include "sim/derivative/size_derivative.h"

#include <stdexcept>

#include "sim/step/second_start.h"

namespace clothid {
namespace {

// g [3N].
Eigen::VectorXd MomentumGradient(const ClothModel& model, const Parameters& parameters, const StepRecord& record,
                                 const SolveStart& start) {
  const double h = record.time_step;
  HeldForces held;
  SetForceStart(model.forces(), start, h, model.scene().handles.nodes, record.positions, &held.start);
  model.forces().Hold(parameters, record.time, &held);
  const ForcePoint point{parameters, h, record.time, record.positions, record.velocities};
  Eigen::VectorXd force = Eigen::VectorXd::Zero(record.positions.size());
  for (const ForceGroup group : {ForceGroup::kElastic, ForceGroup::kAir, ForceGroup::kViscous}) {
    model.forces().AddForce(group, point, held, &force);
  }
  Eigen::VectorXd gradient = -h * force;
  for (const int node : model.free_nodes()) {
    const NodeMotion motion = MotionOf(node, h, record.time, start.velocities, record.velocities);
    gradient.segment<3>(3 * node) += model.nodes().Impulse(motion, parameters);
  }
  return gradient;
}

}  // namespace

SizeDerivative::SizeDerivative(const Parameters& parameters, const std::vector<ParameterId>& ids,
                               const Simulator& simulator)
    : parameters_(parameters), models_(SizedModels(parameters, ids, simulator.model())) {
  for (const SizedModel& sized : models_) {
    Eigen::VectorXd& slopes = mass_slopes_[static_cast<std::size_t>(sized.id.axis)];
    if (slopes.size() == 0) slopes.setZero(sized.model->num_nodes());
    for (int node = 0; node < slopes.size(); ++node) {
      slopes[node] += sized.weight * sized.model->mass(parameters.material, node);
    }
  }
}

Eigen::VectorXd SizeDerivative::MomentumDerivative(ParameterId id, const StepRecord& record,
                                                   const SolveStart& start) const {
  MassSlopes(id);
  Eigen::VectorXd derivative = Eigen::VectorXd::Zero(record.positions.size());
  for (const SizedModel& sized : models_) {
    if (sized.id == id) derivative += sized.weight * MomentumGradient(*sized.model, parameters_, record, start);
  }
  return derivative;
}

const Eigen::VectorXd& SizeDerivative::MassSlopes(ParameterId id) const {
  const Eigen::VectorXd& slopes = mass_slopes_[static_cast<std::size_t>(id.axis)];
  if (!IsSize(id.kind) || slopes.size() == 0) throw std::logic_error("the derivative by a size that was not asked for");
  return slopes;
}

}  // namespace clothid
