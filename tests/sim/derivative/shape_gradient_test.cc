// adjoint = sensitivity = central finite differences of a cloth on each of the shapes that has a kind of its own.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <memory>
#include <set>
#include <string>
#include <tuple>

#include "sim/obstacle/box.h"
#include "sim/obstacle/round_shapes.h"
#include "tests/sim/derivative/gradient_case.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid::shape_gradient_test {
namespace {

using Eigen::Vector3d;
using ShapeParam = std::tuple<std::string, Integrator>;

// What a cloth of 0.3 m, whose middle is the origin, falls on.
SceneObstacle ShapeUnder(const std::string& name) {
  SceneObstacle obstacle;
  obstacle.name = name;
  obstacle.contact_distance = 0.005;
  if (name == "box") {
    const Eigen::Quaterniond tilt(Eigen::AngleAxisd(0.5, Vector3d(0.6, 0.8, 0.1).normalized()));
    obstacle.shape = std::make_shared<Box>(Vector3d(0.01, 0.0, -0.12), Vector3d(0.2, 0.16, 0.15), tilt, 0.03);
  } else if (name == "table") {
    obstacle.shape = std::make_shared<Box>(
        Box::Table({-0.1, 0.02, -0.02}, {0.02, 0.01, 1.0}, {1.0, 0.2, 0.0}, {0.22, 0.6}, 0.04, 0.02));
  } else if (name == "cylinder") {
    obstacle.shape = std::make_shared<Cylinder>(Vector3d(0.01, 0.02, -0.2), Vector3d(0.03, 0.01, -0.02), 0.08);
  } else if (name == "torus") {
    obstacle.shape = std::make_shared<Torus>(Vector3d(0.01, 0.02, -0.05), Vector3d(0.1, 0.2, 1.0), 0.09, 0.03);
  } else {
    obstacle.shape = std::make_shared<Bowl>(Vector3d(0.01, 0.02, -0.02), Vector3d(0.1, -0.1, 1.0), 0.13, 1.5, 0.02);
  }
  return obstacle;
}

Scene SceneOn(const ShapeParam& param) {
  Scene scene = ShippedScene("drape", 9, std::get<1>(param));
  scene.handles = {};
  scene.duration = 0.3;
  Eigen::Matrix3Xd& rest = scene.mesh.rest_positions;
  rest.row(2).setZero();
  rest.colwise() -= rest.rowwise().mean().eval();
  rest *= 0.3 / (rest.row(0).maxCoeff() - rest.row(0).minCoeff());
  scene.initial_positions = rest.reshaped();
  scene.obstacles = {ShapeUnder(std::get<0>(param))};
  return scene;
}

class ShapeGradientTest : public ::testing::TestWithParam<ShapeParam> {};

TEST_P(ShapeGradientTest, AdjointEqualsSensitivityEqualsDifferences) {
  const Scene scene = SceneOn(GetParam());
  const GradientCase gradient(scene);
  const Rollout& rollout = gradient.rollout();
  std::set<int> touching;
  int curved = 0;
  for (int step = 1; step < rollout.num_steps(); ++step) {
    for (const ContactRecord& contact : rollout.records[rollout.last_record[step]].contacts.nodes) {
      const Vector3d start = rollout.positions(step).segment<3>(3 * contact.node);
      touching.insert(contact.node);
      curved += scene.obstacles[0].shape->Closest(start).normal_gradient.norm() > 1.0;
    }
  }
  EXPECT_GE(touching.size(), 5u);
  EXPECT_GT(curved, 25) << "contacts where the normal turns";
  EXPECT_TRUE(gradient.HasInfluence("mu"));
  ExpectAgreement(gradient, 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Shapes, ShapeGradientTest,
                         ::testing::Combine(::testing::Values("box", "table", "cylinder", "torus", "bowl"),
                                            ::testing::Values(Integrator::kEuler, Integrator::kSdirk2)),
                         [](const auto& test) {
                           return std::get<0>(test.param) +
                                  (std::get<1>(test.param) == Integrator::kEuler ? "" : "Sdirk2");
                         });

}  // namespace
}  // namespace clothid::shape_gradient_test
