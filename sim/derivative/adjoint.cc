#include "sim/derivative/adjoint.h"

#include <memory>
#include <utility>

#include "sim/cloth/cloth_model.h"
#include "sim/derivative/adjoint_solver.h"
#include "sim/derivative/correction_derivative.h"
#include "sim/derivative/field_derivative.h"
#include "sim/derivative/handle_sweep.h"
#include "sim/derivative/second_start_derivative.h"
#include "sim/derivative/size_derivative.h"
#include "sim/derivative/step_derivative.h"
#include "sim/rollout/correction.h"
#include "sim/rollout/record_reader.h"
#include "sim/rollout/simulator.h"
#include "sim/step/step_solver.h"

namespace clothid {
namespace {

// Row p += dC/dtheta_p through the step alone.
void AddParameterGradient(const std::vector<ParameterId>& parameters, const StepColumns& z, const Eigen::MatrixXd& y,
                          const StepDerivative& step, Eigen::MatrixXd* gradient) {
  for (size_t p = 0; p < parameters.size(); ++p) {
    if (!IsOfContact(parameters[p].kind)) {
      gradient->row(p) -= step.MomentumDerivative(parameters[p]).transpose() * y;
    } else if (!step.contacts().empty()) {
      const StepColumns change = step.ImpulseDerivative(parameters[p]);
      gradient->row(p) += change.velocities.col(0).transpose() * z.velocities;
      gradient->row(p) += change.impulses.col(0).transpose() * z.impulses;
    }
  }
}

// Takes gradients of scalars by the state at the end of a solve to those by the state before it.
class ReverseSweep {
 public:
  ReverseSweep(const Rollout& rollout, const std::vector<ParameterId>& parameters, int num_columns,
               const AdjointOptions& options, Simulator* simulator, RolloutGradient* gradient)
      : parameters_(rollout.parameters),
        ids_(parameters),
        simulator_(simulator),
        solver_(options, rollout.parameters, simulator),
        handles_(rollout, num_columns, simulator->model()),
        fields_(rollout.parameters, num_columns, simulator->model()),
        sizes_(rollout.parameters, parameters, *simulator),
        gradient_(gradient) {
    gradient->parameters = Eigen::MatrixXd::Zero(static_cast<int>(parameters.size()), num_columns);
    lambda_.positions = Eigen::MatrixXd::Zero(3 * simulator->model().num_free(), num_columns);
    lambda_.velocities = lambda_.positions;
  }

  // Of scalars that depend on the positions at `time` themselves, dC/dx [3N x s].
  void AddSeed(double time, const Eigen::MatrixXd& seed) {
    lambda_.positions += simulator_->model().GatherColumns(seed);
    handles_.AddSeed(time, seed);
  }

  // From the corrected state at the end of `step`, of which `record` is the last, to what it has come to, at `time`.
  // The step starts from `start` [3N], by which LeaveStep adds the rest.
  void PullBackCorrection(const Correction& correction, int step, double time, const Eigen::VectorXd& start,
                          const StepRecord& record) {
    const CorrectionDerivative derivative(correction, step, start, record, parameters_, ids_, simulator_->model());
    Eigen::MatrixXd by_end;
    derivative.PullBack(&lambda_, &by_step_start_, &by_end, &gradient_->parameters);
    AddSeed(time, by_end);
  }

  // At the start of a step, at `time`.
  void LeaveStep(double time) {
    if (by_step_start_.size() > 0) AddSeed(time, by_step_start_);
    by_step_start_.resize(0, 0);
  }

  // `by_pair_forces` [3H x s]: by those upon handles at the end of the solve; null: none.
  void PullBackSolve(const StepRecord& record, const SolveStart& start, const Eigen::MatrixXd* by_pair_forces) {
    StepDerivative step(record, start, parameters_, simulator_, &sizes_);
    if (record.ends_step()) handles_.EnterStep(record);
    StepColumns by_impulses;  // by r_1 and by r of pairs, where impacts make them count
    if (record.stage == Stage::kFirst) by_impulses = LeaveSecondStart(record, start, step);
    const bool has_impacts = by_impulses.velocities.size() > 0;
    StepColumns right{lambda_.velocities + record.time_step * lambda_.positions,
                      Eigen::MatrixXd::Zero(step.num_impulses(), lambda_.positions.cols())};
    if (has_impacts) {
      right += step.TimesUnknownsTransposed(by_impulses.velocities);
      right.impulses += by_impulses.impulses;
    }
    Eigen::MatrixXd by_start;  // by x_n, through the forces of pairs upon handles
    if (by_pair_forces != nullptr) {
      by_start = Eigen::MatrixXd::Zero(lambda_.positions.rows(), lambda_.positions.cols());
      step.AddHandleForcesTransposed(*by_pair_forces, &right.impulses, &by_start);
    }
    StepColumns z;
    Eigen::MatrixXd y;
    solver_.Solve(record, right, &step, &z, &y, &gradient_->work);
    if (has_impacts) y -= by_impulses.velocities;
    AddParameterGradient(ids_, z, y, step, &gradient_->parameters);
    handles_.AddSolve(record, start, step, {y, z.impulses});
    fields_.AddSolve(record, start, y);
    lambda_.velocities = step.TimesMass(y);
    lambda_.positions -= step.TimesStartTransposed(y);
    if (step.has_prediction()) {
      const Eigen::MatrixXd by_prediction = step.TimesPredictionTransposed(y);
      lambda_.velocities -= record.time_step * by_prediction;
      lambda_.positions -= by_prediction;
    }
    if (!step.contacts().empty()) lambda_.positions -= step.TimesFramesTransposed(z);
    if (by_pair_forces != nullptr) {
      handles_.AddContactForces(*by_pair_forces);
      lambda_.positions += by_start;
    }
    if (record.stage == Stage::kFirst) {
      lambda_.positions += by_start_.positions;
      lambda_.velocities += by_start_.velocities;
    }
    if (record.stage == Stage::kSecond) EnterSecondStart(step, y);
  }

  void Finish() {
    gradient_->initial_positions = simulator_->model().ScatterColumns(lambda_.positions);
    gradient_->initial_velocities = simulator_->model().ScatterColumns(lambda_.velocities);
    gradient_->handle_offsets = std::move(handles_.values());
    gradient_->fields = std::move(fields_.values());
  }

 private:
  // From x_s and v_s, with y of the second stage, on the way to x_1, v_1 and the start of the step.
  void EnterSecondStart(const StepDerivative& step, const Eigen::MatrixXd& y) {
    by_second_ = lambda_;
    lambda_.positions.setZero();
    lambda_.velocities.setZero();
    by_start_ = lambda_;
    if (step.has_origins()) step.SubtractOriginsTransposed(y, &by_start_.positions, &lambda_.positions);
  }

  // The rest of that way, now that the first stage is at hand. Returns the gradient by its impulses, if they count.
  StepColumns LeaveSecondStart(const StepRecord& first, const SolveStart& start, const StepDerivative& step) {
    const SecondStartDerivative second(first, start, step, parameters_, simulator_->model());
    second.AddTransposed(by_second_, &by_start_, &lambda_);
    if (!second.has_impacts()) return {};
    handles_.AddImpacts(first, second, by_second_);
    fields_.AddSecondStart(second, by_second_);
    for (size_t p = 0; p < ids_.size(); ++p) {
      const Eigen::VectorXd* slopes = step.MassSlopes(ids_[p]);
      if (slopes != nullptr) gradient_->parameters.row(p) += second.MassGradient(*slopes, by_second_);
      if (IsPlacement(ids_[p].kind)) {
        gradient_->parameters.row(p) -=
            second.MotionDerivative(step.MotionChanges(ids_[p])).transpose() * by_second_.velocities;
      }
    }
    return second.AddImpactsTransposed(by_second_, &by_start_, &lambda_);
  }

  const Parameters& parameters_;
  const std::vector<ParameterId>& ids_;
  Simulator* simulator_;
  AdjointSolver solver_;
  HandleGradient handles_;
  FieldGradient fields_;
  SizeDerivative sizes_;
  RolloutGradient* gradient_;
  StateColumns lambda_;                // by the end of the solve that comes next
  StateColumns by_second_, by_start_;  // between two stages: by x_s and v_s, and by x_n and v_n besides
  Eigen::MatrixXd by_step_start_;      // through the correction at the end of the step [3N x s]; empty: none
};

}  // namespace

RolloutGradient PullBack(const Rollout& rollout, const std::vector<ParameterId>& parameters, int num_columns,
                         const AddPositionGradient& add_position_gradient, Simulator* simulator,
                         const AdjointOptions& options, const AddPositionGradient& add_pair_force_gradient,
                         const AddPositionGradient& add_corrected_gradient) {
  simulator->UseParameters(rollout.parameters);
  const PhaseSeconds before = simulator->step_solver().seconds();
  RolloutGradient gradient;
  std::optional<ScopedTimer> timer(&gradient.work.total_seconds);
  ReverseSweep sweep(rollout, parameters, num_columns, options, simulator, &gradient);
  Eigen::MatrixXd seed(3 * simulator->model().num_nodes(), num_columns);
  const auto time_of = [&](int step) { return rollout.start_time + step * rollout.time_step; };
  const auto add_seed = [&](int step, const AddPositionGradient& add) {
    seed.setZero();
    add(step, &seed);
    sweep.AddSeed(time_of(step), seed);
  };

  Eigen::MatrixXd by_pair_forces;
  RecordReader reader(rollout, simulator);
  const auto first_record = [&](int step) { return step == 1 ? 0 : rollout.last_record[step - 2] + 1; };
  int step_number = rollout.num_steps();
  for (int i = static_cast<int>(rollout.records.size()) - 1; i >= 0; --i) {
    const StepRecord& record = reader.record(i);
    const bool ends_step = step_number > 0 && rollout.last_record[step_number - 1] == i;
    if (ends_step && record.correction != nullptr) {
      if (add_corrected_gradient) add_seed(step_number, add_corrected_gradient);
      sweep.PullBackCorrection(*rollout.correction, step_number, time_of(step_number),
                               reader.start_positions(first_record(step_number)), record);
    }
    if (ends_step) add_seed(step_number, add_position_gradient);
    const bool has_forces = ends_step && add_pair_force_gradient;
    if (has_forces) {
      by_pair_forces.setZero(3 * static_cast<Eigen::Index>(simulator->scene().handles.nodes.size()), num_columns);
      add_pair_force_gradient(step_number, &by_pair_forces);
    }
    sweep.PullBackSolve(record, reader.start(i), has_forces ? &by_pair_forces : nullptr);
    if (step_number > 0 && i == first_record(step_number)) sweep.LeaveStep(time_of(--step_number));
  }
  add_seed(0, add_position_gradient);
  sweep.Finish();
  timer.reset();
  gradient.work.phases = simulator->step_solver().seconds() - before;
  return gradient;
}

}  // namespace clothid
