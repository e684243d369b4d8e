#include "sim/derivative/sensitivity.h"

#include <stdexcept>

#include "sim/cloth/cloth_model.h"
#include "sim/derivative/step_derivative.h"
#include "sim/rollout/simulator.h"
#include "sim/step/step.h"

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

void AdvanceTangent(const StepRecord& record, const Eigen::VectorXd& start_positions,
                    const Eigen::VectorXd& start_velocities, const Parameters& parameters,
                    const std::vector<ParameterId>& ids, Simulator* simulator, Tangent* tangent) {
  StepDerivative step(record, start_positions, start_velocities, parameters, simulator);
  const KeptFactor kept(&simulator->step_solver().jacobian());
  const double tolerance = simulator->scene().solver.adjoint_tolerance;
  Eigen::MatrixXd dv;
  for (const auto method : {StepJacobian::Method::kReduced, StepJacobian::Method::kLu}) {
    if (!step.Factor(method)) continue;
    if (!step.jacobian().Solve(RightSide(*tangent, ids, record, &step), tolerance, &dv)) continue;
    tangent->velocities = dv;
    tangent->positions += record.time_step * dv;
    return;
  }
  throw std::runtime_error("singular step Jacobian");
}

}  // namespace

SensitivityResult PushForward(const Parameters& parameters, int num_steps, const SensitivityDirections& directions,
                              const SensitivityVisitor& visitor, Simulator* simulator,
                              const std::atomic<bool>* cancel) {
  const Scene& scene = simulator->scene();
  const ClothModel& model = simulator->model();
  ValidateParameters(parameters, scene, "parameters");
  SensitivityResult result;
  Tangent tangent = StartTangent(directions, model);
  Eigen::VectorXd positions = scene.initial_positions, velocities = scene.initial_velocities;
  std::vector<ContactRecord> contacts;
  std::vector<StepRecord> records;
  simulator->step_solver().Reset(/*end_with_factors=*/false);
  visitor(0, positions, model.ScatterColumns(tangent.positions));
  for (int step = 1; step <= num_steps; ++step) {
    if (cancel != nullptr && cancel->load()) {
      result.failure = StepFailure();
      result.failure->step = step;
      result.failure->reason = "was cancelled";
      return result;
    }
    if (!AdvanceStep(parameters, step, positions, velocities, /*followed=*/nullptr, simulator, &records, &result.counts,
                     &result.failure)) {
      return result;
    }
    for (const StepRecord& record : records) {
      AdvanceTangent(record, positions, velocities, parameters, directions.parameters, simulator, &tangent);
      if (model.has_contact()) {
        const bool is_first = step == 1 && &record == &records.front();
        CountContactChanges(is_first ? record.contacts : contacts, record.contacts, &result.counts);
        contacts = record.contacts;
      }
      positions = record.positions;
      velocities = record.velocities;
    }
    visitor(step, positions, model.ScatterColumns(tangent.positions));
  }
  return result;
}

}  // namespace clothid
