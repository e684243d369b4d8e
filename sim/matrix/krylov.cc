#include "sim/matrix/krylov.h"

#include <Eigen/Jacobi>
#include <algorithm>
#include <cmath>
#include <vector>

namespace clothid {
namespace {

constexpr int kProbe = 6;  // iterations, before which no rate is judged

// The small least-squares problem of one column of GMRES: its Hessenberg matrix, made triangular on the way.
class ArnoldiColumn {
 public:
  ArnoldiColumn(double norm, double tolerance, int max_iterations)
      : triangle_(max_iterations + 1, max_iterations),
        projected_(Eigen::VectorXd::Zero(max_iterations + 1)),
        norm_(norm),
        goal_(tolerance * norm),
        active_(norm > 0.0) {
    projected_[0] = norm;
  }

  bool active() const { return active_; }  // iterates on
  bool failed() const { return failed_; }
  // Whether `most` iterations would not reach the goal at the mean rate so far.
  bool is_too_slow(int most) const {
    if (!active_ || size_ < kProbe) return false;
    return most * std::log(std::abs(projected_[size_]) / norm_) > size_ * std::log(goal_ / norm_);
  }

  // Orthogonalises `next` against the column `c` of the k + 1 basis matrices and normalises it.
  void Extend(const std::vector<Eigen::MatrixXd>& basis, Eigen::Index c, Eigen::Ref<Eigen::VectorXd> next) {
    const int k = size_++;
    for (int i = 0; i <= k; ++i) {
      triangle_(i, k) = basis[i].col(c).dot(next);
      next -= triangle_(i, k) * basis[i].col(c);
    }
    const double norm = next.norm();
    triangle_(k + 1, k) = norm;
    for (int i = 0; i < k; ++i) triangle_.col(k).applyOnTheLeft(i, i + 1, rotations_[i].adjoint());
    rotations_.emplace_back();
    rotations_[k].makeGivens(triangle_(k, k), triangle_(k + 1, k));
    triangle_.col(k).applyOnTheLeft(k, k + 1, rotations_[k].adjoint());
    projected_.applyOnTheLeft(k, k + 1, rotations_[k].adjoint());
    failed_ = !std::isfinite(projected_[k + 1]);
    active_ = !failed_ && std::abs(projected_[k + 1]) > goal_ && norm > 0.0;
    if (active_) {
      next /= norm;
    } else {
      next.setZero();
    }
  }

  // Weights of the preconditioned basis.
  Eigen::VectorXd Weights() const {
    return triangle_.topLeftCorner(size_, size_).triangularView<Eigen::Upper>().solve(projected_.head(size_));
  }

 private:
  Eigen::MatrixXd triangle_;  // filled column by column, so most of it is never touched
  Eigen::VectorXd projected_;
  std::vector<Eigen::JacobiRotation<double>> rotations_;
  double norm_, goal_;  // of the residual, at the start and asked for
  int size_ = 0;
  bool active_, failed_ = false;
};

}  // namespace

GmresResult Gmres(const LinearMap& multiply, const LinearMap& precondition, const Eigen::MatrixXd& right,
                  double tolerance, const IterationLimit& limit, Eigen::MatrixXd* solution) {
  GmresResult result;
  std::vector<ArnoldiColumn> columns;
  std::vector<Eigen::MatrixXd> basis = {right}, preconditioned;
  for (Eigen::Index c = 0; c < right.cols(); ++c) {
    const double norm = right.col(c).norm();
    columns.emplace_back(norm, tolerance, limit.most);
    if (norm > 0.0) basis[0].col(c) /= norm;
  }
  const auto any_active = [&columns] {
    return std::any_of(columns.begin(), columns.end(), [](const ArnoldiColumn& column) { return column.active(); });
  };
  const auto is_too_slow = [&] {
    return limit.gives_up && std::any_of(columns.begin(), columns.end(),
                                         [&](const ArnoldiColumn& column) { return column.is_too_slow(limit.most); });
  };
  while (any_active() && !is_too_slow() && result.iterations < limit.most) {
    preconditioned.push_back(precondition(basis[result.iterations]));
    basis.push_back(multiply(preconditioned.back()));
    for (Eigen::Index c = 0; c < right.cols(); ++c) {
      if (columns[c].active()) {
        columns[c].Extend(basis, c, basis.back().col(c));
      } else {
        basis.back().col(c).setZero();
      }
    }
    ++result.iterations;
  }
  *solution = Eigen::MatrixXd::Zero(right.rows(), right.cols());
  for (Eigen::Index c = 0; c < right.cols(); ++c) {
    const Eigen::VectorXd weights = columns[c].Weights();
    for (Eigen::Index i = 0; i < weights.size(); ++i) solution->col(c) += weights[i] * preconditioned[i].col(c);
  }
  const bool failed = std::any_of(columns.begin(), columns.end(), [](const auto& column) { return column.failed(); });
  result.converged = !any_active() && !failed && solution->allFinite();
  return result;
}

ConjugateGradientResult ConjugateGradients(const VectorMap& multiply, const VectorMap& precondition,
                                           const Eigen::VectorXd& right, double tolerance, int max_iterations,
                                           Eigen::VectorXd* solution) {
  ConjugateGradientResult result;
  const double goal = tolerance * right.norm();
  Eigen::VectorXd residual = right, direction;
  solution->setZero(right.size());
  double last_product = 0.0;
  result.converged = residual.norm() <= goal;
  while (!result.converged && result.iterations < max_iterations) {
    ++result.iterations;
    const Eigen::VectorXd preconditioned = precondition(residual);
    const double product = residual.dot(preconditioned);
    if (result.iterations == 1) {
      direction = preconditioned;
    } else {
      direction = preconditioned + product / last_product * direction;
    }
    last_product = product;
    const Eigen::VectorXd image = multiply(direction);
    const double curvature = direction.dot(image);
    if (!(curvature > 0.0)) {
      result.indefinite = true;
      return result;
    }
    *solution += product / curvature * direction;
    residual -= product / curvature * image;
    result.converged = residual.norm() <= goal;
  }
  return result;
}

}  // namespace clothid
