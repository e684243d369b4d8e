// The bending energy by patches against the energy of a plate, on every kind of mesh.
#include "sim/shell/bending_patch.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "sim/matrix/dense.h"
#include "sim/shell/bending_energy.h"
#include "tests/sim/sheet_meshes.h"

namespace clothid::bending_patch_test {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr FlexuralRigidity kOrthotropic = {3.0, 1.0, 0.4, 0.3};

GridOptions Square(int nodes) {
  GridOptions grid;
  grid.nodes = {nodes, nodes};
  grid.size = {1.0, 1.0};
  return grid;
}

// Axis 1 along x, for meshes in the xy plane.
Eigen::Matrix3Xd AlongX(const Mesh& mesh) { return Eigen::Vector3d::UnitX().replicate(1, mesh.num_faces()); }

Eigen::SparseMatrix<double> Matrix(const Mesh& mesh, const FlexuralRigidity& rigidity) {
  return BendingPatches(mesh, AlongX(mesh)).Matrix(rigidity);
}

// E of positions [3 x N].
double Energy(const Eigen::SparseMatrix<double>& matrix, const Eigen::Matrix3Xd& positions) {
  return 0.5 * (positions * matrix).cwiseProduct(positions).sum();
}

// The sheet rolled onto a cylinder of radius 2 whose curved direction is at `angle` from x.
Eigen::Matrix3Xd Rolled(const Mesh& mesh, double angle) {
  constexpr double kRadius = 2.0;
  const Eigen::Vector2d around(std::cos(angle), std::sin(angle)), along(-around.y(), around.x());
  Eigen::Matrix3Xd rolled(3, mesh.num_nodes());
  for (int node = 0; node < mesh.num_nodes(); ++node) {
    const Eigen::Vector2d p = mesh.rest_positions.col(node).head<2>();
    const double turn = around.dot(p) / kRadius;
    rolled.col(node) << kRadius * std::sin(turn), along.dot(p), kRadius * (1.0 - std::cos(turn));
  }
  return rolled;
}

class BendingPatchTest : public ::testing::TestWithParam<SheetKind> {};

TEST_P(BendingPatchTest, ACylinderHasTheEnergyOfThePlate) {
  const Mesh mesh = MakeSheet(GetParam(), Square(17));
  const double energy_of_one = 0.5 * TriangleAreas(mesh).sum() / 4.0;  // D = 1, radius 2
  const Eigen::SparseMatrix<double> plain = Matrix(mesh, IsotropicRigidity(1.0, 0.0)),
                                    poisson = Matrix(mesh, IsotropicRigidity(1.0, 0.4)),
                                    orthotropic = Matrix(mesh, kOrthotropic), edges = EdgeBendingMatrix(mesh);
  double most_of_edges = 0.0;
  for (const double degrees : {0.0, 45.0, 90.0, 135.0}) {
    const double angle = degrees * kPi / 180.0;
    const Eigen::Matrix3Xd rolled = Rolled(mesh, angle);
    EXPECT_NEAR(Energy(plain, rolled), energy_of_one, 0.01 * energy_of_one) << degrees;
    EXPECT_NEAR(Energy(poisson, rolled), energy_of_one, 0.01 * energy_of_one) << degrees;
    const double c = std::cos(angle) * std::cos(angle), s = 1.0 - c;
    const double across = 3.0 * c * c + 1.0 * s * s + (2.0 * 0.4 + 4.0 * 0.3) * c * s;
    EXPECT_NEAR(Energy(orthotropic, rolled), across * energy_of_one, 0.01 * across * energy_of_one) << degrees;
    most_of_edges = std::max(most_of_edges, Energy(edges, rolled) / energy_of_one);
  }
  EXPECT_GT(most_of_edges, 2.5);  // what this law is for
}

// Of a quadratic surface but for rounding, up to the border and on stretched triangles.
TEST_P(BendingPatchTest, AQuadraticSurfaceHasItExactly) {
  for (const double height : {1.0, 0.1}) {
    GridOptions grid = Square(9);
    grid.size[1] = height;
    Mesh mesh = MakeSheet(GetParam(), grid);
    mesh.rest_positions.row(1) *= GetParam() == SheetKind::kEquilateral ? height : 1.0;
    const double xx = 0.7, yy = -0.4, xy = 0.5;
    Eigen::Matrix3Xd bent = mesh.rest_positions;
    for (int node = 0; node < mesh.num_nodes(); ++node) {
      const double x = bent(0, node), y = bent(1, node);
      bent(2, node) = 0.5 * xx * x * x + 0.5 * yy * y * y + xy * x * y;
    }
    const double density = 3.0 * xx * xx + yy * yy + 2.0 * 0.4 * xx * yy + 4.0 * 0.3 * xy * xy;
    const double expected = 0.5 * TriangleAreas(mesh).sum() * density;
    EXPECT_NEAR(Energy(Matrix(mesh, kOrthotropic), bent), expected, 1e-7 * expected) << height;
  }
}

// Constant second derivatives, and so constant moments, pull at no node but near the border. Where they do, as by
// edges, nodes give way on the scale of the mesh and a cloth is softer than its constants say, on any refinement.
TEST_P(BendingPatchTest, ConstantMomentsAreInEquilibrium) {
  constexpr int kNodes = 11, kBorder = 3;
  const Mesh mesh = MakeSheet(GetParam(), Square(kNodes));
  Eigen::VectorXd bent(mesh.num_nodes());
  for (int node = 0; node < mesh.num_nodes(); ++node) {
    const double x = mesh.rest_positions(0, node), y = mesh.rest_positions(1, node);
    bent[node] = 0.7 * x * x - 0.4 * y * y + 0.5 * x * y;
  }
  const Eigen::SparseMatrix<double> matrix = Matrix(mesh, kOrthotropic);
  const double scale = matrix.diagonal().maxCoeff();
  const Eigen::VectorXd force = matrix * bent;
  int num_inner = 0;
  for (int node = 0; node < mesh.num_nodes(); ++node) {
    const int i = node % kNodes, j = node / kNodes;
    if (std::min({i, j, kNodes - 1 - i, kNodes - 1 - j}) < kBorder) continue;
    EXPECT_LT(std::abs(force[node]), 1e-12 * scale) << node;
    ++num_inner;
  }
  EXPECT_EQ(num_inner, 25);
}

// A coordinate costs nothing where it is an affine function of the rest positions, and nowhere else.
TEST_P(BendingPatchTest, OnlyFlatIsFree) {
  for (const int nodes : {2, 3, 4, 9}) {
    const Mesh mesh = MakeSheet(GetParam(), Square(nodes));
    for (const FlexuralRigidity& rigidity : {IsotropicRigidity(1.0, 0.0), IsotropicRigidity(1.0, -0.8), kOrthotropic}) {
      const Eigen::SparseMatrix<double> matrix = Matrix(mesh, rigidity);
      EXPECT_EQ((matrix - Eigen::SparseMatrix<double>(matrix.transpose())).norm(), 0.0);
      const Eigen::VectorXd values = SymmetricEigenvalues(matrix);
      const double largest = values[values.size() - 1];
      EXPECT_LT(values.head<3>().cwiseAbs().maxCoeff(), 1e-13 * largest) << nodes;
      EXPECT_GT(values[3], 1e-6 * largest) << nodes;
      Eigen::MatrixX3d affine(mesh.num_nodes(), 3);
      affine << Eigen::VectorXd::Ones(mesh.num_nodes()), mesh.rest_positions.topRows<2>().transpose();
      EXPECT_LT((matrix * affine).norm(), 1e-12 * largest) << nodes;
    }
  }
}

// What a plate has beyond rigid motions is stiff by its own constants: the softest mode of a free square is the same on
// every mesh.
TEST_P(BendingPatchTest, SoftestModeIsThatOfThePlate) {
  const Mesh mesh = MakeSheet(GetParam(), Square(13));
  if (GetParam() == SheetKind::kEquilateral) return;  // no square
  const Eigen::MatrixXd stiffness = Matrix(mesh, IsotropicRigidity(1.0, 0.3));
  const Eigen::VectorXd root_mass = NodeAreas(mesh).cwiseSqrt();
  const Eigen::VectorXd values = SymmetricEigenvalues(stiffness.cwiseQuotient(root_mass * root_mass.transpose()));
  EXPECT_NEAR(std::sqrt(values[3]), 13.468, 0.02 * 13.468);  // nu = 0.3; A. W. Leissa: Vibration of plates, 1969
}

TEST_P(BendingPatchTest, IsLinearInEveryConstant) {
  const Mesh mesh = MakeSheet(GetParam(), Square(5));
  const Eigen::MatrixXd sum = 3.0 * Eigen::MatrixXd(Matrix(mesh, {1.0, 0.0, 0.0, 0.0})) +
                              1.0 * Eigen::MatrixXd(Matrix(mesh, {0.0, 1.0, 0.0, 0.0})) +
                              0.4 * Eigen::MatrixXd(Matrix(mesh, {0.0, 0.0, 1.0, 0.0})) +
                              0.3 * Eigen::MatrixXd(Matrix(mesh, {0.0, 0.0, 0.0, 1.0}));
  EXPECT_LT((sum - Eigen::MatrixXd(Matrix(mesh, kOrthotropic))).norm(), 1e-12 * sum.norm());
}

TEST_P(BendingPatchTest, AxesTurnWithTheWarp) {
  const Mesh mesh = MakeSheet(GetParam(), Square(5));
  const Eigen::Matrix3Xd along_y = Eigen::Vector3d::UnitY().replicate(1, mesh.num_faces());
  const Eigen::MatrixXd turned = BendingPatches(mesh, along_y).Matrix({1.0, 3.0, 0.4, 0.3});
  EXPECT_LT((turned - Eigen::MatrixXd(Matrix(mesh, kOrthotropic))).norm(), 1e-11 * turned.norm());
  // An isotropic law has no axes, and no law has a place in space.
  Mesh moved = mesh;
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
  moved.rest_positions = (rotation * mesh.rest_positions).colwise() + Eigen::Vector3d(0.3, -5.0, 2.0);
  const FlexuralRigidity isotropic = IsotropicRigidity(1.0, 0.3);
  const Eigen::MatrixXd expected = Matrix(mesh, isotropic);
  const Eigen::MatrixXd there = BendingPatches(moved, FirstEdges(moved)).Matrix(isotropic);
  EXPECT_LT((there - expected).norm(), 1e-11 * expected.norm());
}

INSTANTIATE_TEST_SUITE_P(Kinds, BendingPatchTest, ::testing::ValuesIn(kSheetKinds),
                         [](const auto& test) { return SheetName(test.param); });

TEST(BendingPatchOfSmallMeshesTest, TheyHaveWhatTheirNodesTell) {
  GridOptions grid;
  grid.nodes = {9, 2};
  grid.size = {1.0, 0.1};
  const Mesh strip = MakeGrid(grid);
  Eigen::Matrix3Xd bent = strip.rest_positions;
  bent.row(2) = bent.row(0).cwiseAbs2();
  const double expected = 0.5 * 0.1 * 3.0 * 4.0;
  EXPECT_NEAR(Energy(Matrix(strip, kOrthotropic), bent), expected, 1e-10);
  bent.row(2) = 0.7 * strip.rest_positions.row(0).cwiseProduct(strip.rest_positions.row(1));
  const double twisted = 0.5 * 0.1 * 4.0 * 0.3 * 0.49;
  EXPECT_NEAR(Energy(Matrix(strip, kOrthotropic), bent), twisted, 1e-10);
  Mesh triangle;
  triangle.rest_positions = Eigen::Matrix3d{{0.0, 1.0, 0.3}, {0.0, 0.1, 0.8}, {0.0, 0.0, 0.0}};
  triangle.faces = Eigen::Vector3i(0, 1, 2);
  EXPECT_LT(Matrix(triangle, kOrthotropic).norm(), 1e-20);
}

// A grid of quads folded along its columns, like a prism: the same cloth as the flat one, and the same energy.
TEST(BendingPatchOfCurvedMeshesTest, UnfoldsThem) {
  const Mesh flat = MakeSheet(SheetKind::kRightAngled, Square(9));
  Mesh folded = flat;
  Eigen::Vector2d point(0.0, 0.0);
  for (int column = 1; column < 9; ++column) {
    point += 0.125 * Eigen::Vector2d(std::cos(0.3 * column), std::sin(0.3 * column));
    for (int row = 0; row < 9; ++row) {
      folded.rest_positions(0, column + 9 * row) = point.x();
      folded.rest_positions(2, column + 9 * row) = point.y();
    }
  }
  const FlexuralRigidity isotropic = IsotropicRigidity(1.0, 0.3);
  const Eigen::MatrixXd expected = Matrix(flat, isotropic);
  const Eigen::MatrixXd matrix = BendingPatches(folded, FirstEdges(folded)).Matrix(isotropic);
  EXPECT_LT((matrix - expected).norm(), 1e-11 * expected.norm());
}

// With one value along warp and weft, and the twist that belongs to it, the terms of warp, weft and twist are the
// isotropic law.
TEST(BendingPatchesTest, SharesAddUpToTheIsotropicLaw) {
  constexpr double kPoisson = 0.3;
  const Mesh mesh = MakeSheet(SheetKind::kIrregular, Square(7));
  const OrthotropicShares shares = SharesOfRigidity(kPoisson);
  const Eigen::MatrixXd sum = Eigen::MatrixXd(Matrix(mesh, shares.warp)) + Eigen::MatrixXd(Matrix(mesh, shares.weft)) +
                              0.5 * (1.0 - kPoisson) * Eigen::MatrixXd(Matrix(mesh, shares.twist));
  const Eigen::MatrixXd isotropic = Matrix(mesh, IsotropicRigidity(1.0, kPoisson));
  EXPECT_LT((sum - isotropic).norm(), 1e-12 * isotropic.norm());
}

}  // namespace
}  // namespace clothid::bending_patch_test
