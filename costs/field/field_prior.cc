#include "costs/field/field_prior.h"

#include <algorithm>
#include <cmath>

namespace clothid {
namespace {

constexpr double kPi = 3.14159265358979323846;

// The second difference along a line of `count` control nodes, of length 1, times the spacing squared.
double SecondDifference(int at, int other, int count) {
  if (at == other) return (at > 0 ? -1.0 : 0.0) + (at < count - 1 ? -1.0 : 0.0);
  return std::abs(at - other) == 1 ? 1.0 : 0.0;
}

double Spacing(int count) { return count > 1 ? 1.0 / (count - 1) : 1.0; }

// Along one side of `count` control nodes: the cosines with 0, 1, .. half waves, orthonormal columns [count x modes].
Eigen::MatrixXd Cosines(int count, int num_modes) {
  Eigen::MatrixXd cosines(count, num_modes);
  for (int i = 0; i < num_modes; ++i) {
    for (int k = 0; k < count; ++k) cosines(k, i) = std::cos(kPi * i * (k + 0.5) / count);
  }
  return cosines.colwise().normalized();
}

// The second derivative of cosine `i`, over itself.
double SlopeChange(int count, int i) { return -std::pow(2.0 * std::sin(0.5 * kPi * i / count) / Spacing(count), 2); }

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

Eigen::MatrixXd FieldModes(int rows, int columns, int most_per_side) {
  const Eigen::MatrixXd across = Cosines(rows, std::min(rows, most_per_side));
  const Eigen::MatrixXd along = Cosines(columns, std::min(columns, most_per_side));
  Eigen::MatrixXd modes(rows * columns, across.cols() * along.cols());
  for (int r = 0; r < rows; ++r) {
    for (Eigen::Index i = 0; i < across.cols(); ++i) {
      modes.block(r * columns, i * along.cols(), columns, along.cols()) = across(r, i) * along;
    }
  }
  return modes;
}

Eigen::VectorXd RoughVariances(int rows, int columns, int most_per_side) {
  const Eigen::MatrixXd across = Cosines(rows, rows).array().square();
  const Eigen::MatrixXd along = Cosines(columns, columns).array().square();
  Eigen::MatrixXd variances = Eigen::MatrixXd::Zero(rows, columns);  // of the modes
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      if (i < most_per_side && j < most_per_side) continue;
      variances(i, j) =
          1.0 / (Spacing(rows) * Spacing(columns) * std::pow(SlopeChange(rows, i) + SlopeChange(columns, j), 2));
    }
  }
  const Eigen::MatrixXd by_node = across * variances * along.transpose();
  return by_node.transpose().reshaped();
}

}  // namespace clothid
