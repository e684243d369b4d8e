// The undamped step of the Gauss-Newton model of a fit, and how far it is.
#ifndef CLOTHID_IDENTIFY_PROBLEM_GAUSS_NEWTON_H_
#define CLOTHID_IDENTIFY_PROBLEM_GAUSS_NEWTON_H_

#include <Eigen/Core>
#include <optional>

#include "identify/problem/evaluator.h"
#include "identify/problem/problem.h"

namespace clothid {

// d = -H^-1 g of the model, [p], over the blocks that may move: not frozen, with influence, not pushed against a bound.
// Zero where nothing may move; nothing where the model is singular.
std::optional<Eigen::VectorXd> GaussNewtonStep(const FitProblem& problem, const QuadraticModel& model);

// Whether a step from `coordinates` changes every parameter by no more than `length` resolutions
// (ParameterBlock::Resolution).
bool IsShort(const FitProblem& problem, const Eigen::VectorXd& coordinates, const Eigen::VectorXd& step, double length);

// Whether the step is no longer than `length` resolutions, or lowers the cost by no more than this share. Ceres looks
// at its tolerances after the rollout of a step; this looks before.
bool NextStepIsNegligible(const FitProblem& problem, const QuadraticModel& model, double length,
                          double function_tolerance);

// Where the step leads, within the bounds; stays where there is none or it is longer than `length` resolutions.
Eigen::VectorXd NextPoint(const FitProblem& problem, const QuadraticModel& model, double length);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PROBLEM_GAUSS_NEWTON_H_
