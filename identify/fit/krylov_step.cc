#include "identify/fit/krylov_step.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <vector>

#include "sim/matrix/dense.h"

namespace clothid {
namespace {

constexpr int kMostProducts = 40;      // of one step
constexpr double kForcing = 0.1;       // of the gradient, what a step may leave
constexpr double kNoDirection = 1e-9;  // of the step, what is left of it outside of the basis
// What the smoothest field that is not flat, cos(pi x), has: pi^4, times the squares of the control nodes.
constexpr double kMeanShift = 97.0;
// What the curvature along a new direction has at least beyond what the others take of it, as a share of its prior:
// H over the basis may be that of a point near by.
constexpr double kLeastCurvature = 0.5;

class ConjugateGradients {
 public:
  ConjugateGradients(const FitProblem& problem, const UnknownBasis& basis, const Eigen::MatrixXd& hessian,
                     const Eigen::VectorXd& unknowns, const Eigen::VectorXd& gradient, Precision precision,
                     FitEvaluator* evaluator)
      : problem_(problem), basis_(basis), unknowns_(unknowns), precision_(precision), evaluator_(evaluator) {
    std::vector<int> free;
    for (int i = 0; i < static_cast<int>(basis.size()); ++i) {
      const bool is_parameter = i < problem.num_blocks();
      if (is_parameter && (problem.blocks()[i].frozen || !(hessian(i, i) > 0.0) ||
                           IsHeld(problem.blocks()[i], unknowns[i], gradient[i]))) {
        held_.push_back(i);
      } else {
        free.push_back(i);
      }
    }
    coarse_ = Eigen::MatrixXd::Zero(basis.size(), basis.size());
    coarse_(free, free) = SymmetricFactor(hessian(free, free)).Inverse();
    block_rows_ = problem.PriorRows(Eigen::MatrixXd(problem.num_unknowns(), 0));
    SetPrior();
  }

  // d; false where a sweep fails.
  bool Solve(const FitOptions& options, const Eigen::VectorXd& gradient, Eigen::VectorXd* step) {
    *step = Eigen::VectorXd::Zero(gradient.size());
    Eigen::VectorXd residual = -gradient, z = Precondition(Held(&residual)), direction = z, curved;
    double square = residual.dot(z);
    const double enough = kForcing * kForcing * square;
    for (int i = 0; i < kMostProducts && square > enough && !options.is_cancelled(); ++i) {
      if (!Times(direction, &curved)) return false;
      const double length = square / direction.dot(curved);
      *step += length * direction;
      residual -= length * curved;
      z = Precondition(residual);
      const double next = residual.dot(z);
      direction = z + (next / square) * direction;
      square = next;
    }
    return true;
  }

  // H v.
  bool Times(const Eigen::VectorXd& v, Eigen::VectorXd* product) {
    if (!evaluator_->TimesCurvature(unknowns_, v, product, precision_)) return false;
    product->head(problem_.num_blocks()) += block_rows_.transpose() * (block_rows_ * v.head(problem_.num_blocks()));
    product->tail(problem_.num_field_unknowns()) += precision_of_fields_ * v.tail(problem_.num_field_unknowns());
    Held(product);
    return true;
  }

 private:
  const Eigen::VectorXd& Held(Eigen::VectorXd* v) const {
    for (const int i : held_) (*v)[i] = 0.0;
    return *v;
  }

  void SetPrior() {
    const Eigen::Index f = problem_.num_field_unknowns(), c = basis_.combinations.cols();
    precision_of_fields_ = problem_.FieldPrecision();
    Eigen::SparseMatrix<double> prior = precision_of_fields_;
    const double shift = kMeanShift * problem_.WeightOf(kFieldPrior) / static_cast<double>(f);
    for (Eigen::Index i = 0; i < f; ++i) prior.coeffRef(i, i) += shift;
    prior_.compute(prior);
    const Eigen::MatrixXd modes = basis_.combinations.bottomRows(f);
    const Eigen::Index first = basis_.with_starts ? problem_.num_start_unknowns() : 0;  // columns of starts
    const Eigen::MatrixXd own = modes.rightCols(c - first);
    coarse_.bottomRightCorner(c - first, c - first) -= SymmetricFactor(own.transpose() * (prior * own)).Inverse();
  }

  Eigen::VectorXd Precondition(const Eigen::VectorXd& v) const {
    Eigen::VectorXd solved = basis_.Extend(coarse_ * basis_.Restrict(v));
    const Eigen::Index f = problem_.num_field_unknowns();
    solved.tail(f) += prior_.solve(v.tail(f));
    return Held(&solved);
  }

  const FitProblem& problem_;
  const UnknownBasis& basis_;
  const Eigen::VectorXd& unknowns_;
  Precision precision_;
  FitEvaluator* evaluator_;
  Eigen::MatrixXd block_rows_;                                // of priors and links of parameters
  Eigen::SparseMatrix<double> precision_of_fields_;           // weight R^T R
  std::vector<int> held_;                                     // parameters
  Eigen::MatrixXd coarse_;                                    // (V^T H V)^-1 - (V_f^T Q V_f)^-1
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> prior_;  // Q
};

}  // namespace

bool WidenBasis(const FitOptions& options, const FitProblem& problem, const UnknownBasis& basis,
                const Eigen::MatrixXd& hessian, const Eigen::VectorXd& unknowns, const Eigen::VectorXd& gradient,
                Precision precision, FitEvaluator* evaluator, WidenedBasis* widened) {
  *widened = {basis, hessian};
  ConjugateGradients solver(problem, basis, hessian, unknowns, gradient, precision, evaluator);
  Eigen::VectorXd step, product;
  if (!solver.Solve(options, gradient, &step)) return false;
  const double length = step.norm();
  Eigen::VectorXd outside = step - basis.Extend(basis.Restrict(step));
  if (options.is_cancelled() || !(outside.norm() > kNoDirection * length)) return true;
  outside.normalize();
  if (!solver.Times(outside, &product)) return false;
  const Eigen::Index size = basis.size();
  const Eigen::VectorXd coupling = basis.Restrict(product);
  const double taken = coupling.dot(SymmetricFactor(hessian).SolveOne(coupling));
  const double believed = problem.FieldRows(outside.tail(problem.num_unknowns())).squaredNorm();
  const double least = taken + kLeastCurvature * believed;
  widened->hessian.conservativeResize(size + 1, size + 1);
  widened->hessian.topRightCorner(size, 1) = coupling;
  widened->hessian.bottomLeftCorner(1, size) = coupling.transpose();
  widened->hessian(size, size) = std::max(least, outside.dot(product));
  Eigen::MatrixXd& combinations = widened->basis.combinations;
  combinations.conservativeResize(Eigen::NoChange, combinations.cols() + 1);
  combinations.rightCols(1) = outside.tail(problem.num_unknowns());
  return true;
}

}  // namespace clothid
