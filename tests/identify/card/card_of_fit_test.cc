// What the card of a cloth takes from a fit, and how far it says that the cloth was strained and bent.
#include "identify/card/card_of_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "identify/card/card_page.h"
#include "identify/card/seen_ranges.h"
#include "sim/scene/scene_json.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::card_of_fit_test {
namespace {

using Kind = ParameterKind;

// 0.2 m long along z, 0.05 m wide, its warp along z.
Scene Strip(const std::string& materials) {
  return ParseScene(R"({"clothid_scene": 2, "time_step": 0.1, "duration": 1,
      "mesh": {"grid": {"nodes": [3, 5], "size": [0.05, 0.2], "axes": [[1, 0, 0], [0, 0, 1]]}},
      "materials": {)" + materials +
                        "}}",
                    "scene.json", "");
}

constexpr char kYarns[] =
    R"("membrane": "yarn", "k_warp": 300, "k_weft": 200, "k_shear": 100, "warp_direction": [0, 0, 1])";

// The mesh at rest under an affine map of every frame.
Eigen::MatrixXd Mapped(const Scene& scene, const std::vector<Eigen::Matrix3d>& maps) {
  Eigen::MatrixXd positions(3 * scene.mesh.num_nodes(), static_cast<Eigen::Index>(maps.size()));
  for (std::size_t i = 0; i < maps.size(); ++i) {
    positions.col(static_cast<Eigen::Index>(i)) = (maps[i] * scene.mesh.rest_positions).reshaped();
  }
  return positions;
}

FitSummary Fitted(const std::string& name, double value, double lower, double upper) {
  FitSummary summary;
  summary.status = FitStatus::kConverged;
  FittedParameter parameter;
  parameter.name = name;
  parameter.value = value;
  summary.parameters = {parameter};
  summary.uncertainty.emplace();
  ParameterUncertainty uncertainty;
  uncertainty.identifiable = true;
  uncertainty.std = 0.01 * value;
  uncertainty.lower95 = lower;
  uncertainty.upper95 = upper;
  summary.uncertainty->parameters = {uncertainty};
  return summary;
}

RecordedMotion Recorded(const Scene& scene) {
  RecordedMotion motion;
  motion.name = "strip.bin";
  motion.sha256 = "0123";
  motion.scene = scene;
  motion.times = Eigen::Vector2d(0.0, 1.0);
  motion.points.resize(1);
  motion.positions = Eigen::MatrixXd::Zero(3, 2);
  return motion;
}

TEST(SeenRangesTest, StrainsAreThoseAlongTheYarns) {
  const Scene scene = Strip(kYarns);
  const Eigen::MatrixXd positions =
      Mapped(scene, {Eigen::Matrix3d::Identity(), Eigen::Matrix3d(Eigen::Vector3d(0.95, 1.0, 1.2).asDiagonal())});
  const auto ranges = SeenRanges(scene, positions);
  EXPECT_NEAR(ranges.at(Kind::kWarpStiffness).from, 0.0, 1e-6);
  EXPECT_NEAR(ranges.at(Kind::kWarpStiffness).to, 0.2, 1e-6);
  EXPECT_NEAR(ranges.at(Kind::kWeftStiffening).from, -0.05, 1e-6);
  EXPECT_NEAR(ranges.at(Kind::kWeftStiffening).to, 0.0, 1e-6);
  EXPECT_EQ(ranges.at(Kind::kShearStiffness).to, 0.0);
  EXPECT_EQ(ranges.count(Kind::kStretchStiffness), 0u) << "another law";
  EXPECT_EQ(ranges.count(Kind::kBendingStiffness), 0u) << "the scene has no bending";
  const Eigen::VectorXd strains = MeanStrains(scene, positions, Kind::kWarpStiffness);
  EXPECT_NEAR(strains[1], 0.2, 1e-12);
}

TEST(SeenRangesTest, OfAnIsotropicClothItIsTheLargerPrincipalStrain) {
  const Scene scene = Strip(R"("k_stretch": 100)");
  Eigen::Matrix3d shear = Eigen::Matrix3d::Identity();
  shear(0, 2) = 0.5;  // principal stretches s and 1/s, s - 1/s = 0.5
  const auto ranges = SeenRanges(scene, Mapped(scene, {shear}));
  EXPECT_NEAR(ranges.at(Kind::kStretchStiffness).to, 0.25 + std::sqrt(1.0 + 0.0625) - 1.0, 1e-6);
}

TEST(SeenRangesTest, CurvatureIsThatOfACylinder) {
  const Scene scene = Strip(R"("k_stretch": 100, "k_bend": 1e-5)");
  constexpr double kRadius = 0.5;  // m
  Eigen::MatrixXd positions = scene.mesh.rest_positions.reshaped();
  for (Eigen::Index node = 0; node < scene.mesh.num_nodes(); ++node) {
    const double angle = positions(3 * node + 2) / kRadius;
    positions(3 * node + 1) = kRadius * (1.0 - std::cos(angle));
    positions(3 * node + 2) = kRadius * std::sin(angle);
  }
  const auto ranges = SeenRanges(scene, positions);
  EXPECT_NEAR(ranges.at(Kind::kBendingStiffness).to, 1.0 / kRadius, 0.05 / kRadius);
}

TEST(CardOfFitTest, KeepsTheForcesThatItsSimulationsLack) {
  const Scene scene = Strip(kYarns);
  FitChecks checks;
  checks.missing_forces = {{0.08, 0.05, 0.2}, {0.06, 1.0, 0.2}};
  checks.held_bands.emplace();
  const auto card = [&] {
    return CardOfFit(Fitted("k_warp", 310.0, 300.0, 320.0), checks, {Recorded(scene)}, {Eigen::MatrixXd()});
  };
  ASSERT_EQ(card().missing_forces.size(), 2u);
  EXPECT_EQ(card().missing_forces[0].deviation, 0.08);
  EXPECT_EQ(card().missing_forces[0].factor, 1.0);
  checks.held_bands->calibration = BandCalibration{3.0, 0.9};
  EXPECT_NEAR(card().missing_forces[0].deviation, 0.24, 1e-15);
  EXPECT_NEAR(card().missing_forces[1].deviation, 0.18, 1e-15);
  EXPECT_EQ(card().missing_forces[1].time, 1.0);
  EXPECT_EQ(card().missing_forces[1].factor, 3.0);
}

TEST(CardOfFitTest, HoldsConstantsOfTheClothAlone) {
  const Scene scene = Strip(std::string(kYarns) + R"(, "density": 0.25, "drag": 0.1, "damping": 0.01)");
  const FabricCard card =
      CardOfFit(Fitted("k_warp", 310.0, 300.0, 320.0), FitChecks(), {Recorded(scene)}, {Eigen::MatrixXd()});
  EXPECT_EQ(card.membrane, MembraneLaw::kYarn);
  ASSERT_NE(card.Find(Kind::kWarpStiffness), nullptr);
  EXPECT_EQ(card.Find(Kind::kWarpStiffness)->value, 310.0);
  EXPECT_EQ(card.Find(Kind::kWarpStiffness)->upper95, 320.0);
  EXPECT_TRUE(std::isnan(card.Find(Kind::kWarpStiffness)->seen_to)) << "nobody knows the nodes";
  EXPECT_EQ(card.Find(Kind::kWeftStiffness)->known_by, KnownBy::kAssumed);
  EXPECT_EQ(card.Find(Kind::kDensity)->value, 0.25);
  EXPECT_EQ(card.Find(Kind::kDamping)->value, 0.01);
  EXPECT_EQ(card.Find(Kind::kBendingStiffness), nullptr) << "it does not bend";
  EXPECT_EQ(card.Find(Kind::kDrag), nullptr) << "of the air";
  EXPECT_EQ(card.recordings[0].kind, "motion");
  EXPECT_EQ(card.recordings[0].num_nodes, 15);
}

TEST(CardOfFitTest, BendingByEdgesBelongsToTheMesh) {
  const Scene scene = Strip(R"("k_stretch": 100, "bending": "edges", "k_bend": 1e-5)");
  const FabricCard card =
      CardOfFit(Fitted("k_bend", 1e-5, 9e-6, 1.1e-5), FitChecks(), {Recorded(scene)}, {Eigen::MatrixXd()});
  EXPECT_EQ(card.Find(Kind::kBendingStiffness), nullptr);
}

TEST(CardOfFitTest, AFitThatDidNotLookKeepsWhatWasBelieved) {
  Scene scene = Strip(R"("k_stretch": 100, "density": 0.2)");
  scene.parameters["density"].prior = {0.3, 1.1};
  const FabricCard card =
      CardOfFit(Fitted("k_stretch", 110.0, 100.0, 121.0), FitChecks(), {Recorded(scene)}, {Eigen::MatrixXd()});
  const CardConstant* density = card.Find(Kind::kDensity);
  ASSERT_NE(density, nullptr);
  EXPECT_EQ(density->known_by, KnownBy::kBelieved);
  EXPECT_EQ(density->value, 0.3);
  EXPECT_NEAR(density->Prior().spread, 1.1, 1e-12) << "the same prior again";
}

TEST(CardOfFitTest, TakesTheMeanOfRepetitions) {
  FitChecks checks;
  checks.repetitions.emplace();
  PooledParameter pooled;
  pooled.name = "k_stretch";
  pooled.fits = {0, 1, 2};
  pooled.mean = 90.0;
  pooled.lower95 = 80.0;
  pooled.upper95 = 101.0;
  pooled.effects.tau = 0.12;
  checks.repetitions->parameters = {pooled};
  const FabricCard card = CardOfFit(Fitted("k_stretch", 110.0, 100.0, 121.0), checks,
                                    {Recorded(Strip(R"("k_stretch": 100)"))}, {Eigen::MatrixXd()});
  EXPECT_EQ(card.Find(Kind::kStretchStiffness)->value, 90.0);
  EXPECT_EQ(card.Find(Kind::kStretchStiffness)->scatter, 0.12);
}

TEST(CardOfFitTest, FinishedFitsHaveOneCard) {
  Repetitions repetitions;
  PooledParameter pooled;
  pooled.name = "k_stretch";
  pooled.fits = {0, 1};
  pooled.mean = 95.0;
  pooled.lower95 = 85.0;
  pooled.upper95 = 106.0;
  pooled.effects.tau = 0.1;
  repetitions.parameters = {pooled};
  const Scene scene = Strip(R"("k_stretch": 100)");
  const auto card = [&](double value, double stretch) {
    const Eigen::Matrix3d map = Eigen::Vector3d(1.0, 1.0, stretch).asDiagonal();
    return CardOfFit(Fitted("k_stretch", value, 0.9 * value, 1.1 * value), FitChecks(), {Recorded(scene)},
                     {Mapped(scene, {map})});
  };
  const FabricCard both = PooledCard({card(90.0, 1.1), card(100.0, 1.3)}, repetitions);
  const CardConstant* stretch = both.Find(Kind::kStretchStiffness);
  ASSERT_NE(stretch, nullptr);
  EXPECT_EQ(stretch->value, 95.0);
  EXPECT_EQ(stretch->scatter, 0.1);
  EXPECT_NEAR(stretch->seen_from, 0.1, 1e-6);
  EXPECT_NEAR(stretch->seen_to, 0.3, 1e-6);
  EXPECT_EQ(both.recordings.size(), 2u);
}

TEST(CardPageTest, ShowsTheCurveOfATensileTest) {
  const Scene scene = Strip(kYarns);
  RecordedMotion motion = Recorded(scene);
  motion.name = "</script><b>";
  motion.positions.setConstant(std::numeric_limits<double>::quiet_NaN());
  motion.forces.times = motion.times;
  motion.forces.values = Eigen::MatrixXd::Constant(3, 2, std::numeric_limits<double>::quiet_NaN());
  motion.forces.values.row(2) << 0.0, -7.5;
  FitSummary summary = Fitted("k_warp", 310.0, 300.0, 320.0);
  summary.forces = {Eigen::MatrixXd::Constant(3, 2, -7.25)};
  const std::vector<Eigen::MatrixXd> nodes = {
      Mapped(scene, {Eigen::Matrix3d::Identity(), Eigen::Matrix3d(Eigen::Vector3d(1.0, 1.0, 1.25).asDiagonal())})};
  const FabricCard card = CardOfFit(summary, FitChecks(), {motion}, nodes);
  EXPECT_EQ(card.recordings[0].kind, "tensile curve");
  EXPECT_EQ(card.recordings[0].load, 7.5);
  EXPECT_EQ(card.Find(Kind::kWarpStiffness)->seen_to, 0.25);
  const std::string page = CardHtml(card, summary, {motion}, nodes);
  EXPECT_NE(page.find(R"("strain":[0.0,0.25],"measured":[0.0,7.5],"fitted":[7.25,7.25])"), std::string::npos);
  EXPECT_EQ(page.find("</script><b>"), std::string::npos);
  EXPECT_EQ(page.find("://"), std::string::npos) << "nothing is asked for";
  EXPECT_LT(page.size(), 100000u);
}

}  // namespace
}  // namespace clothid::card_of_fit_test
