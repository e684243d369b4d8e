// Bending about a curved rest shape: differences, cylinders, and a curved beam.
#include "sim/shell/rest_curvature.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/matrix/dense.h"
#include "sim/shell/bending_patch.h"
#include "tests/sim/forces_of.h"
#include "tests/sim/plain_scenes.h"
#include "tests/sim/sheet_meshes.h"

namespace clothid::rest_curvature_test {
namespace {

constexpr double kRadius = 0.05;    // m
constexpr double kRigidity = 1e-4;  // N m

// A sheet half as wide as it is long.
GridOptions Sheet(int nodes, double length) {
  GridOptions grid;
  grid.nodes = {nodes, (nodes + 1) / 2};
  grid.size = {length, 0.5 * length};
  return grid;
}

// A sheet of the xy plane rolled onto a cylinder about the y axis: x becomes the arc, which begins at `angle`.
Eigen::Matrix3Xd Rolled(const Eigen::Matrix3Xd& flat, double radius, double angle = 0.0) {
  Eigen::Matrix3Xd rolled(3, flat.cols());
  for (Eigen::Index node = 0; node < flat.cols(); ++node) {
    const double turn = angle + flat(0, node) / radius;
    rolled.col(node) << radius * std::cos(turn), flat(1, node), radius * std::sin(turn);
  }
  return rolled;
}

Scene SceneOf(const Mesh& mesh) {
  Scene scene = ClothScene(Sheet(3, 1.0), 0.01);
  scene.mesh = mesh;
  scene.initial_positions = mesh.rest_positions.reshaped();
  scene.initial_velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
  scene.material.stretch_stiffness = 1000.0;
  scene.material.bending_stiffness = kRigidity;
  scene.material.density = 0.2;
  return scene;
}

// What a half cylinder is before it is rolled.
Mesh FlatSheet(SheetKind kind, int nodes) { return MakeSheet(kind, Sheet(nodes, kPi * kRadius)); }

Mesh HalfCylinder(SheetKind kind, int nodes) {
  Mesh mesh = FlatSheet(kind, nodes);
  mesh.rest_positions = Rolled(mesh.rest_positions, kRadius);
  return mesh;
}

// The bending of a scene, whose constants it takes to be 1.
class Bending1 {
 public:
  explicit Bending1(Scene scene) : scene_(std::move(scene)), model_(scene_) {}

  const ClothModel& model() const { return model_; }

  double Energy(const Eigen::VectorXd& positions) const {
    Eigen::VectorXd unused = Eigen::VectorXd::Zero(positions.size());
    double energy = 0.0;
    for (const BendingTerm* term : BendingOf(model_)) energy += AddBendingForce(*term, 1.0, positions, &unused);
    return energy;
  }

  Eigen::VectorXd Force(const Eigen::VectorXd& positions) const {
    Eigen::VectorXd force = Eigen::VectorXd::Zero(positions.size());
    for (const BendingTerm* term : BendingOf(model_)) AddBendingForce(*term, 1.0, positions, &force);
    return force;
  }

  // Over the free nodes.
  Eigen::MatrixXd Hessian(HessianKind kind, const Eigen::VectorXd& positions) const {
    BlockMatrix hessian(model_.pattern());
    for (const BendingTerm* term : BendingOf(model_)) {
      Parameters parameters;
      parameters.material.*RowOf(term->kind()).constant = 1.0;
      term->AddPositionHessian(1.0, kind, {parameters, 0.0, 0.0, positions, positions}, nullptr, &hessian);
    }
    hessian.CompleteFromLower();
    return hessian.view();
  }

 private:
  const Scene scene_;
  const ClothModel model_;
};

Eigen::VectorXd Noise(Eigen::Index size, double scale) {
  std::mt19937_64 generator(4);
  std::normal_distribution<double> normal(0.0, scale);
  return Eigen::VectorXd::NullaryExpr(size, [&] { return normal(generator); });
}

class RestCurvatureTest : public ::testing::TestWithParam<SheetKind> {};

TEST_P(RestCurvatureTest, IsThatOfTheCylinder) {
  const Mesh mesh = HalfCylinder(GetParam(), 17);
  const Eigen::Matrix3Xd warp = Eigen::Vector3d::UnitY().replicate(1, mesh.num_faces());
  const BendingPatches patches(mesh, warp, BendingRest::kMesh);
  for (const BendingPatch& patch : patches.patches()) {
    EXPECT_NEAR(patch.curvature[0] * kRadius, 0.0, 0.03);
    EXPECT_NEAR(patch.curvature[1] * kRadius, 1.0, 0.03);
    EXPECT_NEAR(patch.curvature[2] * kRadius, 0.0, 0.03);
  }
}

TEST_P(RestCurvatureTest, RestIsFreeHoweverItIsTurned) {
  const Mesh mesh = HalfCylinder(GetParam(), 9);
  const Bending1 bending(SceneOf(mesh));
  const double of_flat = 0.5 * TriangleAreas(mesh).sum() / (kRadius * kRadius);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(2.0, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
  const Eigen::Matrix3Xd moved = (turn * mesh.rest_positions).colwise() + kRadius * Eigen::Vector3d(0.3, -1.0, 2.0);
  for (const Eigen::VectorXd& positions :
       {Eigen::VectorXd(mesh.rest_positions.reshaped()), Eigen::VectorXd(moved.reshaped())}) {
    EXPECT_NEAR(bending.Energy(positions), 0.0, 1e-11 * of_flat);
    EXPECT_LT(bending.Force(positions).norm(), 1e-9 * of_flat / kRadius);
    for (const double scale : {1e-4, 1e-3, 1e-2, 1e-1}) {
      EXPECT_GT(bending.Energy(positions + Noise(positions.size(), scale * kRadius)), 0.0) << scale;
    }
  }
}

// D/2 area (change of curvature)^2, also to the other side and flat.
TEST_P(RestCurvatureTest, AnotherRadiusCostsTheChangeOfCurvature) {
  const Mesh flat = FlatSheet(GetParam(), 17), mesh = HalfCylinder(GetParam(), 17);
  const Bending1 bending(SceneOf(mesh));
  for (const double ratio : {0.7, 0.9, 1.2, 3.0, 1e6, -2.0}) {  // radius now over that at rest
    const Eigen::Matrix3Xd positions =
        std::abs(ratio) > 1e5 ? flat.rest_positions : Rolled(flat.rest_positions, ratio * kRadius);
    const double change = (1.0 / ratio - 1.0) / kRadius;
    const double expected = 0.5 * TriangleAreas(mesh).sum() * change * change;
    EXPECT_NEAR(bending.Energy(positions.reshaped()), expected, 0.02 * expected) << ratio;
  }
}

TEST_P(RestCurvatureTest, ForceAndHessianAreDerivatives) {
  Scene scene = SceneOf(HalfCylinder(GetParam(), 6));
  scene.bending.poisson = 0.3;
  scene.handles.nodes = {0, 7, 8, 14};
  const Bending1 bending(scene);
  const ClothModel& model = bending.model();
  const Eigen::VectorXd positions = scene.initial_positions + Noise(scene.initial_positions.size(), 0.1 * kRadius);
  const Eigen::VectorXd free = Noise(3 * model.num_free(), 1.0), along = model.ScatterColumns(free).reshaped();
  const double step = 1e-5 * kRadius;
  const Eigen::VectorXd plus = positions + step * along, minus = positions - step * along;
  const double slope = (bending.Energy(plus) - bending.Energy(minus)) / (2.0 * step);
  EXPECT_NEAR(-bending.Force(positions).dot(along), slope, 1e-6 * std::abs(slope));
  const Eigen::VectorXd change =
      -model.Gather(Eigen::VectorXd(bending.Force(plus) - bending.Force(minus))) / (2.0 * step);
  const Eigen::MatrixXd hessian = bending.Hessian(HessianKind::kExact, positions);
  EXPECT_EQ((hessian - hessian.transpose()).norm(), 0.0);
  EXPECT_LT((hessian * free - change).norm(), 1e-6 * change.norm());
}

TEST_P(RestCurvatureTest, ClampedHessianIsPositiveAndAtRestExact) {
  const Scene scene = SceneOf(HalfCylinder(GetParam(), 6));
  const Bending1 bending(scene);
  const Eigen::VectorXd& rest = scene.initial_positions;
  const Eigen::MatrixXd exact = bending.Hessian(HessianKind::kExact, rest),
                        clamped = bending.Hessian(HessianKind::kClamped, rest);
  EXPECT_LT((exact - clamped).norm(), 1e-10 * exact.norm());
  const Eigen::VectorXd wild = rest + Noise(rest.size(), kRadius);
  const Eigen::VectorXd values = SymmetricEigenvalues(bending.Hessian(HessianKind::kClamped, wild));
  EXPECT_GT(values[0], -1e-12 * values[values.size() - 1]);
}

TEST_P(RestCurvatureTest, AHalfCylinderStaysAsItIs) {
  Scene scene = SceneOf(HalfCylinder(GetParam(), 9));
  scene.gravity.setZero();
  const auto moved = [&scene] {
    return (SimulateNominal(scene, 10).positions(10) - scene.initial_positions).cwiseAbs().maxCoeff();
  };
  EXPECT_LT(moved(), 1e-9 * kRadius);
  scene.bending.is_flat_at_rest = true;
  EXPECT_GT(moved(), 0.1 * kRadius) << "it bends flat";
}

INSTANTIATE_TEST_SUITE_P(Kinds, RestCurvatureTest, ::testing::ValuesIn(kSheetKinds),
                         [](const auto& test) { return SheetName(test.param); });

// A flat cloth, also one that lies askew, has the quadratic energy alone.
TEST(RestCurvatureOfFlatMeshesTest, ThereIsNone) {
  Mesh mesh = FlatSheet(SheetKind::kIrregular, 9);
  EXPECT_TRUE(IsFlat(mesh));
  EXPECT_EQ(BendingOf(Bending1(SceneOf(mesh)).model())[0]->curvature(), nullptr);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, 0.5).normalized()).toRotationMatrix();
  mesh.rest_positions = (1e6 * (turn * mesh.rest_positions)).array().round().matrix() / 1e6;  // as in a file
  EXPECT_TRUE(IsFlat(mesh));
  EXPECT_FALSE(IsFlat(HalfCylinder(SheetKind::kAlternating, 9)));
  Scene scene = SceneOf(HalfCylinder(SheetKind::kAlternating, 9));
  EXPECT_NE(BendingOf(Bending1(scene).model())[0]->curvature(), nullptr);
  scene.bending.law = BendingLaw::kEdges;
  EXPECT_EQ(BendingOf(Bending1(scene).model())[0]->curvature(), nullptr);
}

// With shares along warp and weft the terms add up to the isotropic law.
TEST(RestCurvatureAlongYarnsTest, SharesAddUp) {
  Scene scene = SceneOf(HalfCylinder(SheetKind::kIrregular, 7));
  scene.bending.poisson = 0.3;
  const Bending1 isotropic(scene);
  scene.bending.orthotropic = true;
  scene.warp.direction = {0.3, 1.0, 0.2};
  scene.material.bending_stiffness = 0.0;
  scene.material.warp_bending = scene.material.weft_bending = scene.material.twist_bending = 1.0;
  const Bending1 shares(scene);
  ASSERT_EQ(BendingOf(shares.model()).size(), 3u);
  const Eigen::VectorXd positions = scene.initial_positions + Noise(scene.initial_positions.size(), 0.1 * kRadius);
  double sum = 0.0;
  Eigen::VectorXd unused = Eigen::VectorXd::Zero(positions.size());
  for (const BendingTerm* term : BendingOf(shares.model())) {
    const bool is_twist = term->kind() == ParameterKind::kTwistBending;
    sum += (is_twist ? 0.35 : 1.0) * AddBendingForce(*term, 1.0, positions, &unused);
  }
  EXPECT_NEAR(sum, isotropic.Energy(positions), 1e-10 * sum);
}

constexpr int kHeld = 4, kColumns = 24 + kHeld, kRows = 5;

// A half ring, clamped at one end, that sags a little under its weight.
class CurvedBeamTest : public ::testing::TestWithParam<SheetKind> {};

// Of a thin curved beam. At the angle a from the free end the weight beyond has the moment q R^2 (sin a - a cos a), and
// a unit force at the tip R (1 - cos a), so that the tip sinks by the integral of their product,
// q R^4/D (4 + pi^2/4), with q the weight per area.
TEST_P(CurvedBeamTest, SagsAsTheory) {
  constexpr double kSpacing = kPi * kRadius / (kColumns - kHeld + 0.5);
  GridOptions grid;
  grid.nodes = {kColumns, kRows};
  grid.size = {(kColumns - 1) * kSpacing, (kRows - 1) * kSpacing};
  grid.origin = {-(kHeld - 1.5) * kSpacing, 0.0, 0.0};
  Mesh mesh = MakeSheet(GetParam(), grid, kHeld);
  mesh.rest_positions = Rolled(mesh.rest_positions, -kRadius, kPi);  // the tip is at angle 0 ...
  mesh.rest_positions.row(0) *= -1.0;                                // ... on the side of positive x
  mesh.rest_positions.row(2) *= -1.0;
  Scene scene = SceneOf(mesh);
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kHeld; ++column) scene.handles.nodes.push_back(row * kColumns + column);
  }
  const double weight = 1e-3 * kRigidity / std::pow(kRadius, 3);  // N/m^2
  scene.gravity = {0.0, 0.0, -weight / scene.material.density};
  scene.time_step = 0.3;
  const Rollout rollout = SimulateNominal(scene, 40);
  const auto tip = [&](int step) {
    double sum = 0.0;
    for (int row = 0; row < kRows; ++row) sum += rollout.positions(step)[3 * (row * kColumns + kColumns - 1) + 2];
    return sum / kRows;
  };
  const double expected = weight * std::pow(kRadius, 4) / kRigidity * (4.0 + 0.25 * kPi * kPi);
  EXPECT_NEAR(tip(40), tip(39), 1e-4 * expected);
  EXPECT_NEAR(tip(0) - tip(40), expected, 0.02 * expected);
}

INSTANTIATE_TEST_SUITE_P(Kinds, CurvedBeamTest,
                         ::testing::Values(SheetKind::kRightAngled, SheetKind::kAlternating, SheetKind::kIrregular),
                         [](const auto& test) { return SheetName(test.param); });

}  // namespace
}  // namespace clothid::rest_curvature_test
