// Every feature of a fit goes with every other: the table of pairs, each fitted on one small scene whose truth is
// known.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "identify/problem/model_errors.h"
#include "identify/run.h"
#include "tests/identify/lasting_result.h"
#include "tests/identify/pairs/pair_case.h"
#include "tests/temporary_folder.h"

namespace clothid::pairs_test {
namespace {

namespace fs = std::filesystem;

struct Feature {
  const char* name;
  void (*change)(PairCase* pair);
  // What the result has to say of the feature. The fit has an estimate by then.
  void (*check)(const PairCase& pair, const RunResult& result);
};

RunResult Fit(const PairCase& pair) {
  RunOptions options = pair.options;
  options.targets = pair.Recordings();
  return Identify(options);
}

// The parameter `name` is told to within `tolerance`, and the truth is that near, or within four standard deviations.
void ExpectNear(const RunResult& result, const std::string& name, double truth, double tolerance) {
  const std::vector<FittedParameter>& parameters = result.summary.parameters;
  const auto found = std::find_if(parameters.begin(), parameters.end(),
                                  [&](const FittedParameter& parameter) { return parameter.name == name; });
  ASSERT_NE(found, parameters.end()) << name;
  ASSERT_TRUE(result.summary.uncertainty.has_value());
  const double std = result.summary.uncertainty->parameters[found - parameters.begin()].std;
  EXPECT_LT(std, tolerance) << name;
  EXPECT_TRUE(std::abs(found->value - truth) < std::max(tolerance, 4.0 * std))
      << name << ": " << found->value << " +- " << std << ", truth " << truth;
}

void ExpectFilled(const std::vector<Eigen::MatrixXd>& values) {
  ASSERT_FALSE(values.empty());
  for (const Eigen::MatrixXd& each : values) EXPECT_GT(each.size(), 0);
}

// The level is that of the base: the logarithms of its nodes have that mean.
constexpr double kFieldLog = 0.3;

Eigen::Matrix2d TrueField() {
  Eigen::Matrix2d values;
  values << std::exp(kFieldLog), std::exp(-0.5 * kFieldLog), std::exp(0.5 * kFieldLog), std::exp(-kFieldLog);
  return PairCase::kStretch * values;
}

void AddField(PairCase* pair) {
  pair->truth.fields = {{ParameterKind::kStretchStiffness, TrueField()}};
  pair->FitFields({{"k_stretch", ParameterKind::kStretchStiffness, 2, 2}});
}

void CheckField(const PairCase&, const RunResult& result) {
  ASSERT_TRUE(result.summary.fields.has_value());
  ASSERT_EQ(result.summary.fields->fields.size(), 1u);
  const FittedField& field = result.summary.fields->fields.front();
  ASSERT_EQ(field.log_std.size(), 4);
  const Eigen::Matrix2d errors = (field.values.array() / TrueField().array()).log().abs();
  for (int i = 0; i < 4; ++i) {
    EXPECT_LT(errors(i), std::max(0.1, 4.0 * field.log_std(i))) << "node " << i << ": " << field.values(i);
  }
}

void AddPrior(PairCase* pair) {
  pair->options.fit.parameters.push_back("density");
  pair->options.fit.overrides.start["density"] = 0.25;
  pair->options.fit.overrides.priors["density"] = {0.2, 1.05};
}

void CheckPrior(const PairCase&, const RunResult& result) {
  ExpectNear(result, "density", 0.2, 0.02);
  EXPECT_TRUE(result.summary.uncertainty->parameters[1].beside_prior.has_value());
}

void StartAtRest(PairCase* pair) {
  pair->start_source = StartSource::kRest;
  pair->options.fit.assimilate = {};  // the recording would correct the state in place of a start
}

void CheckStartAtRest(const PairCase& pair, const RunResult& result) {
  ASSERT_EQ(result.summary.starts.size(), pair.bends.size());
  for (const StartEstimate& start : result.summary.starts) {
    EXPECT_GT(start.position_std, 0.0);
    EXPECT_LT(start.position_std, 2.0 * PairCase::kNoise);
  }
  EXPECT_FALSE(std::isnan(result.summary.uncertainty->parameters.front().known_start_std));
}

// The cloth turns about the line of its handles.
void StartMoving(PairCase* pair) {
  pair->start_source = StartSource::kMoving;
  pair->handle_noise = PairCase::kHandleNoise;
  Scene& scene = pair->truth;
  for (Eigen::Index i = 0; i < scene.initial_positions.size(); i += 3) {
    scene.initial_velocities[i + 2] = 2.0 * scene.initial_positions[i + 1];
  }
}

void CheckStartMoving(const PairCase& pair, const RunResult& result) {
  CheckStartAtRest(pair, result);
  for (const StartEstimate& start : result.summary.starts) {
    EXPECT_GT(start.velocity_std, 0.0);
    EXPECT_GT(start.handle_std, 0.0);
    EXPECT_LT(start.handle_std, 2.0 * PairCase::kHandleNoise);
  }
}

void ShiftHandles(PairCase* pair) {
  pair->handle_shift = {0.004, -0.003, 0.005};
  pair->options.fit.parameters.push_back("handle_shift");
}

void CheckHandleShift(const PairCase& pair, const RunResult& result) {
  for (int axis = 0; axis < 3; ++axis) {
    ExpectNear(result, std::string("handle_shift.") + "xyz"[axis], pair.handle_shift[axis], 2.0 * PairCase::kNoise);
  }
}

void AddGauge(PairCase* pair) { pair->has_gauge = true; }

void CheckGauge(const PairCase& pair, const RunResult& result) {
  EXPECT_EQ(result.summary.forces.size(), pair.bends.size());
  ExpectFilled(result.summary.forces);
  EXPECT_LT(result.summary.error.force.rms(), 3.0 * PairCase::kForceNoise);
}

constexpr int kNumKnots = 5;
const Eigen::VectorXd kTrueKnots = Eigen::Matrix<double, kNumKnots, 1>(0.3, 1.2, 1.6, 0.8, -0.2);  // m/s along y

void ChangeWind(PairCase* pair) {
  Wind& wind = pair->truth.wind;
  wind.mean.y() = 0.0;
  wind.profile.times = Eigen::VectorXd::LinSpaced(kNumKnots, 0.0, pair->truth.duration);
  wind.profile.velocities = Eigen::MatrixXd::Zero(3, kNumKnots);
  wind.profile.velocities.row(1) = kTrueKnots;
  pair->options.wind = ParseWindRequest(std::to_string(kNumKnots) + ":y");
}

void CheckWind(const PairCase& pair, const RunResult& result) {
  ASSERT_TRUE(result.checks.wind.has_value());
  EXPECT_EQ(result.checks.wind->smoothness_source, SmoothnessSource::kChosen);
  ASSERT_EQ(result.checks.wind->winds.size(), pair.bends.size());
  for (const FittedWind& wind : result.checks.wind->winds) {
    ASSERT_EQ(wind.values.size(), kNumKnots);
    for (int k = 0; k < kNumKnots; ++k) {
      const double std = (wind.upper95[k] - wind.lower95[k]) / (2.0 * kNormal95);
      EXPECT_LT(std::abs(wind.values[k] - kTrueKnots[k]), std::max(0.1, 4.0 * std)) << "knot " << k;
    }
  }
}

void AddScans(PairCase* pair) { pair->has_clouds = true; }

void CheckClouds(const PairCase&, const RunResult& result) {
  EXPECT_GT(result.summary.error.cloud.num_points, 0.0);
  EXPECT_LT(result.summary.error.cloud.rmse(), 2.0 * PairCase::kNoise);
}

void LetPointsSlide(PairCase* pair) { pair->slides = true; }

void CheckSurface(const PairCase& pair, const RunResult& result) {
  CheckClouds(pair, result);
  EXPECT_GT(result.summary.error.cloud.num_border, 0.0);
}

// Two cloths that differ in bending.
void AddRecording(PairCase* pair) {
  pair->bends = {1.5e-3, 3e-3};
  pair->options.fit.each = {"k_bend"};
}

void CheckRecordings(const PairCase& pair, const RunResult& result) {
  EXPECT_EQ(result.checks.recordings.size(), 2u);
  ExpectNear(result, "k_bend@1", pair.bends[0], 0.1 * pair.bends[0]);
  ExpectNear(result, "k_bend@2", pair.bends[1], 0.1 * pair.bends[1]);
}

void StartTwice(PairCase* pair) { pair->options.fit.num_starts = 2; }

void CheckStarts(const PairCase&, const RunResult& result) {
  ASSERT_TRUE(result.checks.starts.has_value());
  ASSERT_EQ(result.checks.starts->starts.size(), 2u);
  for (const StartResult& start : result.checks.starts->starts) EXPECT_EQ(start.minimum, 0);
}

void AskForProfile(PairCase* pair) { pair->options.profiles = {"k_stretch"}; }

void CheckProfile(const PairCase&, const RunResult& result) {
  ASSERT_EQ(result.checks.profiles.size(), 1u);
  const Profile& profile = result.checks.profiles.front();
  EXPECT_EQ(profile.num_failed, 0);
  EXPECT_LT(profile.lower95, result.summary.parameters.front().value);
  EXPECT_GT(profile.upper95, result.summary.parameters.front().value);
}

void AskForStepError(PairCase* pair) { pair->options.discretization.step = true; }

void CheckStepError(const PairCase&, const RunResult& result) {
  ASSERT_TRUE(result.checks.discretization.has_value());
  ASSERT_TRUE(result.checks.discretization->half_step.has_value());
  EXPECT_TRUE(result.checks.discretization->half_step->has_estimate());
  EXPECT_FALSE(std::isnan(result.summary.uncertainty->parameters.front().step_error));
}

void AskForMeshError(PairCase* pair) { pair->options.discretization.mesh = true; }

void CheckMeshError(const PairCase&, const RunResult& result) {
  ASSERT_TRUE(result.checks.discretization.has_value());
  ASSERT_TRUE(result.checks.discretization->fine_mesh.has_value());
  EXPECT_TRUE(result.checks.discretization->fine_mesh->has_estimate());
  EXPECT_FALSE(std::isnan(result.summary.uncertainty->parameters.front().mesh_error));
}

void ChooseStep(PairCase* pair) { pair->options.time_step.is_automatic = true; }

void CheckChosenStep(const PairCase&, const RunResult& result) {
  ASSERT_TRUE(result.checks.step_choice.has_value());
  EXPECT_FALSE(result.checks.step_choice->trials.empty());
  EXPECT_TRUE(result.checks.step_choice->found) << StepChoiceText(*result.checks.step_choice);
}

// The journals of a fit that is stopped as soon as it has ended, cut to half: a fit that resumes ends in the same
// bytes.
void Resume(PairCase* pair) { pair->options.resume = true; }

void CheckResumed(const PairCase& pair, const RunResult&) {
  PairCase again = pair;
  again.options.output = pair.options.output + "_resumed";
  std::atomic<bool> cancel = false;
  again.options.fit.cancel = &cancel;
  again.options.on_fitted = [&](const FitSummary&) { cancel = true; };
  EXPECT_EQ(Fit(again).summary.status, FitStatus::kInterrupted);
  int num_journals = 0;
  for (const auto& entry : fs::directory_iterator(again.options.output)) {
    if (entry.path().filename().string().rfind(kJournalPrefix, 0) != 0) continue;
    fs::resize_file(entry.path(), fs::file_size(entry.path()) / 2);
    ++num_journals;
  }
  EXPECT_GT(num_journals, 0);
  cancel = false;
  again.options.on_fitted = {};
  Fit(again);
  const std::map<std::string, std::string> expected = ReadLastingResult(pair.options.output);
  const std::map<std::string, std::string> resumed = ReadLastingResult(again.options.output);
  ASSERT_EQ(resumed.size(), expected.size());
  for (const auto& [name, content] : expected) EXPECT_TRUE(resumed.at(name) == content) << name;
}

void UseThreads(PairCase* pair) { pair->options.fit.num_threads = 2; }

void CheckThreads(const PairCase& pair, const RunResult& result) {
  PairCase alone = pair;
  alone.options.output.clear();
  alone.options.resume = false;
  alone.options.simulators.clear();
  alone.options.fit.num_threads = 1;
  const RunResult other = Fit(alone);
  EXPECT_EQ(other.summary.coordinates, result.summary.coordinates);
  ASSERT_TRUE(other.summary.uncertainty && result.summary.uncertainty);
  for (std::size_t i = 0; i < other.summary.parameters.size(); ++i) {
    const double expected = other.summary.uncertainty->parameters[i].half_width95;
    EXPECT_EQ(result.summary.uncertainty->parameters[i].half_width95, expected) << other.summary.parameters[i].name;
  }
  EXPECT_EQ(other.verdict.Lines(), result.verdict.Lines());
}

void HoldOut(PairCase* pair) { pair->options.holdout_frames = FrameRange{10, 13}; }

void CheckHeldOut(const PairCase&, const RunResult& result) {
  ASSERT_TRUE(result.checks.holdout.has_value());
  EXPECT_EQ(result.checks.holdout->failure, "");
  EXPECT_LT(result.checks.holdout->rmse, 2.5 * PairCase::kNoise) << "sqrt(3) of it is noise";
}

void DoubtPoints(PairCase* pair) {
  pair->has_outliers = true;
  pair->options.fit.loss = ParseRobustLoss("huber:2");
}

// They would raise the cost of squares.
void CheckRobust(const PairCase&, const RunResult& result) {
  const PredictionError& error = result.summary.error;
  const double squares = error.squared_error + error.cloud.squared_distance + error.cloud.squared_border;
  EXPECT_LT(result.summary.cost, 0.5 * squares / std::pow(PairCase::kNoise, 2));
}

void Export(PairCase* pair) { pair->options.simulators = {"mujoco", "newton"}; }

void CheckExported(const PairCase& pair, const RunResult&) {
  for (const char* name : {"export_mujoco.xml", "export_newton.py", "export_cloth.obj"}) {
    EXPECT_TRUE(fs::exists(fs::path(pair.options.output) / name)) << name;
  }
}

constexpr Feature kFeatures[] = {
    {"Field", AddField, CheckField},
    {"Prior", AddPrior, CheckPrior},
    {"StartAtRest", StartAtRest, CheckStartAtRest},
    {"StartMoving", StartMoving, CheckStartMoving},
    {"HandleShift", ShiftHandles, CheckHandleShift},
    {"Forces", AddGauge, CheckGauge},
    {"WindProfile", ChangeWind, CheckWind},
    {"Clouds", AddScans, CheckClouds},
    {"Surface", LetPointsSlide, CheckSurface},
    {"Recordings", AddRecording, CheckRecordings},
    {"Starts", StartTwice, CheckStarts},
    {"Profile", AskForProfile, CheckProfile},
    {"StepError", AskForStepError, CheckStepError},
    {"MeshError", AskForMeshError, CheckMeshError},
    {"ChosenStep", ChooseStep, CheckChosenStep},
    {"Resume", Resume, CheckResumed},
    {"Threads", UseThreads, CheckThreads},
    {"HeldOutFrames", HoldOut, CheckHeldOut},
    {"RobustLoss", DoubtPoints, CheckRobust},
    {"Export", Export, CheckExported},
};

struct Contradiction {
  const char *one, *other, *reason;
};

// The pairs that are none: all others work.
constexpr Contradiction kContradictions[] = {
    {"StartAtRest", "StartMoving", "a recording has one StartSource"},
};

using Pair = std::pair<const Feature*, const Feature*>;

bool IsContradiction(const Pair& pair) {
  return std::any_of(std::begin(kContradictions), std::end(kContradictions), [&](const Contradiction& each) {
    return std::string(each.one) == pair.first->name && std::string(each.other) == pair.second->name;
  });
}

std::vector<Pair> AllPairs() {
  std::vector<Pair> pairs;
  for (const Feature& one : kFeatures) {
    for (const Feature* other = &one + 1; other != std::end(kFeatures); ++other) {
      if (!IsContradiction({&one, other})) pairs.emplace_back(&one, other);
    }
  }
  return pairs;
}

class PairsTest : public testing::Test {
 protected:
  // Fits with these features, and expects the truth and what each has to say.
  void ExpectWorks(const std::vector<const Feature*>& features) {
    PairCase pair;
    pair.options.fit.parameters = {"k_stretch"};
    pair.options.check_recordings = false;
    pair.options.report_page = false;
    pair.options.output = folder_.File("result");
    for (const Feature* feature : features) feature->change(&pair);
    const RunResult result = Fit(pair);
    ASSERT_TRUE(result.summary.has_estimate()) << result.summary.message;
    EXPECT_EQ(result.summary.status, FitStatus::kConverged) << result.summary.message;
    // What is left is noise, or what frames were weighed by.
    if (!pair.has_outliers && IsZero(result.summary.model_errors)) {
      EXPECT_LT(result.summary.error.rmse(), 1.25 * std::sqrt(3.0) * PairCase::kNoise);
    }
    ExpectNear(result, "k_stretch", PairCase::kStretch, 0.1 * PairCase::kStretch);
    for (const Feature* feature : features) {
      SCOPED_TRACE(feature->name);
      feature->check(pair, result);
    }
  }

  TemporaryFolder folder_;
};

class FeatureTest : public PairsTest, public testing::WithParamInterface<Feature> {};

TEST_P(FeatureTest, WorksAlone) { ExpectWorks({&GetParam()}); }

INSTANTIATE_TEST_SUITE_P(All, FeatureTest, testing::ValuesIn(kFeatures),
                         [](const auto& feature) { return feature.param.name; });

class PairTest : public PairsTest, public testing::WithParamInterface<Pair> {};

TEST_P(PairTest, Works) { ExpectWorks({GetParam().first, GetParam().second}); }

INSTANTIATE_TEST_SUITE_P(All, PairTest, testing::ValuesIn(AllPairs()), [](const auto& pair) {
  return std::string(pair.param.first->name) + "_with_" + pair.param.second->name;
});

// A name that is misspelt contradicts nothing.
TEST_F(PairsTest, ContradictionsAreOfFeatures) {
  const auto is_feature = [](const std::string& name) {
    return std::any_of(std::begin(kFeatures), std::end(kFeatures),
                       [&](const Feature& each) { return each.name == name; });
  };
  for (const Contradiction& each : kContradictions) {
    EXPECT_TRUE(is_feature(each.one) && is_feature(each.other)) << each.one << " with " << each.other;
    EXPECT_STRNE(each.reason, "");
  }
}

}  // namespace
}  // namespace clothid::pairs_test
