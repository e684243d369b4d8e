// How far the model errs in the recordings of a fit (identify/uncertainty/model_error_estimate.h).
#ifndef CLOTHID_IDENTIFY_PROBLEM_MODEL_ERRORS_H_
#define CLOTHID_IDENTIFY_PROBLEM_MODEL_ERRORS_H_

#include <vector>

#include "costs/prediction/robust_loss.h"
#include "datasets/observation/model_error.h"
#include "identify/problem/evaluator.h"
#include "identify/problem/problem.h"

namespace clothid {

// Per recording: none.
std::vector<ModelError> NoModelErrors(const FitProblem& problem);

// Per recording, of the residuals of predictions and forces (see FitPoint), which gross errors make no larger than
// `loss` lets them.
std::vector<ModelError> EstimateModelErrors(const RobustLoss& loss, const FitProblem& problem,
                                            const std::vector<Eigen::MatrixXd>& predicted,
                                            const std::vector<Eigen::MatrixXd>& forces);
bool IsZero(const std::vector<ModelError>& errors);

// Whether weights that follow the first would hardly change with the second.
bool IsSameError(const std::vector<ModelError>& first, const std::vector<ModelError>& second);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PROBLEM_MODEL_ERRORS_H_
