#include "sim/derivative/sensitivity.h"

#include <stdexcept>
#include <utility>

#include "sim/cloth/cloth_model.h"
#include "sim/derivative/step_derivative.h"
#include "sim/rollout/segment.h"
#include "sim/rollout/simulator.h"
#include "sim/step/step_solver.h"

namespace clothid {
namespace {

// The columns of dx_n and dv_n over the free nodes [3 Nf x (p + q)].
struct Tangent {
  Eigen::MatrixXd positions, velocities;
};

Tangent StartTangent(const SensitivityDirections& directions, const ClothModel& model) {
  const Eigen::Index p = static_cast<Eigen::Index>(directions.parameters.size());
  const Eigen::Index q = std::max(directions.initial_positions.cols(), directions.initial_velocities.cols());
  Tangent tangent;
  tangent.positions = tangent.velocities = Eigen::MatrixXd::Zero(3 * model.num_free(), p + q);
  if (directions.initial_positions.cols() > 0) {
    tangent.positions.rightCols(q) = model.GatherColumns(directions.initial_positions);
  }
  if (directions.initial_velocities.cols() > 0) {
    tangent.velocities.rightCols(q) = model.GatherColumns(directions.initial_velocities);
  }
  return tangent;
}

// (I + S)(h (H + V) dx_n - M dv_n + dg/dtheta) + X dx_n - dr/dtheta, negated. Uses the contacts of the last Factor.
Eigen::MatrixXd RightSide(const Tangent& tangent, const std::vector<ParameterId>& parameters, const StepRecord& record,
                          StepDerivative* step) {
  Eigen::MatrixXd right = step->TimesMass(tangent.velocities) - step->TimesStart(tangent.positions);
  for (size_t p = 0; p < parameters.size(); ++p) {
    if (parameters[p].kind != ParameterKind::kFriction) right.col(p) -= step->MomentumDerivative(parameters[p]);
  }
  if (record.contacts.empty()) return right;
  step->jacobian().AddImpulse(&right);
  right -= step->TimesFrames(tangent.positions);
  for (size_t p = 0; p < parameters.size(); ++p) {
    if (parameters[p].kind == ParameterKind::kFriction) right.col(p) += step->ImpulseDerivative(parameters[p]);
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

// From the start of a solve to its end.
class TangentSolver {
 public:
  TangentSolver(const Parameters& parameters, const std::vector<ParameterId>& ids, double tolerance,
                Simulator* simulator)
      : parameters_(parameters), ids_(ids), tolerance_(tolerance), simulator_(simulator) {}

  void Advance(const StepRecord& record, const Eigen::VectorXd& start_positions,
               const Eigen::VectorXd& start_velocities, Tangent* tangent) const {
    StepDerivative step(record, start_positions, start_velocities, parameters_, simulator_);
    const KeptFactor kept(&simulator_->step_solver().jacobian());
    Eigen::MatrixXd dv;
    for (const auto method : {StepJacobian::Method::kReduced, StepJacobian::Method::kLu}) {
      if (!step.Factor(method)) continue;
      if (!step.jacobian().Solve(RightSide(*tangent, ids_, record, &step), tolerance_, &dv)) continue;
      tangent->velocities = dv;
      tangent->positions += record.time_step * dv;
      return;
    }
    throw std::runtime_error("singular step Jacobian");
  }

 private:
  const Parameters& parameters_;
  const std::vector<ParameterId>& ids_;
  double tolerance_;
  Simulator* simulator_;
};

}  // namespace

SensitivityResult PushForward(const Parameters& parameters, int num_steps, const SensitivityDirections& directions,
                              const SensitivityVisitor& visitor, Simulator* simulator, const std::atomic<bool>* cancel,
                              const SensitivityOptions& options) {
  const Scene& scene = simulator->scene();
  const ClothModel& model = simulator->model();
  ValidateParameters(parameters, scene, "parameters");
  StepState state = StartState(scene, options.initial_velocities);
  Eigen::VectorXd positions = state.positions, velocities = state.velocities;  // at the end of the last solve
  Tangent tangent = StartTangent(directions, model);
  const TangentSolver solver(parameters, directions.parameters,
                             options.adjoint_tolerance.value_or(scene.solver.adjoint_tolerance), simulator);
  visitor(0, positions, model.ScatterColumns(tangent.positions));
  const StepVisitor advance = [&](int step, std::vector<StepRecord> records) {
    for (StepRecord& record : records) {
      solver.Advance(record, positions, velocities, &tangent);
      positions = std::move(record.positions);
      velocities = std::move(record.velocities);
    }
    visitor(step, positions, model.ScatterColumns(tangent.positions));
  };
  Segment segment;
  segment.last_step = num_steps;
  segment.step_tolerance = options.step_tolerance;
  segment.cancel = cancel;
  SegmentOutcome outcome = AdvanceSegment(parameters, segment, advance, simulator, &state);
  return {outcome.counts, std::move(outcome.failure)};
}

}  // namespace clothid
