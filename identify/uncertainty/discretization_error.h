// How far an estimate is off because time step and mesh are not infinitely fine, and its interval with that.
//
// An integrator and a mesh have errors of their own, and a fit hides them in its parameters: backward Euler damps by
// itself, coarse triangles are too stiff. The covariance of the noise knows nothing of it. With estimates q of the same
// recording at the step h, at 2h and at h/2, and errors that fall like h^p, the error at h is
//   p = log2((q_2h - q_h)/(q_h - q_h/2)),   |q_h - q_h/2| 2^p/(2^p - 1).
// The order p is taken where it lies within 1 and 2, the orders of the integrators and of what impacts leave of them.
// Elsewhere, or where the differences have other signs, or without an estimate at 2h, there is no clear order: p = 1,
// which gives twice the difference, the most of those.
//
// Of the mesh there is one refinement, h the length of its edges, and p = 1: with one refinement no order can be
// observed, and the true one is near it. On `wind`, recorded on a mesh of 61 x 61 nodes, fits on 16 x 16 and 31 x 31
// give orders of 0.95 for k_stretch and 1.3 for k_bend; linear triangles have 2 where the cloth is smooth, but not at
// handles, at the edge of a contact and where it buckles.
//
// The errors enter the interval as standard deviations, each with the 1.96 of a normal distribution, and independent of
// the noise and of each other: half its width in q is
//   sqrt((quantile95 std)^2 + (1.96 step error)^2 + (1.96 mesh error)^2 + (1.96 drift)^2 + (1.96 stall)^2),
// the last where a fit stalled near the minimum of its model (identify/uncertainty/uncertainty.h).
// They are biases, not chance: more recordings do not make them smaller.
#ifndef CLOTHID_IDENTIFY_UNCERTAINTY_DISCRETIZATION_ERROR_H_
#define CLOTHID_IDENTIFY_UNCERTAINTY_DISCRETIZATION_ERROR_H_

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "identify/uncertainty/uncertainty.h"

namespace clothid {

struct DiscretizationError {
  double error = std::numeric_limits<double>::quiet_NaN();  // of q, at the step or mesh of the fit; NaN: not known
  double order = std::numeric_limits<double>::quiet_NaN();  // the one observed; NaN: no clear order
};

// From estimates of q at h, at h/2 and at 2h; NaN: not known.
DiscretizationError ErrorOfStep(double at_step, double at_half, double at_double);
// From estimates of q on the mesh and on the refined one; NaN: not known.
DiscretizationError ErrorOfMesh(double on_mesh, double on_refined);

// The intervals again with the errors of the estimates `coordinates` [p]; `step` and `mesh` [p], or empty: not looked
// at: errors of the step that were estimated stay as they are. An error that is not known leaves the interval to the
// others.
void AddDiscretizationErrors(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                             const std::vector<DiscretizationError>& step, const std::vector<DiscretizationError>& mesh,
                             Uncertainty* uncertainty);

// Errors of the step that are only estimated (identify/checks/step_error.h): the intervals get wider by them, but what
// they tell stays judged as it was.
void AddEstimatedStepErrors(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                            const std::vector<DiscretizationError>& step, Uncertainty* uncertainty);

// The intervals once more with how far the estimates drift where rollouts that the recordings correct get a longer
// memory (identify/problem/memory_trial.h), [p] of q: an error of the model, which enters as those of step and mesh do.
void AddMemoryErrors(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                     const Eigen::VectorXd& drift, Uncertainty* uncertainty);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_UNCERTAINTY_DISCRETIZATION_ERROR_H_
