// Wind and drag in closed form.
#include "sim/force/air_drag.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/cloth/cloth_model.h"
#include "sim/step/step_problem.h"
#include "tests/sim/plain_scenes.h"

namespace clothid::air_drag_test {
namespace {

// A cloth in a steady wind with gusts that run across it.
class AirDragTest : public ::testing::Test {
 protected:
  AirDragTest() : scene_(ClothScene(SquareGrid(4, 0.3), 0.01)) {
    scene_.material.drag = 0.7;
    scene_.wind.mean = {1.0, -2.0, 0.5};
    scene_.wind.gust = {0.0, 3.0, 1.0};
    scene_.wind.frequency = 9.0;
    scene_.wind.wave_vector = {2.0, 5.0, 0.0};
  }

  Scene scene_;
};

TEST_F(AirDragTest, TheWindIsAWave) {
  const AirDrag drag(scene_);
  for (const int node : {0, 6, 15}) {
    const double phase = scene_.wind.wave_vector.dot(scene_.mesh.rest_positions.col(node));
    for (const double time : {0.0, 0.3}) {
      const Eigen::Vector3d expected =
          scene_.wind.mean + std::sin(scene_.wind.frequency * time + phase) * scene_.wind.gust;
      EXPECT_LT((drag.WindAt(node, time, scene_.wind) - expected).norm(), 1e-14) << node << " " << time;
    }
  }
}

TEST_F(AirDragTest, TheAreasOfTheNodesAreThatOfTheCloth) {
  const AirDrag drag(scene_);
  EXPECT_GT(drag.areas().minCoeff(), 0.0);
  EXPECT_NEAR(drag.areas().sum(), 0.09, 1e-15);
}

// What a step with drag has more than one without: h c_d a (v - w) in g, and in the potential one of which that is the
// gradient, so their differences agree.
TEST_F(AirDragTest, TheImpulseOfAStepIsTheFormula) {
  Scene still = scene_;
  still.material.drag = 0.0;
  Simulator simulator(scene_), still_simulator(still);
  const double h = scene_.time_step, end_time = 0.2;
  const Eigen::VectorXd start = scene_.initial_positions, rest = scene_.initial_velocities;
  const Parameters parameters = scene_.nominal_parameters(), still_parameters = still.nominal_parameters();
  const StepProblem problem(simulator.model(), parameters, {start, rest}, {h, end_time}, &simulator.step_workspace());
  const StepProblem without(still_simulator.model(), still_parameters, {start, rest}, {h, end_time},
                            &still_simulator.step_workspace());
  const auto drag_of = [&](const Eigen::VectorXd& v, Eigen::VectorXd* impulse) {
    StepPoint point, still_point;
    problem.Evaluate(v, &point);
    without.Evaluate(v, &still_point);
    *impulse = point.momentum_gradient - still_point.momentum_gradient;
    return point.potential - still_point.potential;
  };
  const ClothModel& model = simulator.model();
  ASSERT_EQ(model.free_nodes(), still_simulator.model().free_nodes());
  const Eigen::VectorXd velocities = Eigen::VectorXd::LinSpaced(3 * model.num_free(), -1.0, 2.0);
  const Eigen::VectorXd direction = Eigen::VectorXd::LinSpaced(3 * model.num_free(), 1.0, -0.5);
  Eigen::VectorXd impulse, unused;
  drag_of(velocities, &impulse);
  for (int i = 0; i < model.num_free(); ++i) {
    const int node = model.free_nodes()[i];
    const Eigen::Vector3d expected =
        h * 0.7 * model.nodes().drag()->areas()[node] *
        (velocities.segment<3>(3 * i) - model.nodes().drag()->WindAt(node, end_time, scene_.wind));
    EXPECT_LT((impulse.segment<3>(3 * i) - expected).norm(), 1e-14) << node;
  }
  const double difference = 0.5 * (drag_of(velocities + direction, &unused) - drag_of(velocities - direction, &unused));
  EXPECT_NEAR(impulse.dot(direction), difference, 1e-12 * std::abs(difference));
}

}  // namespace
}  // namespace clothid::air_drag_test
