#include "sim/derivative/sensitivity.h"

#include <memory>
#include <stdexcept>
#include <utility>

#include "sim/cloth/cloth_model.h"
#include "sim/derivative/correction_derivative.h"
#include "sim/derivative/field_derivative.h"
#include "sim/derivative/handle_sweep.h"
#include "sim/derivative/second_start_derivative.h"
#include "sim/derivative/size_derivative.h"
#include "sim/derivative/step_derivative.h"
#include "sim/rollout/correction.h"
#include "sim/rollout/pair_forces.h"
#include "sim/rollout/record_reader.h"
#include "sim/rollout/segment.h"
#include "sim/rollout/simulator.h"
#include "sim/step/second_start.h"
#include "sim/step/step_solver.h"

namespace clothid {
namespace {

// Empty, or as many columns as others.
Eigen::Index NumStartColumns(const SensitivityDirections& directions) {
  Eigen::Index q = 0;
  for (const Eigen::MatrixXd* part : {&directions.initial_positions, &directions.initial_velocities,
                                      &directions.handle_offsets, &directions.fields}) {
    if (part->cols() > 0 && q > 0 && part->cols() != q) throw std::logic_error("directions of different numbers");
    q = std::max(q, part->cols());
  }
  return q;
}

// dx_0 and dv_0 [3 Nf x (p + q)].
StateColumns StartTangent(const SensitivityDirections& directions, const ClothModel& model) {
  const Eigen::Index p = static_cast<Eigen::Index>(directions.parameters.size());
  const Eigen::Index q = NumStartColumns(directions);
  StateColumns tangent;
  tangent.positions = tangent.velocities = Eigen::MatrixXd::Zero(3 * model.num_free(), p + q);
  if (directions.initial_positions.cols() > 0) {
    tangent.positions.rightCols(q) = model.GatherColumns(directions.initial_positions);
  }
  if (directions.initial_velocities.cols() > 0) {
    tangent.velocities.rightCols(q) = model.GatherColumns(directions.initial_velocities);
  }
  return tangent;
}

// What g gains not by dv, negated: -b, b = h (H + V) dx_n + N dx^ - M dv_n + dg/dtheta. `further_parts`: takes others
// off, from R as well.
StepColumns MomentumSide(const StateColumns& start, const std::vector<ParameterId>& parameters,
                         const std::function<void(StepColumns*)>& further_parts, const StepDerivative& step) {
  StepColumns right{step.TimesMass(start.velocities) - step.TimesStart(start.positions),
                    Eigen::MatrixXd::Zero(step.num_impulses(), start.positions.cols())};
  if (step.has_prediction()) {
    right.velocities -= step.TimesPrediction(start.positions + step.time_step() * start.velocities);
  }
  further_parts(&right);
  for (size_t p = 0; p < parameters.size(); ++p) {
    if (!IsOfContact(parameters[p].kind)) right.velocities.col(p) -= step.MomentumDerivative(parameters[p]);
  }
  return right;
}

// -[(I + S) b + X dx_n - dr/dtheta] from -b. Uses the contacts of the last Factor.
StepColumns RightSide(StepColumns right, const StateColumns& start, const std::vector<ParameterId>& parameters,
                      StepDerivative* step) {
  if (step->contacts().empty()) return right;
  step->jacobian().AddImpulse(&right.velocities);
  right -= step->TimesFrames(start.positions);
  for (size_t p = 0; p < parameters.size(); ++p) {
    if (!IsOfContact(parameters[p].kind)) continue;
    const StepColumns change = step->ImpulseDerivative(parameters[p]);
    right.velocities.col(p) += change.velocities;
    right.impulses.col(p) += change.impulses;
  }
  return right;
}

// Gives the steps their factor back, so that the states are those of `Simulate`, bit for bit.
class KeptFactor {
 public:
  explicit KeptFactor(StepJacobian* jacobian) : jacobian_(jacobian), factor_(jacobian->factor()) {}
  ~KeptFactor() { jacobian_->SetFactor(factor_); }
  KeptFactor(const KeptFactor&) = delete;
  KeptFactor& operator=(const KeptFactor&) = delete;

 private:
  StepJacobian* jacobian_;
  std::shared_ptr<const ReducedFactor> factor_;
};

// From the start of a step to its end.
class TangentSolver {
 public:
  TangentSolver(const Parameters& parameters, const std::vector<ParameterId>& ids, HandleTangent* handles,
                const FieldTangent& fields, double tolerance, Simulator* simulator)
      : parameters_(parameters),
        ids_(ids),
        handles_(handles),
        fields_(fields),
        sizes_(parameters, ids, *simulator),
        tolerance_(tolerance),
        simulator_(simulator) {}

  // Of one solve. `pair_forces`: the changes of those upon handles at its end [3H x (p + q)]; null: not asked for.
  void Advance(const StepRecord& record, const SolveStart& start, StateColumns* tangent,
               Eigen::MatrixXd* pair_forces) const {
    StepDerivative step(record, start, parameters_, simulator_, &sizes_);
    SolveToEnd(
        record, start, [](StepColumns*) {}, &step, tangent, pair_forces);
  }

  // Of both stages.
  void AdvanceInStages(const StepRecord& first, const StepRecord& second, const SolveStart& start,
                       StateColumns* tangent, Eigen::MatrixXd* pair_forces) const {
    const ClothModel& model = simulator_->model();
    SecondStart second_start;
    StateColumns first_end = *tangent, end;
    {
      StepDerivative step(first, start, parameters_, simulator_, &sizes_);
      const SolveChange change = Solve(
          first, start, [](StepColumns*) {}, &step, &first_end);
      second_start = StartSecondStage(model, parameters_.material, start, first.positions, first.velocities,
                                      first.time_step, step.contacts());
      const SecondStartDerivative derivative(first, start, step, parameters_, model);
      end = derivative.Times(*tangent, first_end);
      if (derivative.has_impacts()) {
        const Eigen::MatrixXd impulse = step.TimesUnknowns({first_end.velocities, change.impulses}) - change.momentum;
        derivative.SubtractImpacts(*tangent, first_end, {impulse, change.impulses}, &end);
        handles_->SubtractImpacts(first, derivative, &end.velocities);
        for (size_t p = 0; p < ids_.size(); ++p) {
          const Eigen::VectorXd* slopes = step.MassSlopes(ids_[p]);
          if (slopes != nullptr) derivative.SubtractMasses(static_cast<int>(p), *slopes, &end);
          if (IsPlacement(ids_[p].kind)) {
            end.velocities.col(p) -= derivative.MotionDerivative(step.MotionChanges(ids_[p]));
          }
        }
        fields_.SubtractMasses(derivative, &end);
      }
    }
    const SolveStart from{second_start.positions, second_start.velocities, &start.positions, &first.positions};
    StepDerivative step(second, from, parameters_, simulator_, &sizes_);
    const auto subtract_origins = [&](StepColumns* right) {
      if (step.has_origins()) right->velocities -= step.TimesOrigins(tangent->positions, first_end.positions);
    };
    SolveToEnd(second, from, subtract_origins, &step, &end, pair_forces);
    *tangent = std::move(end);
  }

 private:
  // -b of a solve and dr.
  struct SolveChange {
    Eigen::MatrixXd momentum, impulses;
  };

  // The solve that ends a step.
  void SolveToEnd(const StepRecord& record, const SolveStart& start,
                  const std::function<void(StepColumns*)>& further_parts, StepDerivative* step, StateColumns* tangent,
                  Eigen::MatrixXd* pair_forces) const {
    const Eigen::MatrixXd positions = pair_forces == nullptr ? Eigen::MatrixXd() : tangent->positions;
    const SolveChange change = Solve(record, start, further_parts, step, tangent);
    handles_->EndStep(record);
    if (pair_forces == nullptr) return;
    *pair_forces = step->TimesHandleForces(change.impulses, positions);
    handles_->AddContactForces(pair_forces);
  }

  // Takes `tangent` to the end of a solve. `further_parts` takes off -b what comes besides the handles.
  SolveChange Solve(const StepRecord& record, const SolveStart& start,
                    const std::function<void(StepColumns*)>& further_parts, StepDerivative* step,
                    StateColumns* tangent) const {
    const KeptFactor kept(&simulator_->step_solver().jacobian());
    StepColumns momentum = MomentumSide(
        *tangent, ids_,
        [&](StepColumns* right) {
          handles_->Subtract(record, start, parameters_, *step, right);
          fields_.Subtract(record, start, &right->velocities);
          further_parts(right);
        },
        *step);
    StepColumns solution;
    if (!SolveLinearized(record, momentum, *tangent, step, &solution)) {
      throw std::runtime_error("singular step Jacobian");
    }
    tangent->velocities = std::move(solution.velocities);
    tangent->positions += record.time_step * tangent->velocities;
    return {std::move(momentum.velocities), std::move(solution.impulses)};
  }

  // With the factor that the record keeps, or a new one, or by another method.
  bool SolveLinearized(const StepRecord& record, const StepColumns& momentum, const StateColumns& start,
                       StepDerivative* step, StepColumns* solution) const {
    const auto solve = [&] {
      return step->jacobian().Solve(RightSide(momentum, start, ids_, step), tolerance_, solution);
    };
    return (step->UseFactor(record.factor) && solve()) || (step->Factor(StepJacobian::Method::kReduced) && solve()) ||
           (step->FactorOtherwise() && solve());
  }

  const Parameters& parameters_;
  const std::vector<ParameterId>& ids_;
  HandleTangent* handles_;
  const FieldTangent& fields_;
  SizeDerivative sizes_;
  double tolerance_;
  Simulator* simulator_;
};

}  // namespace

SensitivityResult PushForward(const Parameters& parameters, int num_steps, const SensitivityDirections& directions,
                              const SensitivityVisitor& visitor, Simulator* simulator, const std::atomic<bool>* cancel,
                              const SensitivityOptions& options) {
  const Scene& scene = simulator->scene();
  const ClothModel& model = simulator->model();
  ValidateDomains(parameters, scene, "parameters");
  simulator->UseParameters(parameters);
  StepState state = StartState(scene, options.initial_positions, options.initial_velocities);
  Eigen::VectorXd positions = state.positions, velocities = state.velocities;  // at the end of the last solve
  StateColumns tangent = StartTangent(directions, model);
  HandleTangent handles(directions.handle_offsets, options.handle_offsets, model);
  const FieldTangent fields(directions.fields, parameters, model);
  const TangentSolver solver(parameters, directions.parameters, &handles, fields,
                             options.adjoint_tolerance.value_or(scene.solver.adjoint_tolerance), simulator);
  CorrectionTangent corrections(options.correction.get(), parameters, directions.parameters, &handles, model);
  const auto time_of = [&](int step) { return scene.start_time + step * scene.time_step; };
  const auto visit = [&](int step, const SensitivityVisitor& told) {
    Eigen::MatrixXd all = model.ScatterColumns(tangent.positions);
    handles.SetRows(time_of(step), &all);
    told(step, positions, all);
  };
  visit(0, visitor);
  Eigen::MatrixXd pair_forces;
  Eigen::MatrixXd* const asked_forces = options.pair_force_visitor ? &pair_forces : nullptr;
  const StepVisitor advance = [&](int step, std::vector<StepRecord> records) {
    corrections.StartStep(step, time_of(step - 1), positions, tangent);
    for (std::size_t i = 0; i < records.size(); ++i) {
      if (records[i].ends_step()) {
        solver.Advance(records[i], {positions, velocities}, &tangent, asked_forces);
      } else {
        solver.AdvanceInStages(records[i], records[i + 1], {positions, velocities}, &tangent, asked_forces);
        ++i;
      }
      const bool is_last = i + 1 == records.size();
      if (is_last && asked_forces != nullptr) {
        options.pair_force_visitor(step, PairForces(model, parameters, records[i]), pair_forces);
      }
      // The last ones are read again where they are corrected.
      positions = is_last ? records[i].positions : std::move(records[i].positions);
      velocities = is_last ? records[i].velocities : std::move(records[i].velocities);
    }
    visit(step, visitor);
    if (!corrections.EndStep(step, records.back(), &tangent)) return;
    positions = records.back().correction->positions;
    velocities = records.back().correction->velocities;
    if (options.corrected_visitor) visit(step, options.corrected_visitor);
  };
  Segment segment;
  segment.handle_offsets = options.handle_offsets;
  segment.last_step = num_steps;
  segment.step_tolerance = options.step_tolerance;
  segment.correction = options.correction.get();
  segment.cancel = cancel;
  SegmentOutcome outcome = AdvanceSegment(parameters, segment, advance, simulator, &state);
  return {outcome.counts, std::move(outcome.failure)};
}

void PushForward(const Rollout& rollout, const SensitivityDirections& directions, const SensitivityVisitor& visitor,
                 Simulator* simulator, std::optional<double> adjoint_tolerance,
                 const PairForceVisitor& pair_force_visitor, const SensitivityVisitor& corrected_visitor) {
  RecordReader reader(rollout, simulator);
  const Scene& scene = simulator->scene();
  const ClothModel& model = simulator->model();
  StateColumns tangent = StartTangent(directions, model);
  HandleTangent handles(directions.handle_offsets, &rollout.handle_offsets, model);
  const FieldTangent fields(directions.fields, rollout.parameters, model);
  const TangentSolver solver(rollout.parameters, directions.parameters, &handles, fields,
                             adjoint_tolerance.value_or(scene.solver.adjoint_tolerance), simulator);
  CorrectionTangent corrections(rollout.correction.get(), rollout.parameters, directions.parameters, &handles, model);
  Eigen::VectorXd positions = rollout.initial_positions, velocities = rollout.initial_velocities;
  const auto time_of = [&](int step) { return scene.start_time + step * scene.time_step; };
  const auto visit = [&](int step, const SensitivityVisitor& told) {
    Eigen::MatrixXd all = model.ScatterColumns(tangent.positions);
    handles.SetRows(time_of(step), &all);
    told(step, positions, all);
  };
  visit(0, visitor);
  corrections.StartStep(1, time_of(0), positions, tangent);
  Eigen::MatrixXd pair_forces;
  Eigen::MatrixXd* const asked_forces = pair_force_visitor ? &pair_forces : nullptr;
  int step = 1;
  for (int i = 0; i < static_cast<int>(rollout.records.size()); ++i) {
    const StepRecord& record = reader.record(i);
    if (record.ends_step()) {
      solver.Advance(record, {positions, velocities}, &tangent, asked_forces);
    } else {
      solver.AdvanceInStages(record, reader.record(i + 1), {positions, velocities}, &tangent, asked_forces);
      ++i;
    }
    const StepRecord& end = reader.record(i);
    positions = end.positions;
    velocities = end.velocities;
    if (rollout.last_record[step - 1] != i) continue;
    if (pair_force_visitor) pair_force_visitor(step, PairForces(model, rollout.parameters, end), pair_forces);
    visit(step, visitor);
    if (corrections.EndStep(step, end, &tangent)) {
      positions = end.correction->positions;
      velocities = end.correction->velocities;
      if (corrected_visitor) visit(step, corrected_visitor);
    }
    ++step;
    corrections.StartStep(step, time_of(step - 1), positions, tangent);
  }
}

}  // namespace clothid
