// Whole fits of noisy recordings seen from elsewhere, in other units, with other numbers for the nodes: the same
// estimates.
//
// A fit ends where the next step is below the resolution of its parameters or its gain below the function tolerance. So
// two that are the same up to rounding may end two resolutions apart, with costs and uncertainties to match.
#include <gtest/gtest.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "identify/fit/fit.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/sim/property_seeds.h"
#include "tests/sim/random_numbers.h"
#include "tests/sim/scene_transforms.h"

namespace clothid::fit_invariance_test {
namespace {

struct FitCase {
  RandomScene scene;  // not random, but with its shapes
  RecordedMotion motion;
  FitOptions options;
};

RecordedMotion Record(const Scene& scene, const std::map<std::string, double>& truth, double sigma) {
  MotionOptions options;
  options.true_values = truth;
  options.noise = 1e-3;
  options.sigma = sigma;
  options.frame_interval = 1.25 * scene.time_step;
  return MakeMotion(scene, options);
}

// A cloth in gusts, shaken by its handles; the recording does not know its sigma.
FitCase ShakenInGusts() {
  FitCase result;
  Scene& scene = result.scene.scene;
  scene = SwingScene();
  scene.wind = {{1.0, 0.5, 0.0}, {0.5, -1.0, 0.5}, 20.0, {5.0, 10.0, 0.0}};
  Eigen::MatrixXd path(6, 3);
  for (int i = 0; i < 2; ++i) path.middleRows<3>(3 * i).colwise() = scene.initial_positions.segment<3>(12 * i);
  path.col(1).array() += 0.02;
  scene.handles.path = HandlePath(Eigen::Vector3d(0.0, 0.08, 0.2), path);
  result.motion = Record(scene, {{"k_stretch", 150.0}, {"drag", 0.25}}, 0.0);
  result.options.parameters = {"k_stretch", "k_bend", "drag"};
  return result;
}

// A cloth that slides on a ball, falls on a table, too, and damps itself.
FitCase OnBallAndTable() {
  FitCase result;
  Scene& scene = result.scene.scene;
  scene = SphereScene();
  scene.material.damping = 0.05;
  scene.obstacles[0].contact_distance = 2e-3;
  Shape ball, table;
  ball.kind = Shape::Kind::kSphere;
  ball.point = {0.15, 0.2, -0.12};
  ball.radius = 0.098;
  table.point = {0.0, 0.0, -0.1};
  scene.obstacles[0].shape = ball.Make();
  scene.obstacles.push_back({"table", table.Make(), 0.4, 0.0});
  result.scene.shapes = {ball, table};
  result.motion = Record(scene, {{"mu.ball", 0.35}, {"k_stretch", 150.0}}, 1e-3);
  result.options.parameters = {"mu.ball", "k_stretch"};
  return result;
}

// Default bounds are those of cloth in SI units: these move with the units.
FitOptions WithRelativeBounds(const Scene& scene, FitOptions options) {
  for (const std::string& name : options.parameters) {
    const ParameterId id = ParseParameter(name, scene);
    if (id.kind == ParameterKind::kFriction) continue;
    const double nominal = GetParameter(scene.nominal_parameters(), id);
    options.overrides.lower_bounds[name] = 1e-4 * nominal;
    options.overrides.upper_bounds[name] = 1e4 * nominal;
  }
  return options;
}

FitSummary RunFit(const RecordedMotion& motion, const FitOptions& given) {
  const FitOptions options = WithRelativeBounds(motion.scene, given);
  FitProblem problem({motion}, options);
  FitSummary summary = Fit(options, &problem);
  EXPECT_EQ(summary.status, FitStatus::kConverged) << summary.message;
  EXPECT_TRUE(summary.uncertainty.has_value());
  return summary;
}

void ExpectSame(const FitCase& original, const RecordedMotion& changed_motion, const Units& units) {
  FitProblem problem({original.motion}, original.options);
  const FitSummary one = RunFit(original.motion, original.options), other = RunFit(changed_motion, original.options);
  EXPECT_NEAR(other.cost, one.cost, original.options.function_tolerance * one.cost);
  EXPECT_NEAR(other.error.rmse(), units.length * one.error.rmse(), 1e-9 * units.length * one.error.rmse());
  EXPECT_NEAR(other.error.fit_percent(), one.error.fit_percent(), 1e-7);
  for (int i = 0; i < problem.num_blocks(); ++i) {
    const ParameterBlock& block = problem.blocks()[i];
    SCOPED_TRACE(block.name);
    const double unit = units.Of(ParseParameter(block.name, original.motion.scene.obstacle_names()).kind);
    const double expected = block.ToCoordinate(unit * one.parameters[i].value);
    EXPECT_NEAR(other.coordinates[i], expected, 2.0 * block.Resolution(expected));
    const ParameterUncertainty &a = one.uncertainty->parameters[i], &b = other.uncertainty->parameters[i];
    EXPECT_NEAR(b.std, unit * a.std, 1e-5 * unit * a.std);
    EXPECT_NEAR(b.lower95, unit * a.lower95, 1e-5 * unit * a.lower95);
    EXPECT_NEAR(b.upper95, unit * a.upper95, 1e-5 * unit * a.upper95);
    EXPECT_NEAR(b.visible_change, a.visible_change, 1e-5 * a.visible_change);
    EXPECT_TRUE(b.identifiable);
  }
}

std::vector<FitCase> FitCases(std::uint64_t seed) {
  std::vector<FitCase> cases = {ShakenInGusts(), OnBallAndTable()};
  for (FitCase& fit : cases) {
    fit.options.jacobian = seed % 2 == 0 ? JacobianMethod::kSensitivity : JacobianMethod::kAdjoint;
  }
  return cases;
}

TEST(FitInvarianceTest, RotationAndTranslation) {
  for (const std::uint64_t seed : PropertySeeds(4)) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    RandomNumbers numbers(seed);
    const TurnAndShift move{numbers.Rotation(), numbers.InCube(3)}, rest{numbers.Rotation(), Eigen::Vector3d::Zero()};
    for (const FitCase& fit : FitCases(seed)) {
      RecordedMotion moved = fit.motion;
      moved.scene = Moved(fit.scene, move, rest);
      moved.positions = move.OfPoints(fit.motion.positions);
      ExpectSame(fit, moved, Units());
    }
  }
}

TEST(FitInvarianceTest, UnitsOfLengthMassAndTime) {
  for (const std::uint64_t seed : PropertySeeds(4)) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    RandomNumbers numbers(seed);
    Units units;
    for (double* unit : {&units.length, &units.mass, &units.time}) *unit = numbers.OverOctaves(1e-3, 20);
    for (const FitCase& fit : FitCases(seed)) {
      RecordedMotion rescaled = fit.motion;
      rescaled.scene = Rescaled(fit.scene, units);
      rescaled.positions *= units.length;
      rescaled.times *= units.time;
      rescaled.sigma *= units.length;
      ExpectSame(fit, rescaled, units);
    }
  }
}

TEST(FitInvarianceTest, OrderOfNodesAndFaces) {
  for (const std::uint64_t seed : PropertySeeds(4)) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    for (const FitCase& fit : FitCases(seed)) {
      const std::vector<int> new_index = RandomNumbers(seed).Permutation(fit.motion.scene.mesh.num_nodes());
      RecordedMotion renumbered = fit.motion;
      renumbered.scene = Renumbered(fit.motion.scene, new_index, seed);
      for (auto frame : renumbered.positions.colwise()) frame = Renumbered(Eigen::VectorXd(frame), new_index);
      ExpectSame(fit, renumbered, Units());
    }
  }
}

}  // namespace
}  // namespace clothid::fit_invariance_test
