// `Identify` as a call: it gives what the program gives, in memory and in files, and tells what it does.
#include "identify/run.h"

#include <algorithm>
#include <atomic>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "identify/result/result_json.h"
#include "tests/expect_error.h"
#include "tests/tools/tool_test.h"

namespace clothid::run_test {
namespace {

using Json = nlohmann::ordered_json;

// A result without what differs from one run to the next, and between a program and a call.
std::string WithoutRun(const std::string& text) {
  Json json = Json::parse(text);
  json.erase("seconds");
  json["provenance"].erase("flags");
  return json.dump(2);
}

class RunTest : public ToolTest {
 protected:
  RunTest() {
    const std::string simulate = "simulate --scene " + WriteScene(SphereJson()) + " --noise 1e-4 --set k_stretch=120 ";
    ExpectSuccess(simulate + "--output fitted.bin");
    ExpectSuccess(simulate + "--seed 2 --output held_out.bin");
  }

  std::string Path(const std::string& name) const { return (folder() / name).string(); }

  RunOptions Options() const {
    RunOptions options;
    options.target_paths = {Path("fitted.bin")};
    options.fit.parameters = {"k_stretch"};
    return options;
  }

  // Everything that can be asked for beside the fit.
  RunOptions AllChecks() const {
    RunOptions options = Options();
    options.holdout_paths = {Path("held_out.bin")};
    options.fit.num_starts = 2;
    options.check_gradients = true;
    options.discretization = {true, true};
    options.profiles = {"k_stretch"};
    return options;
  }

  void ExpectInvalid(const RunOptions& options, const std::string& culprit) const {
    const std::set<std::string> before = Files();
    try {
      Identify(options);
      ADD_FAILURE() << "expected an error about " << culprit;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kUsage) << error.what();
      EXPECT_NE(std::string(error.what()).find(culprit), std::string::npos) << error.what();
    }
    EXPECT_EQ(Files(), before);
  }
};

TEST_F(RunTest, GivesWhatTheProgramGives) {
  const ToolResult program = Run(
      "identify --target '" + Path("fitted.bin") + "' --holdout '" + Path("held_out.bin") +
      "' --fit k_stretch --starts 2 --check_gradients --discretization all --profile k_stretch --output by_program");
  RunOptions options = AllChecks();
  options.output = Path("by_call");
  const RunResult result = Identify(options);
  EXPECT_EQ(result.exit_code, program.exit_code) << program.err;
  EXPECT_EQ(result.table, program.out);
  EXPECT_EQ(WithoutRun(ReadBytes(folder() / "by_call/result.json")),
            WithoutRun(ReadBytes(folder() / "by_program/result.json")));
  for (const char* name : {"profile.csv", "predicted.bin"}) {
    EXPECT_EQ(ReadBytes(folder() / "by_call" / name), ReadBytes(folder() / "by_program" / name)) << name;
  }
  EXPECT_TRUE(std::filesystem::exists(folder() / "by_call/report.html"));
  // The parts were there to be compared.
  const Json json = Json::parse(ReadBytes(folder() / "by_call/result.json"));
  EXPECT_EQ(json["starts"]["starts"].size(), 2u) << json["starts"];
  for (const char* part : {"holdout", "profiles", "step_check", "double_step", "fine_mesh", "gradient_check"})
    EXPECT_FALSE(json[part].is_null());
  EXPECT_EQ(json["verdict"], Json(result.verdict.Lines()));
  const Json& stretch = json["parameters"]["k_stretch"];
  EXPECT_GT(stretch["step_error"].get<double>(), 0.0);
  EXPECT_GT(stretch["mesh_error"].get<double>(), 0.0);
  EXPECT_EQ(stretch["upper95"].get<double>(), result.summary.uncertainty->parameters[0].upper95);
}

TEST_F(RunTest, TellsTheErrorsOfTheDiscretizationThatWereAskedFor) {
  const std::string identify =
      "identify --target '" + Path("fitted.bin") + "' --fit k_stretch --report=false --output ";
  const ToolResult step = Run(identify + "b --discretization step");
  EXPECT_EQ(step.exit_code, kExitNotIdentifiable) << "a step so large that it tells next to nothing";
  EXPECT_NE(step.out.find("k_stretch is hardly told at this time step and mesh"), std::string::npos) << step.out;
  EXPECT_NE(step.out.find(" from the time step ("), std::string::npos) << step.out;
  EXPECT_EQ(step.out.find(" from the mesh"), std::string::npos) << step.out;
  const Json json = Json::parse(ReadBytes(folder() / "b/result.json"));
  EXPECT_TRUE(json["parameters"]["k_stretch"]["mesh_error"].is_null());
  EXPECT_FALSE(json.contains("fine_mesh"));
  const ToolResult both = Run(identify + "c --discretization all");
  EXPECT_NE(both.out.find(" from the time step ("), std::string::npos) << both.out;
  EXPECT_NE(both.out.find(" from the mesh"), std::string::npos) << both.out;
}

// What is refused with the error of two fits is not with that of one rollout.
TEST_F(RunTest, TellsTheErrorOfTheStepUnasked) {
  const ToolResult fit = Run("identify --target '" + Path("fitted.bin") + "' --fit k_stretch --output a");
  EXPECT_EQ(fit.exit_code, 0) << fit.err;
  EXPECT_NE(fit.out.find("  noise +- "), std::string::npos) << fit.out;
  EXPECT_NE(fit.out.find(", step +- "), std::string::npos) << fit.out;
  EXPECT_NE(fit.out.find("usable with care: the error of the time step exceeds the noise"), std::string::npos);
  const Json stretch = Json::parse(ReadBytes(folder() / "a/result.json"))["parameters"]["k_stretch"];
  const double error = stretch["step_error"].get<double>(), std = stretch["std"].get<double>();
  EXPECT_GT(error, 2.0 * std);
  EXPECT_GT(stretch["upper95"].get<double>() - stretch["lower95"].get<double>(), 3.9 * error);
  EXPECT_TRUE(stretch.contains("step_order"));
  EXPECT_FALSE(stretch.contains("mesh_error"));
  EXPECT_EQ(stretch["identifiable"], true);
}

TEST_F(RunTest, RefusesMeshesThatHaveNoFinerOneBeforeTheFit) {
  RunOptions options = Options();
  options.targets = {ReadMotion(options.target_paths.front())};
  options.target_paths.clear();
  options.targets.front().scene.node_force.z() = 1e-4;
  options.discretization.mesh = true;
  options.on_problem = [](const std::vector<std::string>&) { ADD_FAILURE() << "the fit has begun"; };
  ExpectInvalid(options, "--discretization");
  ExpectInvalid(options, "'node_force'");
}

TEST_F(RunTest, TakesRecordingsInMemoryAndWritesNothingUnasked) {
  RunOptions options = AllChecks();
  const RunResult from_files = Identify(options);
  const std::vector<RecordedMotion> motions = {ReadMotion(options.target_paths.front())};
  options.targets = motions;
  options.holdouts = {ReadMotion(options.holdout_paths.front())};
  options.target_paths.clear();
  options.holdout_paths.clear();
  const std::set<std::string> before = Files();
  const RunResult from_memory = Identify(options);
  EXPECT_EQ(Files(), before);
  EXPECT_EQ(WithoutRun(ResultJson(from_memory.summary, from_memory.checks, motions)),
            WithoutRun(ResultJson(from_files.summary, from_files.checks, motions)));
  EXPECT_EQ(from_memory.exit_code, from_files.exit_code);
}

TEST_F(RunTest, ChecksRecordingsBeforeTheFit) {
  RunOptions options = Options();
  options.targets = {ReadMotion(options.target_paths.front())};
  options.target_paths.clear();
  RecordedMotion& motion = options.targets.front();
  motion.scene.gravity *= 100.0;  // in cm/s^2
  std::vector<std::string> told;
  options.on_finding = [&](const std::string&, const Finding& finding) { told.push_back(finding.what); };
  options.output = Path("result");
  options.fit.max_iterations = 1;
  const RunResult result = Identify(options);
  EXPECT_EQ(std::count(told.begin(), told.end(), "gravity"), 1);
  ASSERT_EQ(result.checks.findings.size(), 1u);
  const Json findings = Json::parse(ReadBytes(folder() / "result/result.json"))["findings"];
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_TRUE(std::any_of(findings[0].begin(), findings[0].end(), [](const Json& finding) {
    return finding["what"] == "gravity" && finding["verdict"] == "warning";
  })) << findings;
}

TEST_F(RunTest, AProblemOfARecordingEndsTheRun) {
  RunOptions options = Options();
  options.targets = {ReadMotion(options.target_paths.front()), ReadMotion(Path("held_out.bin"))};
  options.target_paths.clear();
  options.targets.back().positions *= 1000.0;
  options.output = Path("result");
  bool is_started = false;
  options.on_problem = [&](const std::vector<std::string>&) { is_started = true; };
  const std::set<std::string> before = Files();
  ExpectError([&] { Identify(options); }, ErrorKind::kBadData, {"held_out.bin", "edge lengths", "--scale 0.001"});
  options.holdouts = {options.targets.back()};
  options.targets.pop_back();
  ExpectError([&] { Identify(options); }, ErrorKind::kBadData, {"held_out.bin", "edge lengths", "--scale 0.001"});
  EXPECT_FALSE(is_started);
  EXPECT_EQ(Files(), before);
  options.check_recordings = false;
  EXPECT_TRUE(Identify(options).checks.findings.empty());
  EXPECT_TRUE(is_started);
}

TEST_F(RunTest, TellsWhereItStands) {
  RunOptions options = AllChecks();
  std::vector<std::string> told;
  int num_evaluations = 0;
  const auto tell = [&told](const std::string& what) {
    if (told.empty() || told.back() != what) told.push_back(what);
  };
  options.on_problem = [&](const std::vector<std::string>& names) { tell("problem of " + names.front()); };
  options.fit.on_start = [&](int start) { tell("start " + std::to_string(start)); };
  options.fit.on_iteration = [&](const FitIteration&) { tell("iterations"); };
  options.fit.on_progress = [&](const EvaluationProgress& progress) { num_evaluations = progress.evaluation; };
  options.on_fitted = [&](const FitSummary&) { tell("fitted"); };
  options.on_examined = [&](const FitSummary&) { tell("examined"); };
  std::string table;
  options.on_table = [&](const std::string& text) {
    tell("table");
    table = text;
    EXPECT_FALSE(std::filesystem::exists(Path("result/result.json"))) << "a table is not lost with the files";
  };
  options.output = Path("result");
  const RunResult result = Identify(options);
  EXPECT_EQ(table, result.table);
  const CostStatistics& statistics = result.summary.statistics;
  EXPECT_GE(result.summary.total_seconds, statistics.rollout_seconds + statistics.derivative_seconds)
      << "the total has the profile and the fit at half the step, as its parts have";
  EXPECT_EQ(told, (std::vector<std::string>{"problem of k_stretch", "start 0", "iterations", "start 1", "iterations",
                                            "fitted", "examined", "table"}))
      << "of the fits of profiles and of the step check nothing is told";
  EXPECT_GT(num_evaluations, 0);
}

TEST_F(RunTest, EndsWhereItIsCancelled) {
  RunOptions options = AllChecks();
  options.output = Path("result");
  std::atomic<bool> cancel{false};
  options.fit.cancel = &cancel;
  options.on_fitted = [&](const FitSummary&) { cancel = true; };
  const RunResult result = Identify(options);
  EXPECT_EQ(result.exit_code, kExitInterrupted);
  EXPECT_EQ(result.summary.status, FitStatus::kInterrupted);
  EXPECT_NE(result.verdict.line.find("interrupted: stopped on request, at the best point so far"), std::string::npos)
      << result.verdict.line;
  EXPECT_TRUE(result.checks.profiles.empty());
  EXPECT_FALSE(result.checks.discretization);
  EXPECT_TRUE(std::filesystem::exists(folder() / "result/result.json")) << "the best point is not lost";
  cancel = true;
  EXPECT_EQ(Identify(options).exit_code, kExitInterrupted) << "before anything was simulated";
}

TEST_F(RunTest, AGradientCheckThatCannotBeDoneEndsAsNotConverged) {
  RunOptions options = AllChecks();
  options.targets = {ReadMotion(options.target_paths.front())};
  options.target_paths.clear();
  options.targets.front().scene.solver.max_newton_iterations = 1;
  options.targets.front().scene.solver.max_substep_halvings = 0;
  options.output = Path("result");
  const std::set<std::string> before = Files();
  const RunResult result = Identify(options);
  EXPECT_EQ(result.exit_code, kExitNotConverged);
  EXPECT_EQ(result.summary.message.rfind("gradient check: ", 0), 0u) << result.summary.message;
  EXPECT_EQ(result.table, "");
  EXPECT_EQ(Files(), before);
}

TEST_F(RunTest, WhatACallbackThrowsLeavesTheCallAndNothingBehind) {
  RunOptions options = Options();
  options.output = Path("result");
  options.on_examined = [](const FitSummary&) { throw std::logic_error("a caller's own"); };
  const std::set<std::string> before = Files();
  EXPECT_THROW(Identify(options), std::logic_error);
  EXPECT_EQ(Files(), before);
}

TEST_F(RunTest, AnInternalErrorOfARolloutIsNoRolloutThatFails) {
  RunOptions options = Options();
  options.output = Path("result");
  options.resume = true;
  options.fit.on_progress = [](const EvaluationProgress&) { throw std::bad_alloc(); };
  const std::set<std::string> before = Files();
  EXPECT_THROW(Identify(options), std::bad_alloc);
  EXPECT_EQ(Files(), before);
  bool is_under_way = false;  // so that it is thrown through the optimiser
  options.fit.on_iteration = [&](const FitIteration&) { is_under_way = true; };
  options.fit.on_progress = [&](const EvaluationProgress&) {
    if (is_under_way) throw std::bad_alloc();
  };
  EXPECT_THROW(Identify(options), std::bad_alloc);
  EXPECT_EQ(Files(), before);
  options.fit.num_threads = 2;
  options.target_paths.push_back(Path("held_out.bin"));
  EXPECT_THROW(Identify(options), std::bad_alloc);
  EXPECT_EQ(Files(), before);
}

TEST_F(RunTest, RefusesWhatGoesWithNoOther) {
  ExpectInvalid(RunOptions(), "--target");
  RunOptions options = Options();
  options.targets = {ReadMotion(options.target_paths.front())};
  ExpectInvalid(options, "target_paths");
  options = AllChecks();
  options.holdouts = {ReadMotion(options.holdout_paths.front())};
  ExpectInvalid(options, "holdout_paths");
  options = AllChecks();
  options.holdout_frames = FrameRange{1, 3};
  ExpectInvalid(options, "--holdout_frames");
  options = Options();
  options.landscape_paths = {"landscape"};
  ExpectInvalid(options, "--landscape");
  options = Options();
  options.resume = true;
  ExpectInvalid(options, "--resume");
  options = Options();
  options.step_tolerance = -1.0;
  ExpectInvalid(options, "--step_tolerance");
  options = Options();
  options.fit.num_starts = 0;
  ExpectInvalid(options, "--starts");
  options = Options();
  options.profiles = {"mu"};
  options.output = Path("result");
  ExpectInvalid(options, "--profile: 'mu'");
}

// Two recordings of one experiment, and the same from folders of their finished fits.
TEST_F(RunTest, TheProgramJudgesRepetitions) {
  const std::string fit = " --fit k_stretch --report=false --output ";
  const ToolResult joint = Run("identify --repeat --target fitted.bin,held_out.bin" + fit + "joint");
  ASSERT_TRUE(std::filesystem::exists(folder() / "joint/result.json")) << joint.err;
  EXPECT_NE(joint.out.find("of 2 recordings\n"), std::string::npos) << joint.out;
  Run("identify --target fitted.bin" + fit + "fits/1");
  Run("identify --target held_out.bin" + fit + "fits/2");
  ExpectSuccess("identify --repeat --target fits --report=false --output pooled");
  const auto pooled = [&](const std::string& path) {
    return Json::parse(ReadBytes(folder() / path)).at("repetitions").at("parameters").dump();
  };
  EXPECT_EQ(pooled("pooled/result.json"), pooled("joint/result.json"));
  ExpectRefused("identify --repeat --target fits --sigma 0.001 --output none", 1, "--sigma");
  ExpectRefused("identify --repeat --target fits --loss huber:2 --output none", 1, "--loss");
}

}  // namespace
}  // namespace clothid::run_test
