// Fits of constants of pieces of a cloth.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "costs/prediction/parameter_block.h"
#include "identify/fit/fit.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"
#include "tests/sim/pieces_scene.h"

namespace clothid::piece_fit_test {
namespace {

const std::map<std::string, double> kTruth = {{"k_stretch.a", 80.0}, {"k_stretch.b", 30.0}};

// Held by an edge, at which piece "a" is; it swings down.
Scene PiecesScene() {
  Scene scene = ClothScene(6, 30);
  scene.handles.nodes = {0, 1, 2, 3, 4, 5};
  return InPieces(scene, 1.0, 1.0);
}

RecordedMotion Recording(double noise) {
  MotionOptions options;
  options.true_values = kTruth;
  options.noise = options.sigma = noise;
  return MakeMotion(PiecesScene(), options);
}

FitSummary RunFit(const RecordedMotion& motion, const std::vector<std::string>& names) {
  FitOptions options;
  options.parameters = names;
  FitProblem problem({motion}, options);
  return Fit(options, &problem);
}

TEST(PieceFitTest, RecoversTheConstantOfEveryPiece) {
  const FitSummary fit = RunFit(Recording(0.0), {"k_stretch.a", "k_stretch.b"});
  EXPECT_EQ(fit.status, FitStatus::kConverged) << fit.message;
  for (const FittedParameter& parameter : fit.parameters) {
    EXPECT_NEAR(parameter.value, kTruth.at(parameter.name), 0.01 * parameter.value) << parameter.name;
  }
}

TEST(PieceFitTest, HoldsTheTruthWithinItsIntervals) {
  const FitSummary fit = RunFit(Recording(5e-4), {"k_stretch.a", "k_stretch.b"});
  ASSERT_TRUE(fit.uncertainty.has_value()) << fit.message;
  for (std::size_t i = 0; i < fit.parameters.size(); ++i) {
    const double truth = kTruth.at(fit.parameters[i].name);
    EXPECT_LE(fit.uncertainty->parameters[i].lower95, truth) << fit.parameters[i].name;
    EXPECT_GE(fit.uncertainty->parameters[i].upper95, truth) << fit.parameters[i].name;
    EXPECT_TRUE(fit.uncertainty->parameters[i].identifiable) << fit.parameters[i].name;
  }
}

TEST(PieceFitTest, RefusesTheWholeBesideAPart) {
  const RecordedMotion motion = Recording(0.0);
  ExpectError(
      [&] {
        RunFit(motion, {"k_stretch", "k_stretch.a"});
      },
      ErrorKind::kUsage, {"'k_stretch' sets that of every piece, so 'k_stretch.a' cannot be fitted beside it"});
  ExpectError([&] { RunFit(motion, {"k_stretch.sleeve"}); }, ErrorKind::kUsage,
              {"unknown parameter 'k_stretch.sleeve'", "density.a, density.b"});
}

// Of recordings fitted together one may lack the piece; each has what it names.
TEST(PieceFitTest, RecordingsWithoutThePieceDoNotTellOfIt) {
  MotionOptions options;
  Scene plain = ClothScene(6, 30);
  plain.handles.nodes = {0, 1, 2, 3, 4, 5};
  const RecordedMotion whole = MakeMotion(plain, options), pieces = Recording(0.0);
  FitOptions fit;
  fit.parameters = {"k_stretch.a", "k_stretch.b"};
  fit.each = {"density.a"};
  const FitProblem problem({whole, pieces}, fit);
  ASSERT_EQ(problem.blocks().size(), 3u);
  EXPECT_EQ(problem.blocks()[2].name, "density.a@2");
}

TEST(PieceFitTest, BoundsAndPriorsAreThoseOfThePiece) {
  Scene scene = PiecesScene();
  scene.parameters["k_stretch.b"].lower_bound = 20.0;
  scene.parameters["k_stretch.b"].prior = {35.0, 1.5};
  scene.pieces[1].stretch_stiffness = 44.0;
  ParameterOverrides overrides;
  overrides.upper_bounds["k_stretch.b"] = 200.0;
  const ParameterBlock block = MakeParameterBlock("k_stretch.b", scene, overrides);
  EXPECT_EQ(block.start, 44.0);
  EXPECT_EQ(block.lower_bound, 20.0);
  EXPECT_EQ(block.upper_bound, 200.0);
  EXPECT_EQ(block.prior.center, 35.0);
  EXPECT_EQ(block.scale, ParameterScale::kLog);
  EXPECT_LT(MakeParameterBlock("k_stretch.a", scene, {}).lower_bound, 1.0);
}

}  // namespace
}  // namespace clothid::piece_fit_test
