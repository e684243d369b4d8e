#include "tools/landscape/landscape_roughness.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "sim/matrix/dense.h"

namespace clothid {
namespace {

constexpr int kNumCoefficients = 6;
// Relative: a range below says nothing but rounding.
constexpr double kRounding = 4.0 * std::numeric_limits<double>::epsilon();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double WidthOf(const LandscapeAxis& axis) {
  return axis.scale == ParameterScale::kLog ? std::log(axis.upper / axis.lower) : axis.upper - axis.lower;
}

// From -1 to 1 over `count` cells.
double Coordinate(Eigen::Index index, Eigen::Index count) {
  return count > 1 ? 2.0 * static_cast<double>(index) / static_cast<double>(count - 1) - 1.0 : 0.0;
}

// c - q, NaN at failed cells. Empty where the good cells do not determine q.
Eigen::MatrixXd OffQuadratic(const Eigen::MatrixXd& costs, int num_good) {
  Eigen::MatrixXd basis(num_good, kNumCoefficients);
  Eigen::VectorXd values(num_good);
  Eigen::Index row = 0;
  for (Eigen::Index j = 0; j < costs.cols(); ++j) {
    for (Eigen::Index i = 0; i < costs.rows(); ++i) {
      if (!std::isfinite(costs(i, j))) continue;
      const double s = Coordinate(i, costs.rows()), t = Coordinate(j, costs.cols());
      basis.row(row) << 1.0, s, t, s * s, s * t, t * t;
      values[row++] = costs(i, j);
    }
  }
  const std::optional<Eigen::VectorXd> residuals = LeastSquaresResiduals(basis, values);
  if (!residuals) return {};
  Eigen::MatrixXd off = Eigen::MatrixXd::Constant(costs.rows(), costs.cols(), kNaN);
  row = 0;
  for (Eigen::Index j = 0; j < costs.cols(); ++j) {
    for (Eigen::Index i = 0; i < costs.rows(); ++i) {
      if (std::isfinite(costs(i, j))) off(i, j) = (*residuals)[row++];
    }
  }
  return off;
}

// Of the finite values alone; NaN where there are none.
struct MeanSquare {
  double sum = 0.0;
  int count = 0;

  void Add(double value) {
    if (!std::isfinite(value)) return;
    sum += value * value;
    ++count;
  }
  double Root() const { return count > 0 ? std::sqrt(sum / count) : kNaN; }
};

double SecondDifferenceRms(const Eigen::MatrixXd& e) {
  MeanSquare mean;
  for (Eigen::Index j = 0; j < e.cols(); ++j) {
    for (Eigen::Index i = 0; i < e.rows(); ++i) {
      if (i > 0 && i + 1 < e.rows()) mean.Add(e(i - 1, j) - 2.0 * e(i, j) + e(i + 1, j));
      if (j > 0 && j + 1 < e.cols()) mean.Add(e(i, j - 1) - 2.0 * e(i, j) + e(i, j + 1));
    }
  }
  return mean.Root();
}

// The largest |w g - w slope| along the rows, which are one axis of width `width`; NaN where no cell has both.
double LargestGap(const Eigen::MatrixXd& costs, const Eigen::MatrixXd& gradient, double width) {
  const double spacing = width / static_cast<double>(costs.rows() - 1);
  double largest = kNaN;
  for (Eigen::Index j = 0; j < costs.cols(); ++j) {
    for (Eigen::Index i = 1; i + 1 < costs.rows(); ++i) {
      const double slope = (costs(i + 1, j) - costs(i - 1, j)) / (2.0 * spacing);
      const double gap = width * std::abs(gradient(i, j) - slope);
      if (std::isfinite(gap) && std::isfinite(costs(i, j))) largest = std::fmax(largest, gap);
    }
  }
  return largest;
}

double GradientGap(const CostGrid& grid) {
  return std::fmax(LargestGap(grid.costs, grid.gradient_x, grid.width_x),
                   LargestGap(grid.costs.transpose(), grid.gradient_y.transpose(), grid.width_y));
}

void AddReason(const std::string& reason, std::string* reasons) { *reasons += (reasons->empty() ? "" : "; ") + reason; }

void AddQuadraticNumbers(const CostGrid& grid, int num_good, LandscapeRoughness* roughness) {
  const Eigen::MatrixXd off = num_good > kNumCoefficients ? OffQuadratic(grid.costs, num_good) : Eigen::MatrixXd();
  if (off.size() == 0) {
    AddReason("the cells, " + std::to_string(num_good) + " of them, are too few for a quadratic", &roughness->reason);
    return;
  }
  MeanSquare mean;
  for (const double value : off.reshaped()) mean.Add(value);
  roughness->off_quadratic = mean.Root() / roughness->range;
  roughness->second_difference = SecondDifferenceRms(off) / roughness->range;
  if (std::isnan(roughness->second_difference)) AddReason("no three cells in a row", &roughness->reason);
}

}  // namespace

CostGrid GridOf(const Landscape& landscape, int setting, int window) {
  const LandscapeWindow& axes = landscape.plan.windows[window];
  CostGrid grid;
  grid.width_x = WidthOf(axes.x);
  grid.width_y = WidthOf(axes.y);
  grid.costs.resize(axes.x.num_cells, axes.y.num_cells);
  if (landscape.plan.has_gradients) grid.gradient_x = grid.gradient_y = grid.costs;
  int cell = landscape.plan.FirstCell(setting, window);
  for (int iy = 0; iy < axes.y.num_cells; ++iy) {
    for (int ix = 0; ix < axes.x.num_cells; ++ix, ++cell) {
      grid.costs(ix, iy) = landscape.cells[cell].cost;
      if (!landscape.plan.has_gradients) continue;
      grid.gradient_x(ix, iy) = landscape.cells[cell].gradient_x;
      grid.gradient_y(ix, iy) = landscape.cells[cell].gradient_y;
    }
  }
  return grid;
}

LandscapeRoughness RoughnessOf(const CostGrid& grid) {
  LandscapeRoughness roughness;
  roughness.cells = static_cast<int>(grid.costs.size());
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  int num_good = 0;
  for (const double cost : grid.costs.reshaped()) {
    if (!std::isfinite(cost)) continue;
    ++num_good;
    lowest = std::min(lowest, cost);
    highest = std::max(highest, cost);
  }
  roughness.failed_cells = roughness.cells - num_good;
  if (num_good == 0) {
    roughness.reason = "every cell failed";
    return roughness;
  }
  roughness.range = highest - lowest;
  if (roughness.range <= kRounding * std::max(std::abs(lowest), std::abs(highest))) {
    roughness.reason = "the cost is the same in every cell";
    return roughness;
  }
  AddQuadraticNumbers(grid, num_good, &roughness);
  if (grid.gradient_x.size() > 0) {
    roughness.gradient_gap = GradientGap(grid) / roughness.range;
    if (std::isnan(roughness.gradient_gap)) AddReason("no cell has a gradient and a slope", &roughness.reason);
  }
  return roughness;
}

}  // namespace clothid
