#include "identify/field/field_prior.h"

#include <cmath>

namespace clothid {
namespace {

// The second difference along a line of `count` control nodes, of length 1, times the spacing squared.
double SecondDifference(int at, int other, int count) {
  if (at == other) return (at > 0 ? -1.0 : 0.0) + (at < count - 1 ? -1.0 : 0.0);
  return std::abs(at - other) == 1 ? 1.0 : 0.0;
}

double Spacing(int count) { return count > 1 ? 1.0 / (count - 1) : 1.0; }

}  // namespace

Eigen::SparseMatrix<double> SmoothnessRoot(int rows, int columns) {
  const double along = Spacing(columns), across = Spacing(rows), area = std::sqrt(along * across);
  std::vector<Eigen::Triplet<double>> triplets;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const int node = r * columns + c;
      for (int d = -1; d <= 1; ++d) {
        if (c + d >= 0 && c + d < columns) {
          triplets.emplace_back(node, node + d, area * SecondDifference(c, c + d, columns) / (along * along));
        }
        if (r + d >= 0 && r + d < rows) {
          triplets.emplace_back(node, node + d * columns, area * SecondDifference(r, r + d, rows) / (across * across));
        }
      }
    }
  }
  Eigen::SparseMatrix<double> root(rows * columns, rows * columns);
  root.setFromTriplets(triplets.begin(), triplets.end());
  return root;
}

Eigen::SparseMatrix<double> SmoothnessRoot(const std::vector<FieldRequest>& requests) {
  std::vector<Eigen::Triplet<double>> triplets;
  int first = 0;
  for (const FieldRequest& request : requests) {
    const Eigen::SparseMatrix<double> own = SmoothnessRoot(request.rows, request.columns);
    for (int column = 0; column < own.outerSize(); ++column) {
      for (Eigen::SparseMatrix<double>::InnerIterator it(own, column); it; ++it) {
        triplets.emplace_back(first + static_cast<int>(it.row()), first + column, it.value());
      }
    }
    first += request.size();
  }
  Eigen::SparseMatrix<double> root(first, first);
  root.setFromTriplets(triplets.begin(), triplets.end());
  return root;
}

}  // namespace clothid
