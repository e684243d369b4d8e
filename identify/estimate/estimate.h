// What a fit says of the best point that it has evaluated.
#ifndef CLOTHID_IDENTIFY_ESTIMATE_ESTIMATE_H_
#define CLOTHID_IDENTIFY_ESTIMATE_ESTIMATE_H_

#include "costs/prediction/robust_loss.h"
#include "identify/estimate/fit_summary.h"
#include "identify/problem/evaluator.h"
#include "identify/problem/problem.h"

namespace clothid {

// Parameters, errors and predictions of the evaluator's first and best point, which must be valid. Leaves the rest of
// `summary` as it is.
void FillEstimate(const FitProblem& problem, const FitEvaluator& evaluator, FitSummary* summary);

// What is believed of fields, as rows below those of the recordings, in the columns from `first_column` on: it is no
// matter of the parameters' own priors.
void AddFieldRows(const FitProblem& problem, const Eigen::MatrixXd& combinations, Eigen::Index first_column,
                  Eigen::MatrixXd* jacobian);

// Along the parameters alone, with which all else moves by the columns of `follow` [(n + f) x p]; with those rows. By
// one forward sweep at `coordinates`; false where it fails.
bool LinearizeAlong(const FitProblem& problem, const Eigen::VectorXd& coordinates, const Eigen::MatrixXd& follow,
                    FitEvaluator* evaluator, Linearization* along);

// The autocorrelation from frame to frame at the estimate, of the residuals as the cost weighs them: gross errors,
// which come and go, hide how the others are correlated. Points of clouds count as they are.
double WeightedAutocorrelation(const RobustLoss& loss, const FitProblem& problem, const FitSummary& summary);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_ESTIMATE_ESTIMATE_H_
