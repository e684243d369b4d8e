#include "sim/scene/material_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/scene_json.h"
#include "tests/expect_error.h"
#include "tests/sim/plain_scenes.h"
#include "tests/temporary_folder.h"

namespace clothid::material_field_test {
namespace {

Mesh UprightCloth() {
  GridOptions grid;
  grid.nodes = {9, 5};
  grid.size = {0.4, 0.2};
  grid.axes = {Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitZ()};
  return MakeGrid(grid);
}

// The logarithm is bilinear: it is exact where it is, along the grid's axes, whatever the mesh.
TEST(MaterialField, LogarithmIsBilinearOverTheCloth) {
  const Mesh mesh = UprightCloth();
  const Eigen::SparseMatrix<double> weights = ControlWeights(mesh, 3, 4, "test");
  Eigen::MatrixXd logs(3, 4);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 4; ++c) logs(r, c) = 0.5 + 2.0 * r - 0.3 * c + 0.7 * r * c;
  }
  const Eigen::VectorXd values = weights * LogsOf(logs.array().exp());
  for (int f = 0; f < mesh.num_faces(); ++f) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (int i = 0; i < 3; ++i) centre += mesh.rest_positions.col(mesh.faces(i, f)) / 3.0;
    // Columns along x, rows up z.
    const double c = 3.0 * centre.x() / 0.4, r = 2.0 * (centre.z() + 0.2) / 0.2;
    EXPECT_NEAR(values[f], 0.5 + 2.0 * r - 0.3 * c + 0.7 * r * c, 1e-12) << f;
  }
}

TEST(MaterialField, LevelIsTheGeometricMeanOverTheArea) {
  const Mesh mesh = UprightCloth();
  GridField grid;
  grid.values.resize(1, 2);
  grid.values << 20.0, 80.0;
  double level = 0.0;
  const FieldFactors factors = FieldOverTriangles(grid, mesh, &level);
  EXPECT_NEAR(level, 40.0, 1e-9);
  EXPECT_NEAR(TriangleAreas(mesh).dot(factors.log_factors), 0.0, 1e-12);
}

TEST(MaterialField, IsOfStiffnessesRigiditiesAndDensity) {
  for (const char* name : {"k_stretch", "k_warp", "k_weft", "k_shear", "k_bend", "bend_twist", "density"}) {
    EXPECT_TRUE(CanBeField(ParseFieldKind(name, "test"))) << name;
  }
  for (const char* name : {"mu", "drag", "damping", "k_poisson", "stiffening_warp", "added_mass", "pressure", ""}) {
    ExpectError([&] { ParseFieldKind(name, "test"); }, ErrorKind::kUsage, {"test: '", "can be no field", "k_warp"});
  }
}

// k_poisson^2 < k_warp k_weft at every triangle.
TEST(MaterialField, KeepsTheEnergyBounded) {
  Scene scene = ClothScene(SquareGrid(3, 0.2), 0.01);
  scene.membrane = MembraneLaw::kOrthotropic;
  scene.material.warp_stiffness = scene.material.weft_stiffness = 100.0;
  scene.material.shear_stiffness = 30.0;
  scene.material.poisson_stiffness = 40.0;
  scene.fields.push_back({ParameterKind::kWarpStiffness, Eigen::Vector2d(20.0, 500.0).transpose()});
  ValidateScene(scene, "test");
  scene.fields[0].values(0, 0) = 15.0;
  ExpectError([&] { ValidateScene(scene, "test"); }, ErrorKind::kBadData, {"k_poisson^2 < k_warp k_weft"});
  scene.fields[0].kind = ParameterKind::kStretchStiffness;
  ExpectError([&] { ValidateScene(scene, "test"); }, ErrorKind::kBadData, {"fields.k_stretch", "expected none"});
}

TEST(MaterialField, RefusesARestShapeWithoutAFront) {
  Scene scene = ClothScene(SquareGrid(3, 0.2), 0.01);
  PutSleeve(4, 12, 0.05, 0.02, &scene);
  scene.fields.push_back({ParameterKind::kStretchStiffness, Eigen::MatrixXd::Constant(2, 2, 50.0)});
  ExpectError([&] { Simulator simulator(scene); }, ErrorKind::kBadData, {"expected a cloth with a front"});
}

// A field that is the same everywhere is the constant.
TEST(MaterialField, UniformFieldChangesNothing) {
  Scene scene = ClothScene(SquareGrid(6, 0.2), 0.01);
  scene.handles.nodes = {0, 5};
  scene.material.bending_stiffness = 1e-4;
  scene.material.drag = 0.1;
  const Rollout plain = SimulateNominal(scene, 20);
  const Material& material = scene.material;
  scene.fields = {{ParameterKind::kDensity, Eigen::MatrixXd::Constant(2, 3, material.density)},
                  {ParameterKind::kStretchStiffness, Eigen::MatrixXd::Constant(4, 1, material.stretch_stiffness)},
                  {ParameterKind::kBendingStiffness, Eigen::MatrixXd::Constant(1, 1, material.bending_stiffness)}};
  const Rollout uniform = SimulateNominal(scene, 20);
  EXPECT_LE((uniform.positions(20) - plain.positions(20)).norm(), 1e-9 * plain.positions(20).norm());
}

// A hanging strip whose lower half is ten times as stiff: each half is strained by the weight below it.
TEST(MaterialField, EachPartOfAHangingStripHasItsOwnStiffness) {
  GridOptions grid;
  grid.nodes = {3, 21};
  grid.size = {0.02, 0.2};
  grid.axes = {Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitZ()};
  Scene scene = ClothScene(grid, 0.05);
  scene.handles.nodes = {0, 1, 2};
  scene.material.drag = 2.0;
  scene.material.damping = 1.0;
  Eigen::MatrixXd values = Eigen::MatrixXd::Constant(201, 1, 200.0);
  values.topRows(101).setConstant(2000.0);
  scene.fields = {{ParameterKind::kStretchStiffness, values}};
  const Rollout rollout = SimulateNominal(scene, 400);
  const Eigen::Matrix3Xd x = rollout.positions(400).reshaped(3, scene.mesh.num_nodes());
  const double weight = scene.material.density * 9.81;  // per m^2
  const double lower = 0.1 * weight * 0.05 / 2000.0, upper = 0.1 * weight * 0.15 / 200.0;
  const double middle = -x(2, 3 * 10 + 1), end = -x(2, 3 * 20 + 1);
  EXPECT_NEAR(middle - 0.1, upper, 0.02 * upper);
  EXPECT_NEAR(end - middle - 0.1, lower, 0.05 * lower);
}

TEST(MaterialField, ValuesPassThroughAFile) {
  const TemporaryFolder folder;
  Eigen::MatrixXd values(2, 3);
  values << 1.0, 2.0, 3.0, 4.0, 5.0, 6.5;
  EXPECT_TRUE(ReadFieldValues(folder.Write("field.npy", FieldValuesNpy(values))) == values);
  const std::string path = folder.Write("negative.npy", FieldValuesNpy(-values));
  ExpectError([&] { ReadFieldValues(path); }, ErrorKind::kBadData, {path.c_str(), ": expected finite numbers > 0"});
}

constexpr char kSceneStart[] =
    R"({"clothid_scene": 1, "duration": 0.1, "mesh": {"grid": {"nodes": [3, 3], "size": [0.1, 0.1]}})";

TEST(MaterialField, SceneTextHoldsFields) {
  const Scene scene = ParseScene(
      std::string(kSceneStart) + R"(, "fields": {"k_stretch": [[10, 20, 40], [10, 20, 40]], "k_bend": [[1e-4]]}})",
      "scene.json", "");
  ASSERT_EQ(scene.fields.size(), 2u);
  EXPECT_EQ(scene.fields[0].values(1, 2), 40.0);
  EXPECT_TRUE(scene.has_bending());
  EXPECT_NEAR(scene.nominal_parameters().material.stretch_stiffness, 20.0, 1e-9);
}

TEST(MaterialField, SceneTextErrorsNameTheKey) {
  const auto expect = [](const std::string& fields, const std::string& message) {
    ExpectError([&] { ParseScene(std::string(kSceneStart) + ", \"fields\": " + fields + "}", "scene.json", ""); },
                ErrorKind::kBadData, {message.c_str()});
  };
  expect("[1]", "key 'fields'");
  expect(R"({"mu": [[1]]})", "key 'fields.mu'");
  expect(R"({"k_stretch": []})", "key 'fields.k_stretch': expected 1 to 256 rows");
  expect(R"({"k_stretch": [[]]})", "key 'fields.k_stretch': expected 1 to 256 rows");
  expect(R"({"k_stretch": [[1, 2], [3]]})", "key 'fields.k_stretch[1]': expected 2 numbers");
  expect(R"({"k_stretch": [[1, 0]]})", "key 'fields.k_stretch[0][1]'");
  expect(R"({"k_stretch": 3})", "key 'fields.k_stretch'");
}

TEST(MaterialField, ParametersMustHaveTheFieldsOfTheScene) {
  Scene scene = ClothScene(SquareGrid(4, 0.2), 0.01);
  scene.handles.nodes = {0};
  Scene with_field = scene;
  with_field.fields = {{ParameterKind::kStretchStiffness, Eigen::MatrixXd::Constant(2, 2, 50.0)}};
  const Parameters parameters = with_field.nominal_parameters();
  Simulator simulator(scene);
  ExpectError([&] { Simulate(parameters, 1, &simulator); }, ErrorKind::kBadData, {"expected the fields of the scene"});
}

}  // namespace
}  // namespace clothid::material_field_test
