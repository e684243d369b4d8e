#include "sim/derivative/size_derivative.h"

#include <stdexcept>

#include "sim/rollout/sized_scene.h"
#include "sim/step/second_start.h"
#include "sim/step/step_problem.h"

namespace clothid {
namespace {

constexpr double kShareOfSize = 5e-4;                               // e
constexpr std::array<int, 4> kPlaces = {-2, -1, 1, 2};              // k
constexpr std::array<double, 4> kWeights = {1.0, -8.0, 8.0, -1.0};  // times 1/(12 e s)
constexpr std::array<ParameterKind, 2> kSizes = {ParameterKind::kSizeX, ParameterKind::kSizeY};

// The force [3N] of all terms but gravity, the scene's node force, seams, which have no size, and the drag that is the
// same in every direction.
Eigen::VectorXd Force(const ClothModel& model, const Parameters& parameters, const StepRecord& record,
                      const SolveStart& start) {
  const Material& material = parameters.material;
  Eigen::VectorXd force = Eigen::VectorXd::Zero(record.positions.size());
  model.membrane().AddForce(material, record.positions, &force);
  for (const BendingTerm& term : model.bending_terms()) {
    term.AddForce(term.stiffness(material), record.positions, &force);
  }
  if (model.damping() != nullptr) {
    std::vector<MetricBatch> start_metrics;
    SetStartMetrics(model, start, &start_metrics);
    model.damping()->AddForce(material.damping, record.time_step, start_metrics, record.positions, &force);
  }
  if (model.directional_drag() != nullptr) {
    std::vector<AirBatch> air;
    const Eigen::VectorXd predicted =
        PredictedPositions(start, record.time_step, model.scene().handles.nodes, record.positions);
    model.directional_drag()->SetAir(predicted, parameters.wind, record.time, &air);
    model.directional_drag()->AddForce(DragConstantsOf(material), record.velocities, air, &force);
  }
  return force;
}

// g [3N], but for what no size changes.
Eigen::VectorXd MomentumGradient(const ClothModel& model, const Parameters& parameters, const StepRecord& record,
                                 const SolveStart& start) {
  const Material& material = parameters.material;
  const double h = record.time_step;
  Eigen::VectorXd gradient = -h * Force(model, parameters, record, start);
  for (const int node : model.free_nodes()) {
    const Eigen::Vector3d velocity = record.velocities.segment<3>(3 * node);
    auto rows = gradient.segment<3>(3 * node);
    rows += model.mass(material, node) * (velocity - start.velocities.segment<3>(3 * node)) -
            h * material.density * model.mass_areas()[node] * model.scene().gravity;
    if (model.drag() == nullptr) continue;
    rows += h * material.drag * model.drag()->areas()[node] *
            (velocity - model.drag()->WindAt(node, record.time, parameters.wind));
  }
  return gradient;
}

}  // namespace

SizeDerivative::SizeDerivative(const Parameters& parameters, const std::vector<ParameterId>& ids,
                               const Simulator& simulator)
    : parameters_(parameters) {
  for (std::size_t axis = 0; axis < kSizes.size(); ++axis) {
    for (const ParameterId id : ids) {
      if (id.kind != kSizes[axis] || !models_[axis].empty()) continue;
      mass_slopes_[axis] = Eigen::VectorXd::Zero(simulator.model().num_nodes());
      for (std::size_t i = 0; i < kPlaces.size(); ++i) {
        std::array<double, 2> size = parameters.size;
        size[axis] *= 1.0 + kPlaces[i] * kShareOfSize;
        SizedModel sized;
        sized.weight = kWeights[i] / (12.0 * kShareOfSize * parameters.size[axis]);
        sized.scene = std::make_unique<const Scene>(SizedScene(simulator.scene(), size));
        auto model = std::make_unique<ClothModel>(*sized.scene, simulator.model());
        model->SetVariation(parameters);
        for (int node = 0; node < model->num_nodes(); ++node) {
          mass_slopes_[axis][node] += sized.weight * model->mass(parameters.material, node);
        }
        sized.model = std::move(model);
        models_[axis].push_back(std::move(sized));
      }
    }
  }
}

const std::vector<SizeDerivative::SizedModel>& SizeDerivative::ModelsOf(ParameterKind kind) const {
  const std::vector<SizedModel>& models = models_[kind == ParameterKind::kSizeX ? 0 : 1];
  if (!IsSize(kind) || models.empty()) throw std::logic_error("the derivative by a size that was not asked for");
  return models;
}

Eigen::VectorXd SizeDerivative::MomentumDerivative(ParameterKind kind, const StepRecord& record,
                                                   const SolveStart& start) const {
  Eigen::VectorXd derivative = Eigen::VectorXd::Zero(record.positions.size());
  for (const SizedModel& sized : ModelsOf(kind)) {
    derivative += sized.weight * MomentumGradient(*sized.model, parameters_, record, start);
  }
  return derivative;
}

const Eigen::VectorXd& SizeDerivative::MassSlopes(ParameterKind kind) const {
  ModelsOf(kind);
  return mass_slopes_[kind == ParameterKind::kSizeX ? 0 : 1];
}

}  // namespace clothid
