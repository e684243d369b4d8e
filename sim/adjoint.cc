#include "sim/adjoint.h"

#include <stdexcept>
#include <string>

#include "sim/cloth_model.h"
#include "sim/record_reader.h"
#include "sim/simulator.h"
#include "sim/step_derivative.h"

namespace clothid {
namespace {

// z and y = (I + S)^T z of A^T z = right, by LU where the reduced method does not reach its tolerance.
void SolveStep(const Eigen::MatrixXd& right, double tolerance, AdjointMethod method, StepDerivative* step,
               Eigen::MatrixXd* z, Eigen::MatrixXd* y, int* lu_fallbacks) {
  if (method == AdjointMethod::kReduced) {
    if (step->Factor(StepJacobian::Method::kReduced) && step->jacobian().SolveTransposed(right, tolerance, z, y))
      return;
    ++*lu_fallbacks;
  }
  if (!step->Factor(StepJacobian::Method::kLu) || !step->jacobian().SolveTransposed(right, tolerance, z, y)) {
    throw std::runtime_error("singular step Jacobian");
  }
}

}  // namespace

RolloutGradient PullBack(const Rollout& rollout, const std::vector<ParameterId>& parameters, int num_columns,
                         const AddPositionGradient& add_position_gradient, Simulator* simulator,
                         const AdjointOptions& options) {
  const ClothModel& model = simulator->model();
  const double tolerance = simulator->scene().solver.adjoint_tolerance;
  RolloutGradient gradient;
  gradient.parameters = Eigen::MatrixXd::Zero(static_cast<int>(parameters.size()), num_columns);

  Eigen::MatrixXd lambda_x = Eigen::MatrixXd::Zero(3 * model.num_free(), num_columns);
  Eigen::MatrixXd lambda_v = lambda_x;
  Eigen::MatrixXd seed(3 * model.num_nodes(), num_columns), z, y;
  const auto add_seed = [&](int step) {
    seed.setZero();
    add_position_gradient(step, &seed);
    lambda_x += model.GatherColumns(seed);
  };

  RecordReader reader(rollout, simulator);
  int step_number = rollout.num_steps();
  for (int i = static_cast<int>(rollout.records.size()) - 1; i >= 0; --i) {
    const StepRecord& record = reader.record(i);
    if (step_number > 0 && rollout.last_record[step_number - 1] == i) add_seed(step_number--);
    StepDerivative step(record, reader.start_positions(i), reader.start_velocities(i), rollout.parameters, simulator);

    const Eigen::MatrixXd w = lambda_v + record.time_step * lambda_x;
    SolveStep(w, tolerance, options.method, &step, &z, &y, &gradient.lu_fallbacks);
    for (size_t p = 0; p < parameters.size(); ++p) {
      if (parameters[p].kind == ParameterKind::kFriction) {
        if (!record.contacts.empty())
          gradient.parameters.row(p) += step.ImpulseDerivative(parameters[p]).transpose() * z;
      } else {
        gradient.parameters.row(p) -= step.MomentumDerivative(parameters[p]).transpose() * y;
      }
    }
    lambda_v = step.TimesMass(y);
    lambda_x -= step.TimesStartTransposed(y);
    if (!record.contacts.empty()) lambda_x -= step.TimesFramesTransposed(z);
  }
  add_seed(0);
  gradient.initial_positions = model.ScatterColumns(lambda_x);
  gradient.initial_velocities = model.ScatterColumns(lambda_v);
  return gradient;
}

}  // namespace clothid
