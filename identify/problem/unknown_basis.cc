#include "identify/problem/unknown_basis.h"

#include <algorithm>
#include <vector>

#include "costs/field/field_prior.h"

namespace clothid {

Eigen::VectorXd UnknownBasis::Restrict(const Eigen::VectorXd& unknowns) const {
  Eigen::VectorXd coordinates(size());
  coordinates << unknowns.head(num_blocks), combinations.transpose() * unknowns.tail(combinations.rows());
  return coordinates;
}

Eigen::VectorXd UnknownBasis::Extend(const Eigen::VectorXd& coordinates) const {
  Eigen::VectorXd unknowns(num_blocks + combinations.rows());
  unknowns << coordinates.head(num_blocks), combinations * coordinates.tail(combinations.cols());
  return unknowns;
}

UnknownBasis MakeBasis(const FitProblem& problem, bool with_starts, int field_modes) {
  UnknownBasis basis;
  basis.with_starts = with_starts;
  basis.field_modes = field_modes;
  basis.num_blocks = problem.num_blocks();
  const Eigen::Index num_starts = with_starts ? problem.num_start_unknowns() : 0;
  std::vector<Eigen::MatrixXd> modes;
  Eigen::Index num_columns = num_starts;
  for (const FieldRequest& field : problem.fields()) {
    if (std::max(field.rows, field.columns) > field_modes) basis.has_all_field_modes = false;
    if (field_modes == 0) continue;
    const Eigen::MatrixXd all = FieldModes(field.rows, field.columns, field_modes);
    modes.push_back(all.rightCols(all.cols() - 1));  // the constant one is the first
    num_columns += modes.back().cols();
  }
  basis.combinations = Eigen::MatrixXd::Zero(problem.num_unknowns(), num_columns);
  basis.combinations.topLeftCorner(num_starts, num_starts).setIdentity();
  Eigen::Index row = problem.num_start_unknowns(), column = num_starts;
  for (const Eigen::MatrixXd& own : modes) {
    basis.combinations.block(row, column, own.rows(), own.cols()) = own;
    row += own.rows();
    column += own.cols();
  }
  return basis;
}

}  // namespace clothid
