// What is derived from predictions, against closed forms.
#include "identify/prediction/derived.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "identify/prediction/prediction.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"

namespace clothid::derived_test {
namespace {

// 9 x 9 nodes, flat.
Scene Flat() {
  Scene scene = ClothScene(9, 20);
  scene.handles.nodes = {};
  return scene;
}

double RestArea(const Scene& scene) {
  double area = 0.0;
  for (int f = 0; f < scene.mesh.num_faces(); ++f) {
    const Eigen::Vector3d a = RestCorner(scene.mesh, f, 0);
    area += 0.5 * Eigen::Vector3d(RestCorner(scene.mesh, f, 1) - a).cross(RestCorner(scene.mesh, f, 2) - a).norm();
  }
  return area;
}

// `change` of the place of every node.
template <typename Change>
Eigen::VectorXd Moved(const Scene& scene, const Change& change) {
  Eigen::VectorXd x = scene.initial_positions;
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
    x.segment<3>(3 * node) = change(Eigen::Vector3d(x.segment<3>(3 * node)));
  }
  return x;
}

TEST(DerivedTest, TheAreaIsThatOfTheShadow) {
  const Scene scene = Flat();
  const double area = RestArea(scene);
  EXPECT_NEAR(CoveredArea(scene, scene.initial_positions), area, 0.02 * area);
  const auto tilted = [](const Eigen::Vector3d& x) {
    return Eigen::Vector3d(0.5 * x[0], x[1], std::sqrt(0.75) * x[0]);
  };
  EXPECT_NEAR(CoveredArea(scene, Moved(scene, tilted)), 0.5 * area, 0.02 * area);
  const double middle =
      0.5 * (scene.initial_positions[0] + scene.initial_positions[scene.initial_positions.size() - 3]);
  const auto folded = [middle](const Eigen::Vector3d& x) {
    return x[0] < middle ? x : Eigen::Vector3d(2.0 * middle - x[0], x[1], 0.01);
  };
  EXPECT_NEAR(CoveredArea(scene, Moved(scene, folded)), 0.5 * area, 0.02 * area) << "two layers count once";
}

TEST(DerivedTest, TheStrainIsTheLargestPrincipalStretch) {
  const Scene scene = Flat();
  EXPECT_NEAR(LargestStrain(scene.mesh, scene.initial_positions), 0.0, 1e-12);
  const auto stretched = [](const Eigen::Vector3d& x) { return Eigen::Vector3d(0.9 * x[0], 1.07 * x[1], 0.0); };
  EXPECT_NEAR(LargestStrain(scene.mesh, Moved(scene, stretched)), 0.07, 1e-12);
  // Simple shear by g: the larger stretch is g/2 + sqrt(1 + g^2/4).
  const auto sheared = [](const Eigen::Vector3d& x) { return Eigen::Vector3d(x[0] + 0.2 * x[1], x[1], 0.0); };
  EXPECT_NEAR(LargestStrain(scene.mesh, Moved(scene, sheared)), 0.1 + std::sqrt(1.01) - 1.0, 1e-12);
  const auto turned = [](const Eigen::Vector3d& x) { return Eigen::Vector3d(0.6 * x[0], x[1], 0.8 * x[0]); };
  EXPECT_NEAR(LargestStrain(scene.mesh, Moved(scene, turned)), 0.0, 1e-12);
}

FitPosterior OfStretch(double spread) {
  FitPosterior posterior;
  posterior.path = "result.json";
  posterior.parameters = {{"k_stretch", ParameterScale::kLog, 50.0, 5e-5, 5e7}};
  posterior.covariance = Eigen::MatrixXd::Constant(1, 1, spread * spread);
  return posterior;
}

PredictionOptions Asking(const std::string& text, const Scene& scene) {
  PredictionOptions options;
  options.num_draws = 20;
  options.with_step = options.with_mesh = false;
  options.derived = ParseDerived(text, "--of", scene);
  return options;
}

const DerivedBands& BandsNamed(const std::string& name, const Prediction& prediction) {
  for (const DerivedBands& bands : prediction.derived) {
    if (bands.request.name == name) return bands;
  }
  throw std::logic_error(name);
}

// A cloth that hangs still in a damped end weighs m g, whatever its stretch is; so does what its point does.
TEST(DerivedTest, GrippersCarryTheWeight) {
  Scene scene = ClothScene(4, 400);
  scene.handles.nodes = {0, 1, 2, 3};
  scene.mesh.rest_positions = scene.mesh.rest_positions.eval();
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
    const Eigen::Vector3d x = scene.initial_positions.segment<3>(3 * node);
    scene.initial_positions.segment<3>(3 * node) = Eigen::Vector3d(x[0], 0.0, -x[1]);
  }
  scene.material.damping = 1.0;
  scene.material.drag = 2.0;
  const Prediction prediction = Predict(scene, OfStretch(0.1), Asking("force,point:15", scene));
  const DerivedBands& force = BandsNamed("force", prediction);
  ASSERT_EQ(force.quantiles[0].rows(), 3) << "one gripper";
  const double weight = 9.81 * scene.material.density * RestArea(scene);
  const Eigen::Index last = force.quantiles[0].cols() - 1;
  for (const Eigen::MatrixXd& quantile : force.quantiles) {
    EXPECT_NEAR(quantile(2, last), weight, 0.01 * weight);
    EXPECT_NEAR(quantile(0, last), 0.0, 0.01 * weight);
  }
  const DerivedBands& point = BandsNamed("point_15", prediction);
  for (std::size_t q = 0; q < kBandQuantiles.size(); ++q) {
    EXPECT_EQ(point.quantiles[q].col(last), prediction.quantiles[q].col(last).segment<3>(45));
  }
}

// Flat on a plane that tilts gravity by an angle: it slips at once where tan > mu, and else never.
TEST(DerivedTest, SlipBeginsWhereFrictionIsTooSmall) {
  Scene scene = Flat();
  SceneObstacle plane;
  plane.name = "plane";
  plane.shape = std::make_shared<Plane>(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ());
  scene.obstacles = {plane};
  scene.gravity = 9.81 * Eigen::Vector3d(0.5, 0.0, -std::sqrt(0.75));
  const auto slip = [&](double friction) {
    scene.obstacles[0].friction_coefficient = friction;
    return BandsNamed("slip", Predict(scene, OfStretch(0.01), Asking("slip", scene))).quantiles;
  };
  const double slope = std::tan(std::acos(-1.0) / 6.0);
  for (const Eigen::MatrixXd& quantile : slip(0.9 * slope)) EXPECT_LE(quantile(0, 0), 2.0 * scene.time_step);
  for (const Eigen::MatrixXd& quantile : slip(1.1 * slope)) EXPECT_TRUE(std::isinf(quantile(0, 0)));
}

TEST(DerivedTest, RefusesWhatTheSceneDoesNotHave) {
  const Scene scene = Flat();
  const auto expect_refused = [&](const std::string& text, std::initializer_list<const char*> fragments) {
    ExpectError([&] { ParseDerived(text, "--of", scene); }, ErrorKind::kUsage, fragments);
  };
  expect_refused("luck", {"--of", "point:NODE", "'luck'"});
  expect_refused("point:81", {"a node from 0 to 80"});
  expect_refused("point:", {"a node from 0 to 80"});
  expect_refused("area,area", {"'area' is given twice"});
  expect_refused("force", {"a scene with handles"});
  expect_refused("slip", {"a scene with obstacles"});
  EXPECT_EQ(ParseDerived(" point:12, strain", "--of", scene)[0].name, "point_12");
}

TEST(DerivedTest, GrippersAreHandlesThatEdgesJoin) {
  Scene scene = Flat();
  scene.handles.nodes = {8, 0, 80, 1};
  EXPECT_EQ(GripperNodes(scene), (std::vector<std::vector<int>>{{8}, {0, 1}, {80}}));
}

}  // namespace
}  // namespace clothid::derived_test
