// Roughness of landscapes that are known in closed form.
#include "tools/landscape/landscape_roughness.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

namespace clothid::landscape_roughness_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

using Function = std::function<double(double s, double t)>;

// On [-1, 1]^2.
Eigen::MatrixXd Sample(const Function& function, int nx, int ny) {
  Eigen::MatrixXd values(nx, ny);
  for (int j = 0; j < ny; ++j) {
    for (int i = 0; i < nx; ++i) values(i, j) = function(2.0 * i / (nx - 1) - 1.0, 2.0 * j / (ny - 1) - 1.0);
  }
  return values;
}

double Bowl(double s, double t) { return 3.0 + 0.5 * s - t + 2.0 * s * s + 0.7 * s * t + t * t; }

// Not quadratic, with its gradient.
double Valley(double s, double t) { return std::exp(s) + std::cos(2.0 * t) + s * t; }
CostGrid ValleyGrid(int cells) {
  CostGrid grid;
  grid.costs = Sample(Valley, cells, cells);
  grid.gradient_x = Sample([](double s, double t) { return std::exp(s) + t; }, cells, cells);
  grid.gradient_y = Sample([](double s, double t) { return -2.0 * std::sin(2.0 * t) + s; }, cells, cells);
  return grid;
}

TEST(LandscapeRoughness, QuadraticHasNone) {
  CostGrid grid;
  grid.costs = Sample(Bowl, 33, 17);
  grid.gradient_x = Sample([](double s, double t) { return 0.5 + 4.0 * s + 0.7 * t; }, 33, 17);
  grid.gradient_y = Sample([](double s, double t) { return -1.0 + 0.7 * s + 2.0 * t; }, 33, 17);
  const LandscapeRoughness roughness = RoughnessOf(grid);
  EXPECT_EQ(roughness.cells, 33 * 17);
  EXPECT_EQ(roughness.failed_cells, 0);
  EXPECT_EQ(roughness.range, grid.costs.maxCoeff() - grid.costs.minCoeff());
  EXPECT_LT(roughness.off_quadratic, 1e-14);
  EXPECT_LT(roughness.second_difference, 1e-14);
  EXPECT_LT(roughness.gradient_gap, 1e-12);
  EXPECT_TRUE(roughness.reason.empty()) << roughness.reason;
}

// a (-1)^(i + j) is, on an even number of cells, nearly free of any quadratic: rms a, second differences 4 a.
TEST(LandscapeRoughness, CheckerboardIsKnown) {
  const int cells = 64;
  const double amplitude = 1e-3;
  CostGrid grid;
  grid.costs = Sample(Bowl, cells, cells);
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) grid.costs(i, j) += (i + j) % 2 == 0 ? amplitude : -amplitude;
  }
  const LandscapeRoughness roughness = RoughnessOf(grid);
  EXPECT_NEAR(roughness.off_quadratic * roughness.range, amplitude, 0.01 * amplitude);
  EXPECT_NEAR(roughness.second_difference * roughness.range, 4.0 * amplitude, 0.01 * amplitude);
  EXPECT_TRUE(std::isnan(roughness.gradient_gap));
  EXPECT_TRUE(roughness.reason.empty()) << roughness.reason;
}

// Whole waves of a sin(2 pi w s): rms a/sqrt(2), of the second differences 2 (1 - cos(2 pi w d)) times that along x and
// none along y.
TEST(LandscapeRoughness, WaveIsKnown) {
  const int cells = 129, waves = 8;
  const double amplitude = 1e-2, pi = std::acos(-1.0);
  CostGrid grid;
  grid.costs =
      Sample([&](double s, double t) { return Bowl(s, t) + amplitude * std::sin(2.0 * pi * waves * s); }, cells, cells);
  const LandscapeRoughness roughness = RoughnessOf(grid);
  const double rms = amplitude / std::sqrt(2.0);
  EXPECT_NEAR(roughness.off_quadratic * roughness.range, rms, 0.02 * rms);
  const double along_x = 2.0 * (1.0 - std::cos(2.0 * pi * waves * 2.0 / (cells - 1))) * rms;
  EXPECT_NEAR(roughness.second_difference * roughness.range, along_x / std::sqrt(2.0), 0.02 * along_x);
}

TEST(LandscapeRoughness, UnitsOfCostAndAxesChangeNothing) {
  CostGrid grid = ValleyGrid(21);
  const LandscapeRoughness plain = RoughnessOf(grid);
  grid.costs *= 1e6;
  grid.gradient_x *= 1e6 / 50.0;
  grid.gradient_y *= 1e6;
  grid.width_x *= 50.0;
  const LandscapeRoughness scaled = RoughnessOf(grid);
  EXPECT_NEAR(scaled.off_quadratic, plain.off_quadratic, 1e-12);
  EXPECT_NEAR(scaled.second_difference, plain.second_difference, 1e-12);
  EXPECT_NEAR(scaled.gradient_gap, plain.gradient_gap, 1e-10);
}

// The cells do not matter for how far a smooth landscape is off a quadratic; from cell to cell it is smooth.
TEST(LandscapeRoughness, SecondDifferencesOfASmoothLandscapeAreOfSecondOrder) {
  const LandscapeRoughness coarse = RoughnessOf(ValleyGrid(33)), fine = RoughnessOf(ValleyGrid(65));
  EXPECT_NEAR(coarse.off_quadratic / fine.off_quadratic, 1.0, 0.1);
  EXPECT_NEAR(coarse.second_difference / fine.second_difference, 4.0, 0.3);
}

TEST(LandscapeRoughness, GapOfExactGradientsIsOfSecondOrder) {
  const double coarse = RoughnessOf(ValleyGrid(17)).gradient_gap, fine = RoughnessOf(ValleyGrid(33)).gradient_gap;
  EXPECT_LT(coarse, 0.02);
  EXPECT_NEAR(coarse / fine, 4.0, 0.3);
}

// A step of a share of the range between two cells: the gradient beside it knows nothing of it.
TEST(LandscapeRoughness, GapOfAStepIsLarge) {
  CostGrid grid = ValleyGrid(33);
  const double range = RoughnessOf(grid).range, share = 0.1;
  grid.costs.bottomRows(16).array() += share * range;
  const LandscapeRoughness roughness = RoughnessOf(grid);
  EXPECT_NEAR(roughness.gradient_gap, share * range / roughness.range * 32 / 2, 0.05);
  EXPECT_GT(roughness.off_quadratic, 0.01);
}

TEST(LandscapeRoughness, FailedCellsAreLeftOut) {
  CostGrid grid = ValleyGrid(33);
  grid.costs = Sample(Bowl, 33, 33);
  grid.gradient_x = Sample([](double s, double t) { return 0.5 + 4.0 * s + 0.7 * t; }, 33, 33);
  grid.gradient_y = Sample([](double s, double t) { return -1.0 + 0.7 * s + 2.0 * t; }, 33, 33);
  grid.costs.col(3).setConstant(kNaN);
  grid.costs(7, 20) = std::numeric_limits<double>::infinity();
  grid.gradient_y(8, 20) = kNaN;
  const LandscapeRoughness roughness = RoughnessOf(grid);
  EXPECT_EQ(roughness.failed_cells, 34);
  EXPECT_LT(roughness.off_quadratic, 1e-14);
  EXPECT_LT(roughness.second_difference, 1e-14);
  EXPECT_LT(roughness.gradient_gap, 1e-12);
  EXPECT_TRUE(roughness.reason.empty()) << roughness.reason;
}

TEST(LandscapeRoughness, NoNumberWhereThereIsNone) {
  CostGrid grid;
  grid.costs = Eigen::MatrixXd::Constant(9, 9, 0.1);
  LandscapeRoughness roughness = RoughnessOf(grid);
  EXPECT_TRUE(std::isnan(roughness.off_quadratic));
  EXPECT_TRUE(std::isnan(roughness.second_difference));
  EXPECT_EQ(roughness.range, 0.0);
  EXPECT_EQ(roughness.reason, "the cost is the same in every cell");

  grid.costs(4, 4) = std::nextafter(0.1, 1.0);
  EXPECT_TRUE(std::isnan(RoughnessOf(grid).off_quadratic));

  grid.costs.setConstant(kNaN);
  roughness = RoughnessOf(grid);
  EXPECT_EQ(roughness.failed_cells, 81);
  EXPECT_TRUE(std::isnan(roughness.range));
  EXPECT_EQ(roughness.reason, "every cell failed");

  // On two columns t^2 = 1.
  grid.costs = Sample(Bowl, 9, 2);
  grid.gradient_x = grid.gradient_y = grid.costs;
  roughness = RoughnessOf(grid);
  EXPECT_TRUE(std::isnan(roughness.off_quadratic));
  EXPECT_TRUE(std::isnan(roughness.second_difference));
  EXPECT_EQ(roughness.reason, "the cells, 18 of them, are too few for a quadratic");

  // Enough for the fit, with a hole in every three in a row.
  grid = CostGrid();
  grid.costs = Sample(Bowl, 6, 6);
  for (int j = 0; j < 6; ++j) {
    for (int i = 0; i < 6; ++i) {
      if ((i + j) % 2 == 0) grid.costs(i, j) = kNaN;
    }
  }
  roughness = RoughnessOf(grid);
  EXPECT_LT(roughness.off_quadratic, 1e-14);
  EXPECT_TRUE(std::isnan(roughness.second_difference));
  EXPECT_EQ(roughness.reason, "no three cells in a row");
}

// x: log, from 1 to e^2, with the gradient per unit of log x; cells x fastest, in the second window of the second
// setting.
TEST(LandscapeRoughness, GridOfTakesTheRightCells) {
  Landscape landscape;
  landscape.plan.settings.resize(2);
  landscape.plan.windows.resize(2);
  landscape.plan.has_gradients = true;
  for (LandscapeWindow& window : landscape.plan.windows) {
    window.x = {"k_stretch", ParameterScale::kLog, 1.0, std::exp(2.0), 5};
    window.y = {"mu", ParameterScale::kLinear, 0.1, 0.4, 4};
  }
  landscape.cells.resize(landscape.plan.num_cells());
  for (int iy = 0; iy < 4; ++iy) {
    for (int ix = 0; ix < 5; ++ix) {
      LandscapeCell& cell = landscape.cells[landscape.plan.FirstCell(1, 1) + iy * 5 + ix];
      cell.cost = 10.0 * ix + iy;
      cell.gradient_x = 100.0 + ix;
      cell.gradient_y = 200.0 + iy;
    }
  }
  const CostGrid grid = GridOf(landscape, 1, 1);
  ASSERT_EQ(grid.costs.rows(), 5);
  ASSERT_EQ(grid.costs.cols(), 4);
  EXPECT_EQ(grid.costs(3, 2), 32.0);
  EXPECT_EQ(grid.gradient_x(3, 2), 103.0);
  EXPECT_EQ(grid.gradient_y(3, 2), 202.0);
  EXPECT_NEAR(grid.width_x, 2.0, 1e-15);
  EXPECT_NEAR(grid.width_y, 0.3, 1e-15);
  EXPECT_EQ(RoughnessOf(GridOf(landscape, 0, 1)).reason, "every cell failed");
  landscape.plan.has_gradients = false;
  EXPECT_EQ(GridOf(landscape, 1, 1).gradient_x.size(), 0);
}

}  // namespace
}  // namespace clothid::landscape_roughness_test
