// The rows that a stage of a fit gives to Ceres: of one parameter block, the unknowns that are free.
#ifndef CLOTHID_IDENTIFY_FIT_STAGE_ROWS_H_
#define CLOTHID_IDENTIFY_FIT_STAGE_ROWS_H_

#include <ceres/cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "identify/problem/evaluator.h"
#include "identify/problem/problem.h"
#include "identify/problem/unknown_basis.h"

namespace clothid {

// Levenberg-Marquardt of Ceres on one thread: the evaluator has its own.
ceres::Solver::Options StageSolver(double trust_region, int max_iterations, double parameter_tolerance);

// What both kinds of rows have in common: a point is  z = rest + V x  over the free coordinates x of a basis.
class StageRows : public ceres::CostFunction {
 public:
  // Where the free coordinates stand among those of the basis [p + c].
  const std::vector<int>& free() const { return free_; }
  Eigen::VectorXd FreeCoordinates(const Eigen::VectorXd& unknowns) const { return basis_.Restrict(unknowns)(free_); }
  Eigen::VectorXd Unknowns(const double* free) const;
  // A problem of these rows alone, which it does not own, with the bounds of the parameters; `free` is its memory.
  std::unique_ptr<ceres::Problem> MakeCeresProblem(double* free);

 protected:
  // Keeps references to all but `unknowns`, the point that fixes what is not free.
  StageRows(const FitProblem& problem, const UnknownBasis& basis, std::vector<int> free,
            const Eigen::VectorXd& unknowns, Precision precision, FitEvaluator* evaluator);

  const FitProblem& problem_;
  const UnknownBasis& basis_;
  std::vector<int> free_;
  Eigen::VectorXd rest_;  // of z, what V does not move
  Precision precision_;
  FitEvaluator* evaluator_;
};

// Of the parameters alone: every point has rows of its own (`EvaluatedRows`).
class FreshRows : public StageRows {
 public:
  // `has_exact_rows`: every point gets exact rows along with its rollout.
  FreshRows(const FitProblem& problem, const UnknownBasis& basis, const Eigen::VectorXd& unknowns, Precision precision,
            bool has_exact_rows, FitEvaluator* evaluator);

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  bool has_exact_rows_;
};

// What a Gauss-Newton step promises to lower the cost by.
struct PredictedDecrease {
  double total = 0.0;          // by all free coordinates together
  double of_parameters = 0.0;  // by moving the parameters, the others eliminated
  int num_free = 1;
};

// Of many unknowns. A forward sweep with a column for each gives their Gauss-Newton matrix H = J^T J, at the price of
// many rollouts; a reverse sweep gives the gradient g at the price of one. H changes little near the solution, so it is
// kept while the point moves and g is always new: with
//   r = (0, .., 0, sqrt(2 L)),   J = [C^T; g^T/sqrt(2 L)],   C C^T = H' - g' g'^T/(2 L')
// (primes: where H was made) J^T r = g, and J^T J = H with the part of r made new.
class LaggedRows : public StageRows {
 public:
  // `hessian` H [(p + c) x (p + c)] over the basis, with all priors; `gradient` [p + n + f] and `cost` at `unknowns`.
  // Parameters that are frozen or pushed against a bound stay: else the bounds would cut every step short for all.
  LaggedRows(const FitProblem& problem, const UnknownBasis& basis, const Eigen::MatrixXd& hessian,
             const Eigen::VectorXd& gradient, double cost, const Eigen::VectorXd& unknowns, Precision precision,
             FitEvaluator* evaluator);

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

  // From there; parameters that are held by then, and those that do nothing, stay. `gradient` [p + n + f].
  PredictedDecrease DecreaseAt(const Eigen::VectorXd& unknowns, const Eigen::VectorXd& gradient) const;

  // Of the last point with a Jacobian, at first of `unknowns`; the gradient of all unknowns.
  const Eigen::VectorXd& last_gradient() const { return gradient_; }
  double last_cost() const { return cost_; }

 private:
  Eigen::MatrixXd hessian_;  // H over the free coordinates
  Eigen::MatrixXd root_;     // C^T
  mutable Eigen::VectorXd gradient_;
  mutable double cost_ = 0.0;
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIT_STAGE_ROWS_H_
