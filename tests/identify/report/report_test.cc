// The files of a fit: schema, and the same bytes every time.
#include "identify/report/report.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>

#include "identify/report/report_page.h"
#include "identify/result/result_json.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::report_test {
namespace {

using Json = nlohmann::ordered_json;

std::vector<RecordedMotion> TwoMotions() {
  MotionOptions options;
  options.true_values = {{"k_stretch", 150.0}};
  options.noise = 1e-3;
  return {MakeMotion(SwingScene(), options), MakeMotion(SphereScene(), options)};
}

FitSummary RunFit(const std::vector<RecordedMotion>& motions, int num_threads) {
  FitOptions options;
  options.parameters = {"mu.ball", "k_stretch"};
  options.num_threads = num_threads;
  FitProblem problem(motions, options);
  return Fit(options, &problem);
}

std::vector<std::string> Keys(const Json& json) {
  std::vector<std::string> keys;
  for (const auto& item : json.items()) keys.push_back(item.key());
  return keys;
}

FitSummary Converged() {
  FitSummary summary;
  summary.status = FitStatus::kConverged;
  FittedParameter parameter;
  parameter.name = "mu";
  summary.parameters = {parameter};
  return summary;
}

TEST(ReportTest, ResultHasItsSchema) {
  const std::vector<RecordedMotion> motions = TwoMotions();
  const FitSummary summary = RunFit(motions, 1);
  FitChecks checks;
  checks.gradient_check = GradientCheck{1e-12, 1e-7};
  checks.holdout = Holdout{0.1, std::numeric_limits<double>::quiet_NaN(), "nominal: failed"};
  checks.missing_forces = {{0.03, 1.0, 0.1}};
  const Json json = Json::parse(ResultJson(summary, checks, motions));
  EXPECT_EQ(Keys(json), (std::vector<std::string>{"schema",         "status",        "exit_code",
                                                  "usable",         "verdict",       "parameters",
                                                  "cloth",          "rmse_m",        "fit_percent",
                                                  "holdout",        "missing_force", "uncertainty",
                                                  "starts",         "profiles",      "step_check",
                                                  "cost",           "jacobian",      "plan",
                                                  "iterations",     "rollouts",      "rollouts_of_first_frames",
                                                  "sweeps",         "failed_steps",  "contact_events",
                                                  "gradient_check", "seconds",       "provenance"}));
  EXPECT_EQ(json["schema"], "clothid.result/1");
  EXPECT_EQ(json["status"], "converged");
  EXPECT_EQ(json["exit_code"], 0);
  EXPECT_EQ(Keys(json["parameters"]), (std::vector<std::string>{"mu.ball", "k_stretch"}));
  const Json& stretch = json["parameters"]["k_stretch"];
  EXPECT_EQ(Keys(stretch),
            (std::vector<std::string>{"value", "std", "lower95", "upper95", "start", "lower_bound", "upper_bound",
                                      "scale", "frozen", "at_bound", "identifiable", "usable"}));
  EXPECT_EQ(stretch["lower_bound"].get<double>(), summary.parameters[1].lower_bound);
  EXPECT_EQ(stretch["upper_bound"].get<double>(), summary.parameters[1].upper_bound);
  EXPECT_EQ(stretch["value"].get<double>(), summary.parameters[1].value) << "numbers read back exactly";
  EXPECT_EQ(stretch["identifiable"], true);
  EXPECT_EQ(stretch["usable"], "yes");
  EXPECT_EQ(json["usable"], "yes");
  EXPECT_EQ(json["verdict"][0], "usable: every fitted parameter is identifiable");
  EXPECT_EQ(stretch["std"].get<double>(), summary.uncertainty->parameters[1].std);
  EXPECT_LT(stretch["lower95"].get<double>(), stretch["value"].get<double>());
  EXPECT_GT(stretch["upper95"].get<double>(), stretch["value"].get<double>());
  EXPECT_EQ(json["uncertainty"]["correlation"]["k_stretch"]["k_stretch"], 1.0);
  EXPECT_EQ(json["uncertainty"]["singular_values"].size(), 2u);
  EXPECT_TRUE(json["uncertainty"]["hidden_directions"].empty());
  EXPECT_EQ(json["rmse_m"].get<double>(), summary.error.rmse());
  EXPECT_TRUE(json["holdout"]["nominal_rmse_m"].is_null());
  EXPECT_EQ(json["missing_force"], Json::parse(R"([{"deviation_N_m2": 0.03, "time_s": 1.0, "length_m": 0.1}])"));
  EXPECT_EQ(json["contact_events"], Json({{"contacts", summary.counts.contacts},
                                          {"nodes_joined", summary.counts.nodes_joined},
                                          {"nodes_left", summary.counts.nodes_left},
                                          {"branch_switches", summary.counts.branch_switches},
                                          {"obstacle_switches", 0}}));
  EXPECT_EQ(json["gradient_check"]["adjoint_vs_fd"], 1e-7);
  EXPECT_EQ(Keys(json["seconds"]), (std::vector<std::string>{"total", "rollout", "derivative", "solver"}));
  EXPECT_EQ(Keys(json["provenance"]),
            (std::vector<std::string>{"version", "git", "input_sha256", "flags", "seed", "threads"}));
  EXPECT_EQ(json["provenance"]["input_sha256"], "0123,0123");
  EXPECT_TRUE(Json::parse(ResultJson(summary, FitChecks(), motions))["holdout"].is_null());
}

TEST(ReportTest, ResultSaysWhatWasAssumedAndByHowMuchIntervalsWereWidened) {
  std::vector<RecordedMotion> motions = TwoMotions();
  FitSummary summary = RunFit(motions, 1);
  motions[0].sigma = Eigen::VectorXd::Constant(motions[0].num_points(), 2e-3);
  motions[0].sigma_source = SigmaSource::kEstimated;
  motions[1].start_source = StartSource::kSmoothed;
  summary.uncertainty->is_widened = true;
  summary.uncertainty->quantile95 = 2.5;
  summary.uncertainty->parameters[1].widening = 3.0;
  const Json json = Json::parse(ResultJson(summary, FitChecks(), motions));
  EXPECT_EQ(json["recordings"][0]["sigma_source"], "estimated");
  EXPECT_NEAR(json["recordings"][0]["sigma_m"].get<double>(), 2e-3, 1e-15);
  EXPECT_EQ(json["recordings"][0]["initial"], "scene");
  EXPECT_EQ(json["recordings"][1]["initial"], "smoothed");
  EXPECT_EQ(json["uncertainty"]["widening"]["quantile95"], 2.5);
  EXPECT_EQ(json["uncertainty"]["widening"]["parameters"]["k_stretch"], 3.0);
}

TEST(ReportTest, ContactsAreCountedAtTheEstimate) {
  const std::vector<RecordedMotion> motions = TwoMotions();
  const FitSummary summary = RunFit(motions, 1);
  RolloutCounts counts;
  for (const RecordedMotion& motion : motions) {
    Parameters parameters = motion.scene.nominal_parameters();
    for (double& mu : parameters.friction_coefficients) mu = summary.parameters[0].value;
    parameters.material.stretch_stiffness = summary.parameters[1].value;
    Simulator simulator(motion.scene);
    counts += Simulate(parameters, motion.scene.num_steps(), &simulator).counts;
  }
  EXPECT_GT(counts.nodes_joined, 0);
  EXPECT_EQ(summary.counts.steps, counts.steps);
  EXPECT_EQ(summary.counts.contacts, counts.contacts);
  EXPECT_EQ(summary.counts.nodes_joined, counts.nodes_joined);
  EXPECT_EQ(summary.counts.nodes_left, counts.nodes_left);
  EXPECT_EQ(summary.counts.branch_switches, counts.branch_switches);
}

TEST(ReportTest, NamesThatAreNoUtf8AreReplaced) {
  std::vector<RecordedMotion> motions = TwoMotions();
  for (RecordedMotion& motion : motions) motion.name = "r\xff.bin";
  FitChecks checks;
  checks.flags = "--target r\xff.bin";
  const FitSummary summary = RunFit(motions, 1);
  EXPECT_EQ(Json::parse(ResultJson(summary, checks, motions))["provenance"]["flags"], "--target r\xef\xbf\xbd.bin");
  EXPECT_NE(ReportHtml(summary, checks, motions).find("r\xef\xbf\xbd.bin"), std::string::npos);
}

TEST(ReportTest, KnowsItsFiles) {
  for (const char* name : {"result.json", "fabric.json", "card.html", "convergence.csv", "profile.csv", "report.html",
                           "predicted.bin", "predicted_2.bin", "predicted_10.bin"}) {
    EXPECT_TRUE(IsReportFile(name)) << name;
  }
  for (const char* name : {"", "result", "predicted_.bin", "predicted_2x.bin", "predicted_2.bin.bak",
                           "drape.motion.bin", "xpredicted_2.bin", "predicted_.", "landscape.csv"}) {
    EXPECT_FALSE(IsReportFile(name)) << name;
  }
}

TEST(ReportTest, SameBytesOnEveryRunAndOnTwoThreads) {
  const std::vector<RecordedMotion> motions = TwoMotions();
  const auto text = [&](int num_threads) {
    Json json = Json::parse(ResultJson(RunFit(motions, num_threads), FitChecks(), motions));
    json.erase("seconds");
    return json.dump();
  };
  const std::string first = text(1);
  EXPECT_EQ(text(1), first);
  EXPECT_EQ(text(2), first);
}

TEST(ReportTest, PredictionsAreRecordingsOfTheSamePoints) {
  RecordedMotion motion = TwoMotions()[0];
  const Eigen::MatrixXd predicted = motion.positions;
  MotionTensors tensors = PredictedMotion(motion, predicted, Converged().parameters);
  EXPECT_EQ(tensors.positions, predicted);
  EXPECT_EQ(tensors.times, motion.times);
  ASSERT_EQ(tensors.node_index.size(), 25u);
  EXPECT_EQ(tensors.node_index[24], 24);
  EXPECT_TRUE(tensors.handle_index.empty()) << "these handles have no path";

  for (ObservedPoint& point : motion.points) {
    point.num_nodes = 3;
    for (int k = 0; k < 3; ++k) {
      point.nodes[k] = motion.scene.mesh.faces(k, 5);
      point.weights[k] = (k + 1) / 6.0;
    }
  }
  tensors = PredictedMotion(motion, predicted, Converged().parameters);
  EXPECT_TRUE(tensors.node_index.empty());
  EXPECT_EQ(tensors.face_index[0], 5);
  EXPECT_EQ(tensors.barycentric(2, 0), 0.5);
}

TEST(ReportTest, WritesItsFiles) {
  std::string root = testing::TempDir() + "clothid_report_XXXXXX";
  ASSERT_NE(mkdtemp(root.data()), nullptr);
  const std::vector<RecordedMotion> motions = TwoMotions();
  const FitSummary summary = RunFit(motions, 1);
  {
    OutputFolder folder(root + "/result");
    WriteReport(summary, FitChecks(), motions, &folder);
  }
  std::ifstream csv(root + "/result/convergence.csv");
  std::string header;
  std::getline(csv, header);
  EXPECT_EQ(header, "iteration,seconds,cost,mu.ball,k_stretch,gradient_norm,rollouts");
  std::size_t num_rows = 0;
  for (std::string row; std::getline(csv, row);) ++num_rows;
  EXPECT_EQ(num_rows, summary.iterations.size());
  EXPECT_EQ(ReadMotionTensors(root + "/result/predicted.bin").positions, summary.predicted[0]);
  EXPECT_EQ(ReadMotionTensors(root + "/result/predicted_2.bin").positions, summary.predicted[1]);
  std::ifstream result(root + "/result/result.json");
  EXPECT_EQ(Json::parse(result)["status"], "converged");
  EXPECT_GT(std::filesystem::file_size(root + "/result/report.html"), 1000000u);
  {
    // Older files would be taken for those of this fit.
    for (const char* name : {"profile.csv", "predicted_3.bin", "predicted_x.bin", "notes.txt"}) {
      std::ofstream(root + "/result/" + name) << "old";
    }
    OutputFolder folder(root + "/result");
    ReportOptions options;
    options.page = false;
    WriteReport(summary, FitChecks(), motions, &folder, options);
  }
  for (const char* name : {"report.html", "profile.csv", "predicted_3.bin"}) {
    EXPECT_FALSE(std::filesystem::exists(root + "/result/" + name)) << name;
  }
  for (const char* name : {"predicted_2.bin", "predicted_x.bin", "notes.txt"}) {
    EXPECT_TRUE(std::filesystem::exists(root + "/result/" + name)) << name;
  }
  EXPECT_TRUE(std::filesystem::exists(root + "/result/result.json"));
  std::filesystem::remove_all(root);
}

}  // namespace
}  // namespace clothid::report_test
