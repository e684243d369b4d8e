#include "sim/derivative/adjoint.h"

#include "sim/cloth/cloth_model.h"
#include "sim/derivative/adjoint_solver.h"
#include "sim/derivative/step_derivative.h"
#include "sim/rollout/record_reader.h"
#include "sim/rollout/simulator.h"
#include "sim/step/step_solver.h"

namespace clothid {
namespace {

// Row p += dC/dtheta_p through the step alone.
void AddParameterGradient(const StepRecord& record, const std::vector<ParameterId>& parameters,
                          const Eigen::MatrixXd& z, const Eigen::MatrixXd& y, const StepDerivative& step,
                          Eigen::MatrixXd* gradient) {
  for (size_t p = 0; p < parameters.size(); ++p) {
    if (parameters[p].kind != ParameterKind::kFriction) {
      gradient->row(p) -= step.MomentumDerivative(parameters[p]).transpose() * y;
    } else if (!record.contacts.empty()) {
      gradient->row(p) += step.ImpulseDerivative(parameters[p]).transpose() * z;
    }
  }
}

}  // namespace

RolloutGradient PullBack(const Rollout& rollout, const std::vector<ParameterId>& parameters, int num_columns,
                         const AddPositionGradient& add_position_gradient, Simulator* simulator,
                         const AdjointOptions& options) {
  const ClothModel& model = simulator->model();
  const PhaseSeconds before = simulator->step_solver().seconds();
  RolloutGradient gradient;
  std::optional<ScopedTimer> timer(&gradient.work.total_seconds);
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
  AdjointSolver solver(options, rollout.parameters, simulator);
  int step_number = rollout.num_steps();
  for (int i = static_cast<int>(rollout.records.size()) - 1; i >= 0; --i) {
    const StepRecord& record = reader.record(i);
    if (step_number > 0 && rollout.last_record[step_number - 1] == i) add_seed(step_number--);
    StepDerivative step(record, reader.start_positions(i), reader.start_velocities(i), rollout.parameters, simulator);

    const Eigen::MatrixXd w = lambda_v + record.time_step * lambda_x;
    solver.Solve(record, w, &step, &z, &y, &gradient.work);
    AddParameterGradient(record, parameters, z, y, step, &gradient.parameters);
    lambda_v = step.TimesMass(y);
    lambda_x -= step.TimesStartTransposed(y);
    if (!record.contacts.empty()) lambda_x -= step.TimesFramesTransposed(z);
  }
  add_seed(0);
  gradient.initial_positions = model.ScatterColumns(lambda_x);
  gradient.initial_velocities = model.ScatterColumns(lambda_v);
  timer.reset();
  gradient.work.phases = simulator->step_solver().seconds() - before;
  return gradient;
}

}  // namespace clothid
