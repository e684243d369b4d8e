// How well a solve of a rollout satisfies its equations, seen by a step problem of its own.
#ifndef CLOTHID_TESTS_SIM_STEP_STEP_RESIDUAL_H_
#define CLOTHID_TESTS_SIM_STEP_STEP_RESIDUAL_H_

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>

#include "sim/cloth/cloth_model.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/step/step_problem.h"

namespace clothid {

struct StepResidual {
  double relative = 0.0;   // of the recorded velocities
  double tolerance = 0.0;  // what was asked for: the rollout's, or the rounding floor where that is larger
  double scale = 0.0;      // N s, what both are relative to
};

// Of the solve that record `i` ends.
inline StepResidual ResidualOf(const Rollout& rollout, std::size_t i, Simulator* simulator) {
  const StepRecord& record = rollout.records[i];
  const Eigen::VectorXd& x = i == 0 ? rollout.initial_positions : rollout.records[i - 1].positions;
  const Eigen::VectorXd& v = i == 0 ? rollout.initial_velocities : rollout.records[i - 1].velocities;
  const StepProblem problem(simulator->model(), rollout.parameters, {x, v}, record.times(),
                            &simulator->step_workspace());
  StepPoint point;
  problem.Evaluate(simulator->model().Gather(record.velocities), &point);
  return {point.relative_residual, std::max(rollout.step_tolerance, problem.RoundingFloor(point)), point.scale};
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_STEP_STEP_RESIDUAL_H_
