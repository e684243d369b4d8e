#include "sim/derivative/adjoint.h"

#include <memory>
#include <utility>

#include "sim/cloth/cloth_model.h"
#include "sim/derivative/adjoint_solver.h"
#include "sim/derivative/handle_coupling.h"
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

// Gathers dC/d(handle offsets) [3 H K x s] over the sweep. Nothing where the rollout has none.
class HandleGradient {
 public:
  HandleGradient(const Rollout& rollout, int num_columns, const ClothModel& model)
      : offsets_(rollout.handle_offsets), nodes_(model.scene().handles.nodes), parameters_(rollout.parameters) {
    if (offsets_.num_handles() == 0) return;
    coupling_ = std::make_unique<HandleCoupling>(model);
    values_ = Eigen::MatrixXd::Zero(offsets_.positions().size(), num_columns);
  }

  // Of a scalar that depends on the handles' positions at `time` itself, dC/dx [3N x s].
  void AddSeed(double time, const Eigen::MatrixXd& seed) {
    if (coupling_ == nullptr) return;
    Eigen::MatrixXd rows(offsets_.positions().rows(), seed.cols());
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      rows.middleRows<3>(3 * static_cast<Eigen::Index>(i)) = seed.middleRows<3>(3 * nodes_[i]);
    }
    Add(time, rows);
  }

  // Through a step, y = (I + S)^T z of it.
  void AddStep(const StepRecord& record, const Eigen::VectorXd& start_positions, const Eigen::MatrixXd& y) {
    if (coupling_ == nullptr) return;
    coupling_->SetStep(record, start_positions, parameters_);
    Eigen::MatrixXd end = Eigen::MatrixXd::Zero(offsets_.positions().rows(), y.cols()), start = end;
    coupling_->AddTransposed(-y, &end, &start);
    Add(record.time, end);
    Add(record.time - record.time_step, start);
  }

  Eigen::MatrixXd& values() { return values_; }

 private:
  void Add(double time, const Eigen::MatrixXd& rows) {
    const Eigen::VectorXd weights = offsets_.KnotWeights(time);
    for (Eigen::Index k = 0; k < weights.size(); ++k) {
      values_.middleRows(k * rows.rows(), rows.rows()) += weights[k] * rows;
    }
  }

  const HandlePath& offsets_;
  const std::vector<int>& nodes_;
  const Parameters& parameters_;
  std::unique_ptr<HandleCoupling> coupling_;
  Eigen::MatrixXd values_;
};

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
  HandleGradient handles(rollout, num_columns, model);
  const auto add_seed = [&](int step) {
    seed.setZero();
    add_position_gradient(step, &seed);
    lambda_x += model.GatherColumns(seed);
    handles.AddSeed(rollout.start_time + step * rollout.time_step, seed);
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
    handles.AddStep(record, reader.start_positions(i), y);
    lambda_v = step.TimesMass(y);
    lambda_x -= step.TimesStartTransposed(y);
    if (!record.contacts.empty()) lambda_x -= step.TimesFramesTransposed(z);
  }
  add_seed(0);
  gradient.initial_positions = model.ScatterColumns(lambda_x);
  gradient.initial_velocities = model.ScatterColumns(lambda_v);
  gradient.handle_offsets = std::move(handles.values());
  timer.reset();
  gradient.work.phases = simulator->step_solver().seconds() - before;
  return gradient;
}

}  // namespace clothid
