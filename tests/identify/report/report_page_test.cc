// report.html: complete, one file, small, nothing asked of any server, names shown and never run.
#include "identify/report/report_page.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <memory>
#include <random>
#include <regex>

#include "identify/page/page_template.h"
#include "identify/report/cloud_points.h"
#include "identify/report/node_prediction.h"
#include "identify/report/report_replay.h"
#include "identify/report/vendor/plotly.h"
#include "identify/result/result_json.h"
#include "sim/obstacle/box.h"
#include "sim/obstacle/round_shapes.h"
#include "sim/obstacle/triangulated_surface.h"
#include "tests/costs/synthetic_clouds.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/identify/report/packed_page.h"
#include "tests/sim/scene/triangle_meshes.h"

namespace clothid::report_page_test {
namespace {

using Json = nlohmann::ordered_json;

constexpr char kHostileName[] = "</script><img src=x onerror=\"alert(1)\">";

SceneObstacle MakeObstacle(const std::string& name, std::shared_ptr<const Obstacle> shape) {
  SceneObstacle obstacle;
  obstacle.name = name;
  obstacle.shape = std::move(shape);
  return obstacle;
}

// A shape of the user's own.
class Slab : public Obstacle {
 public:
  SurfacePoint Closest(const Eigen::Vector3d& position) const override {
    SurfacePoint point;
    point.gap = position.z() + 5.0;
    return point;
  }
};

std::vector<RecordedMotion> TwoMotions() {
  MotionOptions options;
  options.true_values = {{"k_stretch", 150.0}};
  options.noise = 1e-3;
  std::vector<RecordedMotion> motions = {MakeMotion(SwingScene(), options), MakeMotion(SphereScene(), options)};
  motions[1].name = kHostileName;
  motions[1].positions.block<3, 1>(3 * 7, 3).setConstant(std::nan(""));
  return motions;
}

FitSummary RunFit(const std::vector<RecordedMotion>& motions, int num_threads = 1) {
  FitOptions options;
  options.parameters = {"k_stretch"};
  options.num_threads = num_threads;
  FitProblem problem(motions, options);
  return Fit(options, &problem);
}

// The page without the library and its licences, whose own texts mention addresses.
std::string OwnText(std::string html) {
  for (const std::string_view foreign : {PlotlyLibrary(), PlotlyLicences()}) {
    const std::size_t start = html.find(foreign);
    EXPECT_NE(start, std::string::npos);
    EXPECT_EQ(foreign.find("</script"), std::string::npos);
    html.erase(start, foreign.size());
  }
  return html;
}

// A recording without a simulation: waves and noise.
RecordedMotion WavingMotion(int nodes_per_side, int num_frames, double noise) {
  RecordedMotion motion;
  motion.name = "waves";
  motion.scene = ClothScene(nodes_per_side, num_frames);
  motion.times = Eigen::VectorXd::LinSpaced(num_frames, 0.0, 0.01 * (num_frames - 1));
  const int num_nodes = motion.scene.mesh.num_nodes();
  motion.positions.resize(3 * num_nodes, num_frames);
  std::mt19937_64 generator(3);
  std::normal_distribution<double> normal(0.0, noise);
  for (int node = 0; node < num_nodes; ++node) {
    ObservedPoint point;
    point.nodes[0] = node;
    motion.points.push_back(point);
    for (int frame = 0; frame < num_frames; ++frame) {
      Eigen::Vector3d position = motion.scene.mesh.rest_positions.col(node);
      position.z() += 0.1 * std::sin(0.05 * frame + 20.0 * position.x());
      for (double& coordinate : position) coordinate += normal(generator);
      motion.positions.block<3, 1>(3 * node, frame) = position;
    }
  }
  return motion;
}

// What a fit of that recording might say.
FitSummary WavingFit(const RecordedMotion& motion) {
  FitSummary summary;
  summary.status = FitStatus::kConverged;
  FittedParameter parameter;
  parameter.name = "mu";
  summary.parameters = {parameter};
  summary.predicted = {
      WavingMotion(static_cast<int>(std::lround(std::sqrt(motion.num_points()))), motion.num_frames(), 0.0).positions};
  summary.start_predicted = summary.predicted;
  return summary;
}

int NumCounted(const Json& histogram) {
  int total = histogram["beyond"];
  for (const Json& axis : histogram["axes"]) {
    for (const int count : axis["counts"]) total += count;
  }
  return total;
}

TEST(ReportPageTest, HoldsWhatTheFitFound) {
  const std::vector<RecordedMotion> motions = TwoMotions();
  const FitSummary summary = RunFit(motions);
  FitChecks checks;
  Profile profile;
  profile.parameter = "k_stretch";
  profile.points = {{140.0, 1.5, summary.values()}, {150.0, 0.0, summary.values()}};
  profile.lower95 = 138.0;
  checks.profiles = {profile};
  checks.flags = "--target a.bin";
  const Json data = PageData(ReportHtml(summary, checks, motions));
  EXPECT_EQ(data["result"], Json::parse(ResultJson(summary, checks, motions)));
  EXPECT_EQ(data["start_rmse_m"], summary.start_error.rmse());
  EXPECT_EQ(data["convergence"]["cost"].size(), summary.iterations.size());
  EXPECT_EQ(data["convergence"]["values"]["k_stretch"].size(), summary.iterations.size());
  EXPECT_EQ(data["profiles"][0]["rise"], Json({1.5, 0.0}));
  EXPECT_TRUE(data["profiles"][0]["upper95"].is_null());
  EXPECT_FALSE(data["limits"].empty());
  ASSERT_EQ(data["recordings"].size(), 2u);
  const Json& second = data["recordings"][1];
  EXPECT_EQ(second["name"], kHostileName);
  EXPECT_EQ(second["per_frame"]["rmse"].size(), 21u);
  EXPECT_GT(second["per_frame"]["start_rmse"][20], second["per_frame"]["rmse"][20]);
  EXPECT_EQ(NumCounted(second["histogram"]), Observation(motions[1]).num_residuals());
  EXPECT_EQ(second["histogram"]["leaves_out_start"], false);
}

TEST(ReportPageTest, HoldsTheMemoriesAndTheForceThatIsMissing) {
  const std::vector<RecordedMotion> motions = TwoMotions();
  FitSummary summary = RunFit(motions);
  MemoryTrial trial;
  trial.memory = 0.02;
  trial.coordinates = Eigen::VectorXd::Constant(1, std::log(140.0));
  trial.values = Eigen::VectorXd::Constant(1, 140.0);
  trial.std = Eigen::VectorXd::Constant(1, 0.1);
  trial.lower95 = Eigen::VectorXd::Constant(1, 115.0);
  trial.upper95 = Eigen::VectorXd::Constant(1, 170.0);
  summary.memory_trials = {trial};
  FitChecks checks;
  checks.corrections.resize(1);  // of the first recording
  Eigen::MatrixXd& forces = checks.corrections[0].missing_force.forces;
  forces = Eigen::MatrixXd::Zero(motions[0].positions.rows(), motions[0].num_frames());
  forces.row(3 * 7 + 2).setConstant(-0.5);                                                  // lasts
  for (Eigen::Index i = 0; i < forces.cols(); ++i) forces(0, i) = i % 2 == 0 ? 1.0 : -1.0;  // is noise
  const Json data = PageData(ReportHtml(summary, checks, motions));
  const Json& told = data["result"]["assimilation"]["trials"][0];
  EXPECT_EQ(told["lower95"]["k_stretch"], 115.0);
  EXPECT_EQ(told["upper95"]["k_stretch"], 170.0);
  const Json& replay = data["recordings"][0]["replay"];
  EXPECT_NEAR(replay["largest_force"], 0.5, 1e-12) << "noise is averaged";
  EXPECT_TRUE(replay.contains("missing_force"));
  EXPECT_FALSE(data["recordings"][1]["replay"].contains("missing_force"));
}

// Where a simulation starts from the first frame, its residuals say nothing.
TEST(ReportPageTest, HistogramsAreWithoutTheStart) {
  std::vector<RecordedMotion> motions = TwoMotions();
  motions[1].start_source = StartSource::kFirstFrame;
  const FitSummary summary = RunFit(motions);
  const Json histogram = PageData(ReportHtml(summary, FitChecks(), motions))["recordings"][1]["histogram"];
  const Observation observation(motions[1]);
  EXPECT_EQ(NumCounted(histogram), observation.num_residuals() - observation.first_row(1));
  EXPECT_EQ(histogram["leaves_out_start"], true);
}

TEST(ReportPageTest, ReplayHasRecordedAndPredictedPositions) {
  const std::vector<RecordedMotion> motions = TwoMotions();
  const FitSummary summary = RunFit(motions);
  const Json replay = PageData(ReportHtml(summary, FitChecks(), motions))["recordings"][1]["replay"];
  EXPECT_EQ(replay["every"], 1);
  EXPECT_EQ(replay["points_are_nodes"], true);
  EXPECT_FALSE(replay.contains("nodes"));
  const auto recorded = UnpackPositions(replay["recorded"], 75), predicted = UnpackPositions(replay["predicted"], 75);
  ASSERT_EQ(recorded.size(), 21u);
  const double step = replay["step"];
  EXPECT_LT(step, 2e-5);
  for (int frame = 0; frame < 21; ++frame) {
    for (int row = 0; row < 75; ++row) {
      const double origin = replay["origin"][row % 3];
      EXPECT_NEAR(origin + step * predicted[frame][row], summary.predicted[1](row, frame), 0.51 * step);
      if (std::isnan(motions[1].positions(row, frame))) {
        EXPECT_EQ(recorded[frame][row], 65535);
      } else {
        EXPECT_NEAR(origin + step * recorded[frame][row], motions[1].positions(row, frame), 0.51 * step);
      }
    }
  }
  // Errors to within the steps of their logarithm.
  const std::vector<unsigned char> errors = Unpack(replay["errors"]);
  ASSERT_EQ(errors.size(), 21u * 25u);
  EXPECT_EQ(errors[20 * 25], 255) << "a handle";
  EXPECT_EQ(errors[3 * 25 + 7], 255) << "not seen";
  const double error = (summary.predicted[1].col(20) - motions[1].positions.col(20)).segment<3>(3 * 24).norm();
  const double shown =
      replay["largest_error"].get<double>() * std::pow(10.0, -6.0 * (1.0 - errors[20 * 25 + 24] / 254.0));
  EXPECT_NEAR(shown / error, 1.0, 0.06);
}

TEST(ReportPageTest, ReplayHasEveryKindOfObstacle) {
  RecordedMotion motion = WavingMotion(5, 3, 0.0);
  const TriangleMesh cube = CubeMesh(1.0);
  motion.scene.obstacles = {
      MakeObstacle("floor", std::make_shared<Plane>(Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(0, 0, 2))),
      MakeObstacle("ball", std::make_shared<Sphere>(Eigen::Vector3d(1, 2, 3), 0.5)),
      MakeObstacle("rod", std::make_shared<Capsule>(Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0, 3, 4), 0.1)),
      MakeObstacle("cube", std::make_shared<TriangulatedSurface>(cube.vertices, cube.faces)),
      MakeObstacle("box", std::make_shared<Box>(Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(4, 5, 6),
                                                Eigen::Quaterniond(1, 1, 1, 1), 0.5)),
      MakeObstacle("tin", std::make_shared<Cylinder>(Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0, 0, 2), 0.5)),
      MakeObstacle("ring", std::make_shared<Torus>(Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(0, 2, 0), 0.5, 0.25)),
      MakeObstacle("bowl", std::make_shared<Bowl>(Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(0, 2, 0), 0.5, 1.5, 0.25)),
      MakeObstacle("slab", std::make_shared<Slab>())};
  const Eigen::MatrixXd errors = Eigen::MatrixXd::Zero(25, 3);
  const Json replay = ReplayJson({&motion, &motion.positions, nullptr, &errors}, 1000000);
  const Json& obstacles = replay["obstacles"];
  ASSERT_EQ(obstacles.size(), 8u);
  EXPECT_EQ(obstacles[0]["normal"], Json({0.0, 0.0, 1.0}));
  EXPECT_EQ(obstacles[1]["radius"], 0.5);
  EXPECT_EQ(obstacles[2]["to"], Json({0.0, 3.0, 4.0}));
  EXPECT_EQ(Unpack(obstacles[3]["vertices"]).size(), 12u * cube.vertices.cols());
  EXPECT_EQ(Unpack(obstacles[3]["faces"]).size(), 12u * cube.faces.cols());
  EXPECT_EQ(obstacles[4]["axes"], (Json{{0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}}));
  EXPECT_EQ(obstacles[4]["size"], Json({4.0, 5.0, 6.0}));
  EXPECT_EQ(obstacles[4]["radius"], 0.5);
  EXPECT_EQ(obstacles[5]["to"], Json({0.0, 0.0, 2.0}));
  EXPECT_EQ(obstacles[6]["tube_radius"], 0.25);
  EXPECT_EQ(obstacles[7]["axis"], Json({0.0, 1.0, 0.0}));
  EXPECT_EQ(obstacles[7]["angle"], 1.5);
  EXPECT_EQ(obstacles[7]["thickness"], 0.25);
  ASSERT_EQ(replay["notes"].size(), 1u);
  EXPECT_NE(replay["notes"][0].get<std::string>().find("slab"), std::string::npos);
}

TEST(ReportPageTest, ReplayHasThePosesOfObstaclesThatMove) {
  RecordedMotion motion = WavingMotion(5, 3, 0.0);
  motion.scene.obstacles = {MakeObstacle("still", std::make_shared<Sphere>(Eigen::Vector3d(1, 2, 3), 0.5)),
                            MakeObstacle("bar", std::make_shared<Sphere>(Eigen::Vector3d(0, 0, 0), 0.5))};
  motion.scene.obstacles[1].path = std::make_shared<RigidPath>(
      Eigen::Vector2d(0.0, 1.0), Eigen::Matrix3Xd((Eigen::Matrix<double, 3, 2>() << 0, 1, 0, 2, 0, 4).finished()),
      Eigen::Matrix4Xd(Eigen::Vector4d::UnitW().replicate(1, 2)));
  motion.times = Eigen::Vector3d(0.0, 0.5, 1.0);
  const Json replay = ReplayJson({&motion, &motion.positions, nullptr, nullptr}, 1000000);
  EXPECT_EQ(replay["poses"], (Json{{"bar",
                                    {{0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0},
                                     {0.5, 1.0, 2.0, 0.0, 0.0, 0.0, 1.0},
                                     {1.0, 2.0, 4.0, 0.0, 0.0, 0.0, 1.0}}}}));
}

TEST(ReportPageTest, MarkersComeWithTheWholeCloth) {
  RecordedMotion motion = TwoMotions()[0];
  motion.points.erase(motion.points.begin(), motion.points.begin() + 5);
  motion.points.resize(6);
  motion.positions = Eigen::MatrixXd(motion.positions.middleRows(15, 18));
  FitOptions options;
  options.parameters = {"k_stretch"};
  FitProblem problem({motion}, options);
  const FitSummary summary = Fit(options, &problem);
  FitChecks checks;
  checks.predicted_nodes = PredictNodes({motion}, problem, summary);
  ASSERT_EQ(checks.predicted_nodes[0].rows(), 75);
  EXPECT_LT((checks.predicted_nodes[0].middleRows(15, 18) - summary.predicted[0]).cwiseAbs().maxCoeff(), 1e-6);
  const Json replay = PageData(ReportHtml(summary, checks, {motion}))["recordings"][0]["replay"];
  EXPECT_EQ(replay["points_are_nodes"], false);
  EXPECT_EQ(UnpackPositions(replay["nodes"], 75).size(), 21u);
  EXPECT_EQ(UnpackPositions(replay["recorded"], 18).size(), 21u);
  // Without them it shows what it has.
  EXPECT_FALSE(PageData(ReportHtml(summary, FitChecks(), {motion}))["recordings"][0]["replay"].contains("nodes"));
}

TEST(ReportPageTest, ThousandNodesOverTwoHundredFramesStayBelowFiveMegabytes) {
  const RecordedMotion motion = WavingMotion(32, 200, 2e-3);
  const std::string html = ReportHtml(WavingFit(motion), FitChecks(), {motion});
  EXPECT_LT(html.size(), kMaxReportBytes);
  EXPECT_EQ(PageData(html)["recordings"][0]["replay"]["every"], 1) << "nothing is left out";
  RecordProperty("bytes", static_cast<int>(html.size()));
}

TEST(ReportPageTest, ALongRecordingIsThinned) {
  const RecordedMotion motion = WavingMotion(6, 400, 2e-3);
  const Eigen::MatrixXd errors = Eigen::MatrixXd::Constant(36, 400, 1e-3);
  const ReplaySource source = {&motion, &motion.positions, nullptr, &errors};
  const std::size_t whole = ReplayJson(source, 1000000).dump().size();
  const Json thinned = ReplayJson(source, whole / 3);
  EXPECT_LE(thinned.dump().size(), whole / 3);
  const int every = thinned["every"];
  EXPECT_GT(every, 1);
  EXPECT_LT(every, 10);
  EXPECT_EQ(thinned["times"][1], motion.times[every]);
  EXPECT_EQ(thinned["times"].size(), UnpackPositions(thinned["recorded"], 108).size());
  for (const std::size_t none : {std::size_t{0}, std::size_t{100}, std::size_t{1500}}) {
    const Json left_out = ReplayJson(source, none);
    EXPECT_EQ(left_out.size(), 1u);
    EXPECT_NE(left_out["left_out"].get<std::string>().find("too large"), std::string::npos);
  }
}

// A point far off would make all others coarse.
TEST(ReportPageTest, APointAstrayIsLeftOutOfTheReplay) {
  RecordedMotion motion = WavingMotion(5, 10, 1e-3);
  const Eigen::MatrixXd predicted = motion.positions, errors = Eigen::MatrixXd::Zero(25, 10);
  motion.positions(3 * 4, 2) = 1e6;
  const Json replay = ReplayJson({&motion, &predicted, nullptr, &errors}, 1000000);
  EXPECT_LT(replay["step"].get<double>(), 1e-4);
  EXPECT_EQ(UnpackPositions(replay["recorded"], 75)[2][12], 65535);
  EXPECT_NE(UnpackPositions(replay["recorded"], 75)[3][12], 65535);
}

TEST(ReportPageTest, IsOneFile) {
  const std::vector<RecordedMotion> motions = TwoMotions();
  const std::string own = OwnText(ReportHtml(RunFit(motions), FitChecks(), motions));
  EXPECT_EQ(own.find("http:"), std::string::npos);
  EXPECT_EQ(own.find("https:"), std::string::npos);
  const std::string page = own.substr(0, own.find("id=\"data\">")) + own.substr(own.find("</script>"));
  EXPECT_FALSE(std::regex_search(page, std::regex("<(script|link|iframe|img)[^>]*(src|href)", std::regex::icase)));
  EXPECT_NE(own.find("content=\"default-src 'none'"), std::string::npos);
  EXPECT_EQ(own.find("{{"), std::string::npos);
  EXPECT_EQ(own.back(), '\n');
}

TEST(ReportPageTest, NamesCannotEndTheirScript) {
  std::vector<RecordedMotion> motions = TwoMotions();
  motions[1].scene.obstacles[0].name = kHostileName;
  FitChecks checks;
  checks.flags = kHostileName;
  const std::string own = OwnText(ReportHtml(RunFit(motions), checks, motions));
  EXPECT_EQ(own.find("<img"), std::string::npos);
  const std::regex tag("<script|</script>");
  const std::size_t data = own.find("id=\"data\">"), end = own.find("</script>", data);
  EXPECT_EQ(own.substr(data + 10, end - data - 10).find('<'), std::string::npos);
  const std::string page = own.substr(0, data) + own.substr(end);
  EXPECT_EQ(std::distance(std::sregex_iterator(page.begin(), page.end(), tag), std::sregex_iterator()), 12);
}

TEST(ReportPageTest, SameBytesOnEveryRunButForTheSeconds) {
  const std::vector<RecordedMotion> motions = TwoMotions();
  const auto text = [&](int num_threads) {
    Json data = PageData(ReportHtml(RunFit(motions, num_threads), FitChecks(), motions));
    data["result"].erase("seconds");
    data["convergence"].erase("seconds");
    return data.dump();
  };
  const std::string first = text(1);
  EXPECT_EQ(text(1), first);
  EXPECT_EQ(text(2), first);
}

TEST(PageTemplateTest, MarksAreReplacedOnce) {
  EXPECT_EQ(FillPage("a{{x}}b{{y}}c", {{"{{x}}", "{{y}}"}, {"{{y}}", "2"}}), "a{{y}}b2c");
  EXPECT_THROW(FillPage("a{{y}}b{{x}}c", {{"{{x}}", "1"}, {"{{y}}", "2"}}), std::logic_error);
  EXPECT_EQ(ScriptText(Json("</script>\xff")), "\"\\u003c/script>\xEF\xBF\xBD\"");
  EXPECT_TRUE(RoundedJson(std::nan(""), 3).is_null());
  EXPECT_EQ(RoundedJson(1.0 / 3.0, 3), 0.333);
}

// What a point of a cloud is compared with is the nearest point of the surface, and the whole cloth is shown.
TEST(CloudPageTest, CloudsAreShownAsPoints) {
  for (const bool keep_points : {false, true}) {
    MotionOptions options;
    options.true_values = {{"k_stretch", 150.0}};
    RecordedMotion motion = MakeMotion(SwingScene(), options);
    const int num_nodes = motion.scene.mesh.num_nodes();
    AddClouds(20, 1e-3, keep_points, &motion);
    motion.clouds[2].conservativeResize(3, 7);
    const FitSummary summary = RunFit({motion});
    ASSERT_TRUE(summary.has_estimate()) << summary.message;
    const Json data = PageData(ReportHtml(summary, FitChecks(), {motion}));
    const Json& shown = data["recordings"][0];
    const int num_points = (keep_points ? num_nodes : 0) + 20;
    EXPECT_EQ(shown["points"], num_points);
    EXPECT_EQ(shown["replay"]["points"], num_points);
    EXPECT_FALSE(shown["replay"]["points_are_nodes"]);
    EXPECT_TRUE(shown["replay"].contains("nodes"));
    const RecordedMotion points = CloudsAsPoints(motion);
    const Eigen::MatrixXd closest = ClosestPoints(Observation(motion), summary.predicted[0]);
    ASSERT_EQ(closest.rows(), points.positions.rows());
    EXPECT_EQ((points.positions - closest).col(2).tail(3 * 13).array().isNaN().count(), 3 * 13);
    EXPECT_EQ((points.positions - closest).col(3).array().isNaN().count(), 0);
    // Two millimetres: noise of one.
    EXPECT_LT((points.positions - closest).col(3).tail(60).norm(), 2e-3 * std::sqrt(20.0));
  }
}

}  // namespace
}  // namespace clothid::report_page_test
