#include "identify/uncertainty/discretization_error.h"

#include <cmath>

namespace clothid {
namespace {

constexpr double kLowestOrder = 1.0, kHighestOrder = 2.0;

// Of an error that falls like h^order, from what halving h changes.
double ErrorAtStep(double change, double order) {
  const double ratio = std::exp2(order);
  return std::abs(change) * ratio / (ratio - 1.0);
}

// Into `share`, that of the value, and the part of half an interval that is known of it.
double AddError(const ParameterBlock& block, double coordinate, const DiscretizationError& error, double* share) {
  *share = block.ValueDerivative(coordinate) * error.error;
  return std::isnan(error.error) ? 0.0 : kNormal95 * error.error;
}

// The interval once more, with an error of the step that nothing is judged by.
void WidenByStepError(const ParameterBlock& block, double coordinate, ParameterUncertainty* parameter) {
  if (parameter->stalled || std::isnan(parameter->step_error)) return;
  const double error = parameter->step_error / block.ValueDerivative(coordinate);
  SetInterval(block, coordinate, std::hypot(parameter->half_width95, kNormal95 * error), parameter);
}

}  // namespace

DiscretizationError ErrorOfStep(double at_step, double at_half, double at_double) {
  DiscretizationError result;
  // NaN where the signs differ.
  const double order = std::log2((at_double - at_step) / (at_step - at_half));
  if (order >= kLowestOrder && order <= kHighestOrder) result.order = order;
  result.error = ErrorAtStep(at_step - at_half, std::isnan(result.order) ? kLowestOrder : result.order);
  return result;
}

DiscretizationError ErrorOfMesh(double on_mesh, double on_refined) {
  DiscretizationError result;
  result.error = ErrorAtStep(on_mesh - on_refined, kLowestOrder);
  return result;
}

void AddDiscretizationErrors(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                             const std::vector<DiscretizationError>& step, const std::vector<DiscretizationError>& mesh,
                             Uncertainty* uncertainty) {
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    ParameterUncertainty& parameter = uncertainty->parameters[i];
    if (std::isnan(parameter.coordinate_std)) continue;
    const double q = coordinates[static_cast<Eigen::Index>(i)];
    double half_width = uncertainty->quantile95 * parameter.coordinate_std;
    for (const double error : {parameter.memory_error, parameter.stall_error}) {
      if (!std::isnan(error)) half_width = std::hypot(half_width, kNormal95 * error / blocks[i].ValueDerivative(q));
    }
    if (!step.empty()) {
      half_width = std::hypot(half_width, AddError(blocks[i], q, step[i], &parameter.step_error));
      parameter.step_order = step[i].order;
    }
    if (!mesh.empty()) half_width = std::hypot(half_width, AddError(blocks[i], q, mesh[i], &parameter.mesh_error));
    SetInterval(blocks[i], q, half_width, &parameter);
  }
  JudgeIntervals(blocks, uncertainty);
  for (std::size_t i = 0; i < blocks.size() && step.empty(); ++i) {
    WidenByStepError(blocks[i], coordinates[static_cast<Eigen::Index>(i)], &uncertainty->parameters[i]);
  }
}

void AddMemoryErrors(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                     const Eigen::VectorXd& drift, Uncertainty* uncertainty) {
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const auto index = static_cast<Eigen::Index>(i);
    uncertainty->parameters[i].memory_error = blocks[i].ValueDerivative(coordinates[index]) * drift[index];
  }
  AddDiscretizationErrors(blocks, coordinates, {}, {}, uncertainty);
}

void AddEstimatedStepErrors(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                            const std::vector<DiscretizationError>& step, Uncertainty* uncertainty) {
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    ParameterUncertainty& parameter = uncertainty->parameters[i];
    if (std::isnan(parameter.coordinate_std)) continue;
    const double q = coordinates[static_cast<Eigen::Index>(i)];
    parameter.step_error = blocks[i].ValueDerivative(q) * step[i].error;
    parameter.step_order = step[i].order;
    WidenByStepError(blocks[i], q, &parameter);
  }
}

}  // namespace clothid
