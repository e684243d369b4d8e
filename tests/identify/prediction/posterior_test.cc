// What result.json says of a fit, as a distribution, and what another scene can do with it.
#include "identify/prediction/posterior.h"

#include <gtest/gtest.h>

#include <cmath>

#include "datasets/fabric/fabric_card.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"
#include "tests/identify/prediction/result_text.h"
#include "tests/temporary_folder.h"

namespace clothid::posterior_test {
namespace {

using Json = nlohmann::ordered_json;

Json Fit() {
  Json json = ResultText({{"k_stretch", {100.0, 2.0, 3.0}}, {"mu", {0.3, 0.01, 1.0, false}}});
  json["uncertainty"]["correlation"]["k_stretch"]["mu"] = 0.5;
  json["uncertainty"]["correlation"]["mu"]["k_stretch"] = 0.5;
  return json;
}

class PosteriorTest : public testing::Test {
 protected:
  FitPosterior Read(const Json& json) const { return ReadPosterior(folder_.Write("result.json", json.dump(2))); }
  void ExpectRefused(const Json& json, std::initializer_list<const char*> fragments) const {
    ExpectError([&] { Read(json); }, ErrorKind::kBadData, fragments);
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(PosteriorTest, NoiseIsCorrelatedAndTheRestOfAnIntervalIsNot) {
  const FitPosterior posterior = Read(Fit());
  ASSERT_EQ(posterior.parameters.size(), 2u);
  EXPECT_EQ(posterior.parameters[0].name, "k_stretch");
  const Eigen::MatrixXd& covariance = posterior.covariance;
  EXPECT_NEAR(covariance(0, 0), std::pow(3.0 * 0.02, 2), 1e-12);
  EXPECT_NEAR(covariance(1, 1), 1e-4, 1e-12);
  EXPECT_NEAR(covariance(0, 1), 0.5 * 0.02 * 0.01, 1e-12) << "of the noise alone";
}

TEST_F(PosteriorTest, WhatHasNoIntervalIsHeld) {
  Json json = Fit();
  json["parameters"]["mu"]["lower95"] = nullptr;
  json["parameters"]["mu"]["std"] = nullptr;
  const FitPosterior posterior = Read(json);
  ASSERT_EQ(posterior.parameters.size(), 1u);
  EXPECT_EQ(posterior.held.at("mu"), 0.3);
}

// mu at its lower bound; from one to the other it changes the prediction by so many standard deviations.
Json FitAtABound(double visible_change) {
  Json json = Fit();
  json["parameters"]["mu"]["value"] = 0.0;
  for (const char* key : {"std", "lower95", "upper95"}) json["parameters"]["mu"][key] = nullptr;
  json["parameters"]["mu"]["frozen"] = false;
  json["parameters"]["mu"]["at_bound"] = true;
  json["uncertainty"]["residual_scale"] = 1.0;
  json["uncertainty"]["visible_change"] = {{"k_stretch", 300.0}, {"mu", visible_change}};
  json["uncertainty"]["hidden_directions"] = Json::array();
  return json;
}

TEST_F(PosteriorTest, AParameterAtItsBoundIsDrawnFromThereOnByItself) {
  const FitPosterior posterior = Read(FitAtABound(20.0));
  ASSERT_EQ(posterior.parameters.size(), 2u);
  EXPECT_TRUE(posterior.held.empty());
  EXPECT_EQ(posterior.covariance(0, 1), 0.0) << "of noise that is told for the others alone";
  const Eigen::ArrayXXd draws = DrawParameters(posterior, 4000, 1);
  EXPECT_GE(draws.row(1).minCoeff(), 0.0);
  EXPECT_NEAR(draws.row(1).square().mean(), 0.1 * 0.1, 0.1 * 0.01);
  EXPECT_NEAR((draws.row(0).log() - std::log(100.0)).square().mean(), std::pow(0.06, 2), 0.1 * std::pow(0.06, 2));
  const double product =
      ((draws.row(0).log() - std::log(100.0)) / 0.06 * (draws.row(1) - draws.row(1).mean()) / 0.06).mean();
  EXPECT_NEAR(product, 0.0, 0.05) << "uncorrelated";
}

TEST_F(PosteriorTest, AHiddenParameterIsDrawnFromBoundToBoundUnlessItWasFrozen) {
  Json json = FitAtABound(0.1);
  EXPECT_EQ(Read(json).held.at("mu"), 0.0) << "hidden, but by nobody knows what";
  json["uncertainty"]["hidden_directions"] = {{{"coordinates", {{"k_stretch", 0.0}, {"mu", 1.0}}}}};
  const FitPosterior posterior = Read(json);
  ASSERT_EQ(posterior.parameters.size(), 2u);
  const Eigen::ArrayXXd draws = DrawParameters(posterior, 4000, 1);
  EXPECT_NEAR(draws.row(1).mean(), 1.0, 0.05);
  EXPECT_NEAR((draws.row(1) - 1.0).square().mean(), 4.0 / 12.0, 0.03);
  json["parameters"]["mu"]["frozen"] = true;
  EXPECT_EQ(Read(json).held.at("mu"), 0.0);
}

// What a fit hands on to the bands of what was held out is what its result.json says.
TEST_F(PosteriorTest, OfAFitThatHasJustEndedTheSameIsDrawn) {
  FitSummary summary;
  FittedParameter stretch, mu;
  stretch.name = "k_stretch";
  stretch.scale = ParameterScale::kLog;
  stretch.value = 100.0;
  stretch.lower_bound = 1e-4;
  stretch.upper_bound = 1e8;
  mu.name = "mu";
  mu.lower_bound = 0.0;
  mu.upper_bound = 2.0;
  mu.at_bound = true;
  summary.parameters = {stretch, mu};
  Uncertainty uncertainty;
  uncertainty.parameters.resize(2);
  uncertainty.parameters[0].std = 2.0;
  uncertainty.parameters[0].lower95 = 100.0 * std::exp(-0.06 * kNormal95);
  uncertainty.parameters[0].upper95 = 100.0 * std::exp(0.06 * kNormal95);
  uncertainty.parameters[1].at_bound = true;
  uncertainty.parameters[1].visible_change = 20.0;
  uncertainty.residual_scale = 1.0;
  uncertainty.correlation = Eigen::MatrixXd::Identity(2, 2);
  summary.uncertainty = uncertainty;
  EXPECT_EQ(DrawParameters(PosteriorOf(summary, {}), 20, 1), DrawParameters(Read(FitAtABound(20.0)), 20, 1));
  uncertainty.parameters[1].visible_change = 0.1;
  summary.uncertainty = uncertainty;
  EXPECT_EQ(PosteriorOf(summary, {}).held.at("mu"), 0.0);
  uncertainty.parameters[1].visible_change = 20.0;
  uncertainty.parameters[0].std = std::nan("");
  summary.uncertainty = uncertainty;
  EXPECT_TRUE(PosteriorOf(summary, {}).parameters.empty()) << "a fit that tells no interval predicts nothing";
}

TEST_F(PosteriorTest, WhatBelongsToARecordingIsLeftOut) {
  Json json = Fit();
  for (const char* name : {"drag@2", "shift.x", "wind.x.3"}) json["parameters"][name] = json["parameters"]["mu"];
  const FitPosterior posterior = Read(json);
  EXPECT_EQ(posterior.parameters.size(), 2u);
  EXPECT_EQ(posterior.left_out, (std::vector<std::string>{"drag@2", "shift.x", "wind.x.3"}));
}

TEST_F(PosteriorTest, StartsThatWereFittedAreOffByWhatTheyMovedAndAreNotSureOf) {
  Json json = Fit();
  EXPECT_FALSE(Read(json).start.has_value());
  const auto start = [](double moved, double std, double handles, double interval) {
    return Json{{"start",
                 {{"moved_m", moved},
                  {"std_m", std},
                  {"handles_moved_m", handles},
                  {"handle_std_m", 0.0},
                  {"handle_interval_s", interval},
                  {"speed_change_m_s", 0.03},
                  {"velocity_std_m_s", 0.04}}}};
  };
  json["recordings"] = Json::array({start(3e-3, 4e-3, 1e-3, 0.2), Json::object(), start(0.0, 1e-3, 1e-3, 0.0)});
  const FitPosterior posterior = Read(json);
  ASSERT_TRUE(posterior.start.has_value());
  EXPECT_NEAR(posterior.start->position, std::sqrt((25e-6 + 1e-6) / 2.0), 1e-12);
  EXPECT_NEAR(posterior.start->velocity, 0.05, 1e-12);
  EXPECT_NEAR(posterior.start->handles, 1e-3, 1e-12);
  EXPECT_EQ(posterior.start->handle_interval, 0.2);
}

TEST_F(PosteriorTest, ACalibrationMultipliesTheForce) {
  Json json = Fit();
  json["missing_force"] = ForcesText({{0.05, 0.03, 0.1}});
  json["holdout"] = {{"bands", {{"inside", 0.5}, {"calibration", {{"force_factor", 2.5}, {"inside", 0.9}}}}}};
  const FitPosterior posterior = Read(json);
  EXPECT_EQ(posterior.force_factor, 2.5);
  EXPECT_NEAR(posterior.forces.at(0).size, 0.125, 1e-15);
  json["holdout"] = nullptr;
  EXPECT_NEAR(Read(json).forces.at(0).size, 0.05, 1e-15);
}

TEST_F(PosteriorTest, DrawsHaveTheCovarianceAndDependOnSeedAndNumberAlone) {
  const FitPosterior posterior = Read(Fit());
  const Eigen::MatrixXd draws = DrawParameters(posterior, 4000, 1);
  EXPECT_EQ(DrawParameters(posterior, 50, 1), draws.leftCols(50));
  EXPECT_NE(DrawParameters(posterior, 50, 2), draws.leftCols(50));
  Eigen::MatrixXd q = draws;
  q.row(0) = draws.row(0).array().log();
  q.colwise() -= q.rowwise().mean().eval();
  const Eigen::MatrixXd covariance = q * q.transpose() / 3999.0;
  EXPECT_NEAR(covariance(0, 0), posterior.covariance(0, 0), 0.1 * posterior.covariance(0, 0));
  EXPECT_NEAR(covariance(1, 1), posterior.covariance(1, 1), 0.1 * posterior.covariance(1, 1));
  EXPECT_NEAR(covariance(0, 1), posterior.covariance(0, 1), 4e-5);
}

TEST_F(PosteriorTest, DrawsStayWithinBounds) {
  const FitPosterior posterior = Read(ResultText({{"mu", {0.01, 0.05, 1.0, false}}}));
  const Eigen::MatrixXd draws = DrawParameters(posterior, 200, 1);
  EXPECT_EQ(draws.minCoeff(), 0.0);
}

TEST_F(PosteriorTest, RefusesResultsWithoutIntervals) {
  Json json = Fit();
  json["schema"] = "clothid.plan/1";
  ExpectRefused(json, {"result.json:", "key 'schema'", "expected \"clothid.result/1\""});
  json = Fit();
  json["status"] = "interrupted";
  ExpectRefused(json, {"key 'status'", "expected \"converged\"", "got \"interrupted\""});
  json = Fit();
  json["uncertainty"] = nullptr;
  ExpectRefused(json, {"key 'uncertainty'", "with intervals"});
  json = Fit();
  json["fields"] = Json::object();
  ExpectRefused(json, {"key 'fields'", "without fields"});
  json = Fit();
  json["uncertainty"]["correlation"].erase("mu");
  ExpectRefused(json, {"mu", "expected an object"});
  json = ResultText({{"mu", {0.3, 0.01, 1.0, false}}});
  json["parameters"]["mu"]["std"] = nullptr;
  ExpectRefused(json, {"key 'parameters'", "with an interval"});
  json = FitAtABound(20.0);
  json["parameters"].erase("k_stretch");
  ExpectRefused(json, {"key 'parameters'", "with an interval"});
}

TEST_F(PosteriorTest, RefusesScenesOfAnotherCloth) {
  const auto refuse = [&](const Json& json, const Scene& scene, std::initializer_list<const char*> fragments) {
    FitPosterior posterior = Read(json);
    ExpectError([&] { FitToScene(scene, "other.json", &posterior); }, ErrorKind::kBadData, fragments);
  };
  refuse(ResultText({{"k_warp", {100.0, 2.0}}}), SwingScene(), {"key 'parameters.k_warp'", "other.json has"});
  refuse(ResultText({{"mu.table", {0.3, 0.01, 1.0, false}}}), SphereScene(), {"key 'parameters.mu.table'"});
  Json json = Fit();
  json["cloth"]["membrane"] = "yarn";
  refuse(json, SwingScene(), {"key 'parameters.k_stretch'", "membrane \"yarn\"", "expected \"arap\""});
  json = ResultText({{"k_bend", {1e-4, 1e-5}}});
  json["cloth"]["bending"] = "edges";
  refuse(json, SwingScene(), {"key 'parameters.k_bend'", "by \"edges\"", "expected \"patches\""});
}

TEST_F(PosteriorTest, FrictionSaysNothingWhereNothingIsTouched) {
  FitPosterior posterior = Read(Fit());
  FitToScene(SphereScene(), "other.json", &posterior);
  EXPECT_EQ(posterior.parameters.size(), 2u);
  FitToScene(SwingScene(), "other.json", &posterior);
  ASSERT_EQ(posterior.parameters.size(), 1u);
  EXPECT_EQ(posterior.left_out, std::vector<std::string>{"mu"});
  ASSERT_EQ(posterior.covariance.rows(), 1);
  EXPECT_NEAR(posterior.covariance(0, 0), std::pow(0.06, 2), 1e-12);
}

TEST_F(PosteriorTest, ForcesThatLastAreRead) {
  Json json = Fit();
  EXPECT_TRUE(Read(json).forces.empty());
  json["missing_force"] = ForcesText({{0.1, 0.05, 0.2}, {0.03, 1.0, 0.2}});
  const FitPosterior posterior = Read(json);
  ASSERT_EQ(posterior.forces.size(), 2u);
  EXPECT_EQ(posterior.forces[0].size, 0.1);
  EXPECT_EQ(posterior.forces[1].time, 1.0);
  EXPECT_EQ(posterior.forces[1].length, 0.2);
  json["missing_force"] = ForcesText({{0.0, 0.05, 0.2}});
  ExpectError([&] { Read(json); }, ErrorKind::kBadData, {"deviation_N_m2", "number > 0"});
}

// Of a card the constants that it tells, with the scatter between specimens, and all that its simulations lack.
TEST_F(PosteriorTest, TheCardOfAClothIsRead) {
  FabricCard card;
  card.program = "a test";
  CardConstant stretch;
  stretch.kind = ParameterKind::kStretchStiffness;
  stretch.value = 100.0;
  stretch.known_by = KnownBy::kFitted;
  stretch.lower95 = 100.0 * std::exp(-0.05 * 1.959963984540054);
  stretch.upper95 = 100.0 * std::exp(0.05 * 1.959963984540054);
  stretch.scatter = 0.12;
  CardConstant density;
  density.kind = ParameterKind::kDensity;
  density.value = 0.2;
  card.constants = {density, stretch};
  card.missing_forces = {{0.1, 0.05, 0.2, 2.0}, {0.3, 1.0, 0.2, 2.0}};
  FitPosterior posterior = ParsePosterior(FabricCardJson(card), "fabric.json");
  ASSERT_EQ(posterior.parameters.size(), 1u) << "the density is assumed";
  EXPECT_EQ(posterior.parameters[0].name, "k_stretch");
  EXPECT_NEAR(posterior.covariance(0, 0), std::pow(0.13, 2), 1e-6);
  ASSERT_EQ(posterior.forces.size(), 2u);
  EXPECT_EQ(posterior.forces[1].size, 0.3) << "with the factor of its calibration";
  EXPECT_EQ(posterior.force_factor, 2.0);
  EXPECT_FALSE(posterior.start.has_value());
  FitPosterior of_yarns = posterior;
  of_yarns.membrane = "yarn";
  ExpectError([&] { FitToScene(SwingScene(), "other.json", &of_yarns); }, ErrorKind::kBadData,
              {"fabric.json: key 'constants.k_stretch': is of the membrane \"yarn\""});
  FitToScene(SwingScene(), "other.json", &posterior);
  const Eigen::MatrixXd values = DrawParameters(posterior, 400, 1);
  EXPECT_NEAR(values.array().log().mean(), std::log(100.0), 0.03);
  card.constants[1].known_by = KnownBy::kAssumed;
  card.constants[1].lower95 = card.constants[1].upper95 = std::nan("");
  ExpectError([&] { ParsePosterior(FabricCardJson(card), "fabric.json"); }, ErrorKind::kBadData,
              {"fabric.json", "key 'constants'", "that a fit has told"});
}

}  // namespace
}  // namespace clothid::posterior_test
