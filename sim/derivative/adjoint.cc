#include "sim/derivative/adjoint.h"

#include <memory>
#include <utility>

#include "sim/cloth/cloth_model.h"
#include "sim/derivative/adjoint_solver.h"
#include "sim/derivative/field_derivative.h"
#include "sim/derivative/handle_coupling.h"
#include "sim/derivative/second_start_derivative.h"
#include "sim/derivative/size_derivative.h"
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
    if (!IsOfContact(parameters[p].kind)) {
      gradient->row(p) -= step.MomentumDerivative(parameters[p]).transpose() * y;
    } else if (!record.contacts.empty()) {
      gradient->row(p) += step.ImpulseDerivative(parameters[p]).transpose() * z;
    }
  }
}

// The same through the contacts of the cloth with itself, whose equations have the multipliers `rho`.
void AddPairGradient(const std::vector<ParameterId>& parameters, const Eigen::MatrixXd& rho,
                     const PairDerivative& pairs, Eigen::MatrixXd* gradient) {
  for (size_t p = 0; p < parameters.size(); ++p) {
    if (parameters[p].kind == ParameterKind::kSelfFriction) {
      gradient->row(p) -= pairs.FrictionDerivative().transpose() * rho;
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

  // Through a solve, y = (I + S)^T z of it.
  void AddSolve(const StepRecord& record, const SolveStart& start, const Eigen::MatrixXd& y) {
    if (coupling_ == nullptr) return;
    coupling_->SetStep(record, start, parameters_);
    for (int place = 0; place < coupling_->num_places(); ++place) {
      Add(coupling_->time(place), coupling_->TimesTransposed(place, -y));
    }
  }

  Eigen::MatrixXd& values() { return values_; }

 private:
  void Add(double time, const Eigen::MatrixXd& rows) {
    const Eigen::VectorXd weights = offsets_.KnotWeights(time);
    for (Eigen::Index k = 0; k < weights.size(); ++k) {
      if (weights[k] != 0.0) values_.middleRows(k * rows.rows(), rows.rows()) += weights[k] * rows;
    }
  }

  const HandlePath& offsets_;
  const std::vector<int>& nodes_;
  const Parameters& parameters_;
  std::unique_ptr<HandleCoupling> coupling_;
  Eigen::MatrixXd values_;
};

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

  void PullBackSolve(const StepRecord& record, const SolveStart& start) {
    StepDerivative step(record, start, parameters_, simulator_, &sizes_);
    Eigen::MatrixXd by_impulse, by_pairs;  // by r_1 and by r of pairs, where impacts make them count
    if (record.stage == Stage::kFirst) by_impulse = LeaveSecondStart(record, start, step, &by_pairs);
    Eigen::MatrixXd w = lambda_.velocities + record.time_step * lambda_.positions, z, y, rho;
    if (by_impulse.size() > 0) w += step.TimesVelocity(by_impulse);
    if (step.pairs() == nullptr) {
      solver_.Solve(record, w, &step, &z, &y, &gradient_->work);
    } else {
      solver_.SolveWithPairs(w, by_impulse, by_pairs, &step, &z, &y, &rho, &gradient_->work);
    }
    if (by_impulse.size() > 0) y -= by_impulse;
    AddParameterGradient(record, ids_, z, y, step, &gradient_->parameters);
    if (step.pairs() != nullptr) AddPairGradient(ids_, rho, *step.pairs(), &gradient_->parameters);
    handles_.AddSolve(record, start, y);
    fields_.AddSolve(record, start, y);
    lambda_.velocities = step.TimesMass(y);
    lambda_.positions -= step.TimesStartTransposed(y);
    if (step.has_prediction()) {
      const Eigen::MatrixXd by_prediction = step.TimesPredictionTransposed(y);
      lambda_.velocities -= record.time_step * by_prediction;
      lambda_.positions -= by_prediction;
    }
    if (!record.contacts.empty()) lambda_.positions -= step.TimesFramesTransposed(z);
    if (step.pairs() != nullptr) lambda_.positions -= step.pairs()->TimesGeometryTransposed(rho);
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
  // `by_pairs`: likewise by the impulses of pairs.
  Eigen::MatrixXd LeaveSecondStart(const StepRecord& first, const SolveStart& start, const StepDerivative& step,
                                   Eigen::MatrixXd* by_pairs) {
    const SecondStartDerivative second(first, start, step, parameters_, simulator_->model());
    second.AddTransposed(by_second_, &by_start_, &lambda_);
    if (!second.has_impacts()) return {};
    fields_.AddSecondStart(second, by_second_);
    for (size_t p = 0; p < ids_.size(); ++p) {
      const Eigen::VectorXd* slopes = step.MassSlopes(ids_[p]);
      if (slopes != nullptr) gradient_->parameters.row(p) += second.MassGradient(*slopes, by_second_);
      if (IsPlacement(ids_[p].kind)) {
        gradient_->parameters.row(p) -=
            second.MotionDerivative(step.MotionChanges(ids_[p])).transpose() * by_second_.velocities;
      }
    }
    return second.AddImpactsTransposed(by_second_, &by_start_, &lambda_, by_pairs);
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
};

}  // namespace

RolloutGradient PullBack(const Rollout& rollout, const std::vector<ParameterId>& parameters, int num_columns,
                         const AddPositionGradient& add_position_gradient, Simulator* simulator,
                         const AdjointOptions& options) {
  simulator->UseParameters(rollout.parameters);
  const PhaseSeconds before = simulator->step_solver().seconds();
  RolloutGradient gradient;
  std::optional<ScopedTimer> timer(&gradient.work.total_seconds);
  ReverseSweep sweep(rollout, parameters, num_columns, options, simulator, &gradient);
  Eigen::MatrixXd seed(3 * simulator->model().num_nodes(), num_columns);
  const auto add_seed = [&](int step) {
    seed.setZero();
    add_position_gradient(step, &seed);
    sweep.AddSeed(rollout.start_time + step * rollout.time_step, seed);
  };

  RecordReader reader(rollout, simulator);
  int step_number = rollout.num_steps();
  for (int i = static_cast<int>(rollout.records.size()) - 1; i >= 0; --i) {
    const StepRecord& record = reader.record(i);
    if (step_number > 0 && rollout.last_record[step_number - 1] == i) add_seed(step_number--);
    sweep.PullBackSolve(record, reader.start(i));
  }
  add_seed(0);
  sweep.Finish();
  timer.reset();
  gradient.work.phases = simulator->step_solver().seconds() - before;
  return gradient;
}

}  // namespace clothid
