// A wind that changes over time, fitted with a smoothness that is chosen: what is chosen, what comes out, and what the
// wind is taken to be where no frame tells.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "identify/base/knot_names.h"
#include "identify/run.h"
#include "identify/uncertainty/priors.h"
#include "identify/uncertainty/smoothness.h"
#include "identify/wind/wind_request.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"

namespace clothid::wind_fit_test {
namespace {

// q of `count` knots, a random walk of the standard deviation `spread` per step, seen through a random matrix with
// noise of 1.
struct Walk {
  std::vector<ParameterBlock> blocks;
  Eigen::VectorXd estimate;
  Linearization linearization;
};

Walk MakeWalk(int count, double spread, double smoothness) {
  std::mt19937_64 generator(11);
  std::normal_distribution<double> normal;
  Walk walk;
  Eigen::VectorXd truth(count);
  for (int i = 0; i < count; ++i) {
    ParameterBlock block;
    block.name = "wind.y." + std::to_string(i + 1);
    block.id = {ParameterKind::kWind, 1, i};
    block.is_signed = true;
    block.lower_bound = -100.0;
    block.upper_bound = 100.0;
    if (i > 0) block.linked_to = i - 1;
    block.link_spread = smoothness;
    walk.blocks.push_back(block);
    truth[i] = i == 0 ? 1.0 : truth[i - 1] + spread * normal(generator);
  }
  const Eigen::MatrixXd jacobian = Eigen::MatrixXd::NullaryExpr(60, count, [&] { return 0.5 * normal(generator); });
  const Eigen::VectorXd measured =
      jacobian * truth + Eigen::VectorXd::NullaryExpr(60, [&] { return normal(generator); });
  walk.estimate = Eigen::VectorXd::Constant(count, 0.5);
  const Eigen::VectorXd residuals = jacobian * walk.estimate - measured;
  walk.linearization.jacobian = jacobian;
  walk.linearization.gradient = jacobian.transpose() * residuals;
  walk.linearization.squared_residual = residuals.squaredNorm();
  walk.linearization.num_measurements = 100000;  // so many that s is 1, whatever the fit is
  return walk;
}

// Twice the logarithm of the probability of what was measured, the level of the walk being anything, but for a
// constant.
double Evidence(const Walk& walk, double smoothness) {
  std::vector<ParameterBlock> blocks = walk.blocks;
  for (ParameterBlock& block : blocks) block.link_spread = smoothness;
  const Eigen::MatrixXd& jacobian = walk.linearization.jacobian;
  const Eigen::MatrixXd hessian = jacobian.transpose() * jacobian + PriorHessian(blocks);
  const Eigen::LDLT<Eigen::MatrixXd> factor(hessian);
  const Eigen::VectorXd gradient = walk.linearization.gradient + PriorGradient(blocks, walk.estimate);
  const double cost = walk.linearization.squared_residual + 2.0 * PriorCost(blocks, walk.estimate) -
                      gradient.dot(factor.solve(gradient));
  const double links = static_cast<double>(LinkRows(blocks).rows());
  return -cost - factor.vectorD().array().log().sum() - 2.0 * links * std::log(smoothness);
}

// The smoothness that is chosen, from another.
double Chosen(const Walk& walk, double smoothness) {
  SmoothnessModel model;
  model.curvature = walk.linearization.jacobian.transpose() * walk.linearization.jacobian;
  model.gradient = walk.linearization.gradient;
  model.squared_residual = walk.linearization.squared_residual;
  model.degrees_of_freedom = walk.linearization.num_measurements;
  std::vector<ParameterBlock> blocks = walk.blocks;
  for (ParameterBlock& block : blocks) block.link_spread = 1.0;
  model.roots = {LinkRows(blocks)};
  model.values = {model.roots[0] * walk.estimate};
  return 1.0 / std::sqrt(SmoothnessChooser(model).Follow(Eigen::VectorXd::Constant(1, 1.0 / (smoothness * smoothness)),
                                                         {true}, 500)[0]);
}

TEST(WindFitTest, TheSmoothnessIsWhereTheMarginalLikelihoodIsLargest) {
  for (const double spread : {0.4, 1.0, 3.0}) {
    const Walk walk = MakeWalk(24, spread, 1.0);
    const double chosen = Chosen(walk, 1.0);
    EXPECT_GT(Evidence(walk, chosen), Evidence(walk, 0.97 * chosen)) << spread;
    EXPECT_GT(Evidence(walk, chosen), Evidence(walk, 1.03 * chosen)) << spread;
    EXPECT_LT(std::abs(std::log(chosen / spread)), 0.6) << chosen << " for " << spread;
    EXPECT_NEAR(Chosen(walk, 0.2), chosen, 1e-3 * chosen);
  }
}

// Coordinates that are not believed to be smooth follow: the choice is that of what is left when they are eliminated.
TEST(WindFitTest, TheSmoothnessCountsWithOtherUnknowns) {
  Walk walk = MakeWalk(24, 1.0, 1.0);
  ParameterBlock other = walk.blocks.front();
  other.linked_to = kNoBlock;
  walk.blocks.push_back(other);
  const Eigen::MatrixXd jacobian = walk.linearization.jacobian;
  walk.linearization.jacobian.conservativeResize(Eigen::NoChange, 25);
  walk.linearization.jacobian.col(24) = jacobian.rowwise().sum() + jacobian.col(3);
  walk.linearization.gradient.conservativeResize(25);
  walk.linearization.gradient[24] = walk.linearization.gradient.head(24).sum() + walk.linearization.gradient[3];
  walk.estimate.conservativeResize(25);
  walk.estimate[24] = 0.0;
  walk.linearization.jacobian.row(0).tail(1).array() += 5.0;  // so that something tells it
  walk.linearization.gradient[24] += 5.0;
  const double chosen = Chosen(walk, 1.0);
  EXPECT_GT(Evidence(walk, chosen), Evidence(walk, 0.97 * chosen));
  EXPECT_GT(Evidence(walk, chosen), Evidence(walk, 1.03 * chosen));
}

Scene WindySwing() {
  Scene scene = SwingScene();
  scene.material.drag = 0.0;
  scene.material.normal_drag = 0.4;
  scene.wind.mean = {0.3, 0.5, 0.0};
  return scene;
}

double TrueWind(double time) { return 0.8 + 2.0 * std::sin(25.0 * time); }

// The swing in that wind along y, with noise.
RecordedMotion SwingInWind(double noise) {
  Scene scene = WindySwing();
  constexpr int kKnots = 21;
  scene.wind.mean.y() = 0.0;
  scene.wind.profile.times = Eigen::VectorXd::LinSpaced(kKnots, 0.0, 0.2);
  scene.wind.profile.velocities = Eigen::MatrixXd::Zero(3, kKnots);
  for (int k = 0; k < kKnots; ++k) scene.wind.profile.velocities(1, k) = TrueWind(scene.wind.profile.times[k]);
  RecordedMotion motion = MakeMotion(scene, {{}, noise, 0.0, noise});
  motion.scene = WindySwing();
  return motion;
}

RunOptions Options(const std::string& wind) {
  RunOptions options;
  options.wind = ParseWindRequest(wind);
  options.fit.parameters = {"k_bend"};
  options.check_recordings = false;
  return options;
}

TEST(WindFitTest, FindsAWindThatChanges) {
  RunOptions options = Options("11:y");
  options.targets = {SwingInWind(1e-4)};
  const RunResult result = Identify(options);
  EXPECT_EQ(result.summary.status, FitStatus::kConverged) << result.summary.message;
  ASSERT_TRUE(result.checks.wind.has_value());
  ASSERT_EQ(result.checks.wind->winds.size(), 1u);
  EXPECT_EQ(result.checks.wind->smoothness_source, SmoothnessSource::kChosen);
  EXPECT_NE(result.checks.wind->smoothness, kFirstWindSmoothness);
  const FittedWind& wind = result.checks.wind->winds.front();
  EXPECT_EQ(wind.axis, 1);
  EXPECT_EQ(wind.start, Eigen::VectorXd::Constant(11, 0.5));
  int num_inside = 0;
  for (Eigen::Index k = 0; k < 11; ++k) {
    const double truth = TrueWind(wind.times[k]);
    // The first ones hardly move the cloth before the others do.
    if (k >= 2) {
      EXPECT_NEAR(wind.values[k], truth, 0.5) << k;
    }
    // A knot stands for the wind about it, which bends.
    num_inside += wind.lower95[k] - 0.1 < truth && truth < wind.upper95[k] + 0.1 ? 1 : 0;
  }
  EXPECT_GE(num_inside, 10);
  EXPECT_GE(wind.num_told, 9);
  EXPECT_EQ(result.table.find("wind.y.3"), std::string::npos) << result.table;
  EXPECT_NE(result.table.find("wind            y over 11 knots: "), std::string::npos) << result.table;
}

// Without noise, and hardly smooth: the knots that made the recording.
TEST(WindFitTest, FindsTheKnotsOfEveryRecordingAgain) {
  RunOptions options = Options("3:y");
  for (const double last : {1.2, -0.4}) {
    Scene scene = WindySwing();
    scene.wind.mean.y() = 0.0;
    scene.wind.profile.times = Eigen::Vector3d(0.0, 0.1, 0.2);
    scene.wind.profile.velocities = Eigen::Matrix3d::Zero();
    scene.wind.profile.velocities.row(1) << 0.7, -0.5, last;
    options.targets.push_back(MakeMotion(scene, {{}, 0.0, 0.0, 0.0}));
    options.targets.back().scene = WindySwing();
  }
  options.fit.wind_smoothness = 1e4;
  const RunResult result = Identify(options);
  ASSERT_TRUE(result.checks.wind.has_value());
  EXPECT_EQ(result.checks.wind->smoothness_source, SmoothnessSource::kGiven);
  ASSERT_EQ(result.checks.wind->winds.size(), 2u);
  EXPECT_LT((result.checks.wind->winds[0].values - Eigen::Vector3d(0.7, -0.5, 1.2)).norm(), 1e-4);
  EXPECT_LT((result.checks.wind->winds[1].values - Eigen::Vector3d(0.7, -0.5, -0.4)).norm(), 1e-4);
  EXPECT_EQ(result.summary.parameters.back().name, "wind.y.3@2");
}

// What comes after the last frame is the last wind, and the verdict says so.
TEST(WindFitTest, HoldsTheLastWindWhereNoFrameTells) {
  RunOptions options = Options("11:y");
  options.targets = {SwingInWind(1e-4)};
  options.holdout_frames = FrameRange{15, 21};
  const RunResult result = Identify(options);
  ASSERT_TRUE(result.checks.wind.has_value());
  const FittedWind& wind = result.checks.wind->winds.front();
  for (const int k : {9, 10}) EXPECT_NEAR(wind.values[k], wind.values[8], 1e-6) << k;
  EXPECT_GT(wind.upper95[10] - wind.lower95[10], wind.upper95[4] - wind.lower95[4]);
  EXPECT_LE(wind.num_told, 8);
  std::string lines;
  for (const std::string& line : result.verdict.Lines()) lines += line + "\n";
  EXPECT_NE(lines.find("the recordings do not determine the wind at"), std::string::npos) << lines;
  EXPECT_NE(lines.find(" to wind.y.11"), std::string::npos) << lines;
}

// A cloth that hangs still in a steady wind tells how hard the wind pushes, not how fast it is.
TEST(WindFitTest, NamesDragAgainstTheWholeProfile) {
  Scene scene = SphereScene();
  scene.obstacles.clear();
  scene.material.damping = 1.0;
  scene.material.drag = 0.0;
  scene.material.normal_drag = 0.5;
  scene.wind.mean = {0.0, 0.0, 1.0};
  scene.duration = 20.0;
  {
    Simulator simulator(scene);
    scene.initial_positions = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator).positions(2000);
  }
  scene.duration = 0.1;
  RunOptions options = Options("5:z");
  options.targets = {MakeMotion(scene, {{}, 1e-4, 0.0, 1e-4})};
  options.fit.parameters = {"drag_normal"};
  options.fit.wind_smoothness = 1.0;
  const RunResult result = Identify(options);
  ASSERT_TRUE(result.summary.uncertainty.has_value());
  for (const ParameterUncertainty& parameter : result.summary.uncertainty->parameters) {
    EXPECT_FALSE(parameter.identifiable);
  }
  std::string lines;
  for (const std::string& line : result.verdict.Lines()) lines += line + "\n";
  EXPECT_NE(lines.find("not identifiable: drag_normal times "), std::string::npos) << lines;
  EXPECT_NE(lines.find(" and wind.z.1 to wind.z.5: by its derivative, moved from bound to bound"), std::string::npos)
      << lines;
  EXPECT_EQ(result.exit_code, kExitNotIdentifiable);
}

TEST(WindFitTest, ASceneKeepsItsWindUntilItIsFitted) {
  std::vector<RecordedMotion> motions = {SwingInWind(0.0)};
  Scene& scene = motions.front().scene;
  scene.wind.profile.times = Eigen::Vector2d(0.0, 0.2);
  scene.wind.profile.velocities.resize(3, 2);
  scene.wind.profile.velocities << 0.0, 1.0, 0.0, 2.0, 0.0, 3.0;
  scene.parameters["wind.y"].nominal = -0.7;
  scene.parameters["wind.y.2"].nominal = 4.0;
  const Wind before = scene.nominal_parameters().wind;
  SetWindProfile(ParseWindRequest("5:yz"), &motions);
  const Wind& after = scene.nominal_parameters().wind;
  EXPECT_EQ(after.profile.num_knots(), 5);
  EXPECT_EQ(after.mean, Eigen::Vector3d(0.3, 0.0, 0.0));
  for (const double time : {-1.0, 0.0, 0.07, 0.2, 0.5}) {
    EXPECT_LT((after.At(time, {}) - before.At(time, {})).norm(), 1e-14) << time;
  }
}

TEST(WindRequestTest, IsReadOrRefused) {
  EXPECT_FALSE(ParseWindRequest("").is_given());
  EXPECT_EQ(ParseWindRequest("8").num_knots, 8);
  EXPECT_EQ(ParseWindRequest(" 8 : zx").axes, (std::array<bool, 3>{true, false, true}));
  for (const char* text : {"1", "201", "x", "8:", "8:xx", "8:w", "8:x:y", "-3", "8.5"}) {
    ExpectError([&] { ParseWindRequest(text); }, ErrorKind::kUsage, {"--wind_profile", text, "8:xy"});
  }
  FitOptions options;
  options.parameters = {"drag", "wind.y"};
  EXPECT_NO_THROW(AddKnots(ParseWindRequest("3:xz"), &options));
  EXPECT_EQ(options.each.size(), 6u);
  EXPECT_EQ(options.each.back(), "wind.z.3");
  ExpectError([&] { AddKnots(ParseWindRequest("3"), &options); }, ErrorKind::kUsage, {"--wind_profile", "'wind.y'"});
}

TEST(KnotNamesTest, RunsAreOneName) {
  EXPECT_FALSE(FindKnot("wind.y") || FindKnot("wind.shear.x") || FindKnot("drag@2") || FindKnot("mu.ball"));
  EXPECT_EQ(FindKnot("wind.y.12@3")->part, 11);
  EXPECT_EQ(WithKnotRuns({"mu", "wind.y.2", "wind.y.3", "wind.y.4", "wind.z.5", "wind.z.6@2"}),
            (std::vector<std::string>{"mu", "wind.y.2 to wind.y.4", "wind.z.5", "wind.z.6@2"}));
}

}  // namespace
}  // namespace clothid::wind_fit_test
