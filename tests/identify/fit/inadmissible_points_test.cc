// Points at which the rollout fails are not numbers to a fit: it goes around them, or says that it could not.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <memory>

#include "identify/fit/fit.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::inadmissible_points_test {
namespace {

// Where a node gets beyond y, the step that starts there has no solution.
class Abyss : public Obstacle {
 public:
  explicit Abyss(double y) : y_(y) {}
  SurfacePoint Closest(const Eigen::Vector3d& position) const override {
    SurfacePoint point;
    point.gap = position.y() < y_ ? 1.0 : std::numeric_limits<double>::quiet_NaN();
    return point;
  }

 private:
  double y_;  // m
};

constexpr double kTrueDrag = 0.25;

// A hanging cloth in a steady wind along y.
Scene WindyScene() {
  Scene scene = SwingScene();
  scene.wind.mean = {0.0, 5.0, 0.0};
  return scene;
}

// How far the wind carries a node, m.
double Reach(double drag) {
  const Scene scene = WindyScene();
  Parameters parameters = scene.nominal_parameters();
  parameters.material.drag = drag;
  Simulator simulator(scene);
  const Rollout rollout = Simulate(parameters, scene.num_steps(), &simulator);
  double reach = 0.0;
  for (int step = 0; step < rollout.num_steps(); ++step) {
    reach = std::max(reach, rollout.positions(step).reshaped(3, scene.mesh.num_nodes()).row(1).maxCoeff());
  }
  return reach;
}

// Recorded without the abyss, which swallows the cloth where the drag is above `largest_drag`.
FitSummary FitDragBefore(double largest_drag) {
  RecordedMotion motion = MakeMotion(WindyScene(), {{{"drag", kTrueDrag}}, 0.0, 0.0, 0.0});
  motion.scene.obstacles.push_back({"abyss", std::make_shared<Abyss>(Reach(largest_drag)), 0.3, 0.0});
  FitOptions options;
  options.parameters = {"drag"};
  options.overrides.start["drag"] = 0.02;
  options.max_iterations = 100;
  FitProblem problem({motion}, options);
  return Fit(options, &problem);
}

TEST(InadmissiblePointsTest, BeyondTheMinimumAreGoneAround) {
  const FitSummary summary = FitDragBefore(2.0 * kTrueDrag);
  EXPECT_GT(summary.statistics.counts.failed_steps, 0);
  EXPECT_EQ(summary.status, FitStatus::kConverged) << summary.message;
  EXPECT_NEAR(summary.parameters[0].value, kTrueDrag, 1e-5 * kTrueDrag);
}

// Steps cut short by failures meet every tolerance of the optimiser.
TEST(InadmissiblePointsTest, BeforeTheMinimumAreNoConvergence) {
  const FitSummary summary = FitDragBefore(0.8 * kTrueDrag);
  EXPECT_EQ(summary.status, FitStatus::kNotConverged);
  EXPECT_NE(summary.message.find("synthetic: step "), std::string::npos) << summary.message;
  ASSERT_TRUE(summary.has_estimate());
  EXPECT_LE(summary.parameters[0].value, 0.8 * kTrueDrag);
}

// With few iterations per step, stiff cloth on a ball works with the tolerances of the loose pass alone. Such a fit
// ends at the truth or says that it did not. Backward Euler, whose solves are harder: their steps are longer.
TEST(LooselyAdmissiblePointsTest, DoNotEndAFit) {
  Scene scene = SphereScene();
  scene.integrator = Integrator::kEuler;
  scene.bending.law = BendingLaw::kEdges;
  const std::map<std::string, double> truth = {{"mu", 0.35}, {"k_stretch", 400.0}};
  for (const double start : {0.3, 1.0, 4.0}) {
    RecordedMotion motion = MakeMotion(scene, {truth, 0.0, 0.0, 0.0});
    motion.scene.solver.max_newton_iterations = 3;
    motion.scene.solver.max_substep_halvings = 0;
    FitOptions options;
    options.overrides.start["k_stretch"] = start;
    options.max_iterations = 100;
    FitProblem problem({motion}, options);
    const FitSummary summary = Fit(options, &problem);
    EXPECT_GT(summary.statistics.counts.failed_steps, 0);
    EXPECT_NE(summary.status, FitStatus::kFailed) << summary.message;
    if (summary.status != FitStatus::kConverged) continue;
    for (const FittedParameter& parameter : summary.parameters) {
      EXPECT_NEAR(parameter.value, truth.at(parameter.name), 1e-5 * truth.at(parameter.name)) << parameter.name;
    }
  }
}

}  // namespace
}  // namespace clothid::inadmissible_points_test
