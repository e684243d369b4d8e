#include "sim/derivative/adjoint_solver.h"

#include <optional>
#include <stdexcept>

#include "sim/base/error.h"
#include "sim/derivative/adjoint_iteration.h"
#include "sim/rollout/simulator.h"
#include "sim/step/step_solver.h"

namespace clothid {
namespace {

// As in the authors' code, which then hands over to LU.
constexpr int kMaxIterations = 400;

}  // namespace

AdjointSolver::AdjointSolver(const AdjointOptions& options, const Parameters& parameters, Simulator* simulator)
    : method_(options.method),
      use_kept_factors_(options.use_kept_factors),
      threshold_(options.threshold.value_or(simulator->scene().solver.adjoint_tolerance)),
      parameters_(parameters),
      simulator_(simulator) {}

void AdjointSolver::Solve(const StepRecord& record, const StepColumns& right, StepDerivative* step, StepColumns* z,
                          Eigen::MatrixXd* y, AdjointWork* work) {
  if (step->num_impulses() > 0 && method_ != AdjointMethod::kReduced) {
    throw Error(ErrorKind::kUsage, "contacts of the cloth with itself: expected the adjoint method \"reduced\"");
  }
  ++work->solves;
  if (SolveByMethod(record, right, step, z, y, work)) return;
  ++work->failed_solves;
  const ScopedTimer timer(&work->fallback_seconds);
  if (!step->FactorOtherwise() || !SolveByStepJacobian(right, step, z, y, work)) {
    throw std::runtime_error("singular step Jacobian");
  }
}

bool AdjointSolver::SolveByMethod(const StepRecord& record, const StepColumns& right, StepDerivative* step,
                                  StepColumns* z, Eigen::MatrixXd* y, AdjointWork* work) {
  switch (method_) {
    case AdjointMethod::kReduced:
      return (use_kept_factors_ && step->UseFactor(record.factor) && SolveByStepJacobian(right, step, z, y, work)) ||
             (step->Factor(StepJacobian::Method::kReduced) && SolveByStepJacobian(right, step, z, y, work));
    case AdjointMethod::kLu:
      return step->Factor(StepJacobian::Method::kLu) && SolveByStepJacobian(right, step, z, y, work);
    case AdjointMethod::kFixedPoint:
    case AdjointMethod::kSystemGmres:
      z->impulses = right.impulses;  // none
      return SolveByIteration(record, *step, right.velocities, &z->velocities, y, work);
  }
  return false;
}

bool AdjointSolver::SolveByStepJacobian(const StepColumns& right, StepDerivative* step, StepColumns* z,
                                        Eigen::MatrixXd* y, AdjointWork* work) {
  const bool solved = step->jacobian().SolveTransposed(right, threshold_, z, y);
  work->iterations += step->jacobian().iterations();
  return solved;
}

bool AdjointSolver::SolveByIteration(const StepRecord& record, const StepDerivative& step, const Eigen::MatrixXd& right,
                                     Eigen::MatrixXd* z, Eigen::MatrixXd* y, AdjointWork* work) {
  PhaseSeconds& seconds = simulator_->step_solver().jacobian().seconds();
  const SystemMatrixFactor& system_matrix = SystemMatrixOf(record.time_step);
  std::optional<AdjointSystem> system;
  {
    const ScopedTimer timer(&seconds.contact);
    system.emplace(simulator_->model(), step.contacts().nodes, record.velocities, parameters_,
                   simulator_->step_solver().hessian());
  }
  const ScopedTimer timer(&seconds.solution);
  const LinearMap multiply = [&](const Eigen::MatrixXd& v) { return system->Multiply(v); };
  const LinearMap precondition = [&](const Eigen::MatrixXd& v) { return system_matrix.Solve(v); };
  if (method_ == AdjointMethod::kFixedPoint) {
    const IterationResult result = IterateFixedPoint(multiply, precondition, right, threshold_, kMaxIterations, z);
    work->iterations += result.iterations;
    if (!result.converged) return false;
  } else {
    const GmresResult result = Gmres(multiply, precondition, right, threshold_, {kMaxIterations}, z);
    work->iterations += result.iterations;
    if (!result.converged) return false;
  }
  system->Finish(z, y);
  return true;
}

const SystemMatrixFactor& AdjointSolver::SystemMatrixOf(double time_step) {
  if (system_matrix_ == nullptr || system_matrix_->time_step() != time_step) {
    const ScopedTimer timer(&simulator_->step_solver().jacobian().seconds().factorization);
    system_matrix_ = std::make_unique<SystemMatrixFactor>(simulator_->model(), parameters_.material, time_step);
  }
  return *system_matrix_;
}

}  // namespace clothid
