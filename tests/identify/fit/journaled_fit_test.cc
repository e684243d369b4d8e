// A fit that was stopped anywhere and run again ends as if it had never been stopped.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "identify/base/fingerprint.h"
#include "identify/fit/first_frames.h"
#include "identify/fit/fit.h"
#include "identify/problem/model_errors.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"

namespace clothid::journaled_fit_test {
namespace {

constexpr std::size_t kHeaderSize = 18 + 64 + 1;

bool SameBits(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         (a.size() == 0 || std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0);
}

bool SameBits(double a, double b) { return std::memcmp(&a, &b, sizeof(a)) == 0; }

void ExpectSameError(const PredictionError& a, const PredictionError& b) {
  EXPECT_TRUE(SameBits(a.rmse(), b.rmse()));
  EXPECT_TRUE(SameBits(a.fit_percent(), b.fit_percent()));
}

void ExpectSameIterations(const FitSummary& a, const FitSummary& b) {
  ASSERT_EQ(a.iterations.size(), b.iterations.size());
  for (std::size_t i = 0; i < a.iterations.size(); ++i) {
    EXPECT_EQ(a.iterations[i].iteration, b.iterations[i].iteration);
    EXPECT_TRUE(SameBits(a.iterations[i].cost, b.iterations[i].cost));
    EXPECT_TRUE(SameBits(a.iterations[i].values, b.iterations[i].values));
    EXPECT_TRUE(SameBits(a.iterations[i].gradient_norm, b.iterations[i].gradient_norm));
    EXPECT_EQ(a.iterations[i].rollouts, b.iterations[i].rollouts);
  }
}

// In everything but seconds.
void ExpectSame(const FitSummary& a, const FitSummary& b) {
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.message, b.message);
  ASSERT_EQ(a.parameters.size(), b.parameters.size());
  for (std::size_t i = 0; i < a.parameters.size(); ++i) {
    EXPECT_TRUE(SameBits(a.parameters[i].value, b.parameters[i].value));
    EXPECT_EQ(a.parameters[i].at_bound, b.parameters[i].at_bound);
  }
  ASSERT_EQ(a.uncertainty.has_value(), b.uncertainty.has_value());
  for (std::size_t i = 0; a.uncertainty && i < a.parameters.size(); ++i) {
    EXPECT_TRUE(SameBits(a.uncertainty->parameters[i].coordinate_std, b.uncertainty->parameters[i].coordinate_std));
    EXPECT_TRUE(SameBits(a.uncertainty->parameters[i].widening, b.uncertainty->parameters[i].widening));
  }
  ASSERT_EQ(a.interval_check.has_value(), b.interval_check.has_value());
  if (a.interval_check) {
    EXPECT_TRUE(SameBits(a.interval_check->rise_above, b.interval_check->rise_above));
  }
  EXPECT_TRUE(SameBits(a.cost, b.cost));
  ExpectSameError(a.start_error, b.start_error);
  ExpectSameError(a.error, b.error);
  ASSERT_EQ(a.predicted.size(), b.predicted.size());
  for (std::size_t r = 0; r < a.predicted.size(); ++r) EXPECT_TRUE(SameBits(a.predicted[r], b.predicted[r]));
  ExpectSameIterations(a, b);
  EXPECT_EQ(a.statistics.rollouts, b.statistics.rollouts);
  EXPECT_EQ(a.statistics.sweeps, b.statistics.sweeps);
  EXPECT_EQ(std::memcmp(&a.statistics.counts, &b.statistics.counts, sizeof(RolloutCounts)), 0);
}

// The sizes that a journal had before its first record and after each one.
std::vector<std::size_t> RecordEnds(const std::string& journal) {
  std::vector<std::size_t> ends = {kHeaderSize};
  while (ends.back() < journal.size()) {
    std::uint64_t length = 0;
    std::memcpy(&length, journal.data() + ends.back(), sizeof(length));
    ends.push_back(ends.back() + 2 * sizeof(length) + 64 + length);
  }
  EXPECT_EQ(ends.back(), journal.size());
  return ends;
}

class JournaledFitTest : public testing::Test {
 protected:
  JournaledFitTest() {
    std::string name = testing::TempDir() + "clothid_resume_XXXXXX";
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    MotionOptions swing, sphere;
    swing.true_values = {{"k_stretch", 150.0}};
    sphere.true_values = {{"mu", 0.35}, {"k_stretch", 150.0}};
    swing.noise = sphere.noise = 1e-3;
    motions_ = {MakeMotion(SwingScene(), swing), MakeMotion(SphereScene(), sphere)};
    options_.parameters = {"mu", "k_stretch"};
    options_.journal_folder = folder_.string();
    // Many short fits.
    for (RecordedMotion& motion : motions_) motion.scene.solver.step_tolerance = 1e-6;
    options_.function_tolerance = 1e-4;
  }
  ~JournaledFitTest() override { std::filesystem::remove_all(folder_); }

  std::string Path(int recording) const {
    const std::string tag = options_.journal_tag.empty() ? "" : options_.journal_tag + "_";
    return (folder_ / (".journal_" + tag + std::to_string(recording + 1) + ".bin")).string();
  }
  std::string Read(int recording) const {
    std::ifstream file(Path(recording), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }
  void Write(int recording, const std::string& bytes) const {
    std::ofstream(Path(recording), std::ios::binary | std::ios::trunc) << bytes;
  }

  static FitSummary RunFit(const std::vector<RecordedMotion>& motions, const FitOptions& options) {
    FitProblem problem(motions, options);
    return Fit(options, &problem);
  }
  FitSummary RunFit() const { return RunFit(motions_, options_); }
  FitSummary RunWithoutJournal() const {
    FitOptions options = options_;
    options.journal_folder.clear();
    return RunFit(motions_, options);
  }

  std::filesystem::path folder_;
  std::vector<RecordedMotion> motions_;
  FitOptions options_;
};

TEST_F(JournaledFitTest, ReplaysFitsWhoseFramesAreWeighed) {
  for (RecordedMotion& motion : motions_) AddLastingNoise(3e-3, 0.9, 5, &motion);
  const FitSummary first = RunFit();
  ASSERT_FALSE(IsZero(first.model_errors));
  ExpectSame(RunFit(), first);
}

TEST_F(JournaledFitTest, ReplaysIntervalsThatWereWidened) {
  for (RecordedMotion& motion : motions_) AddLastingNoise(3e-3, 0.9, 5, &motion);
  options_.weighs_model_error = false;
  for (const JacobianMethod method : {JacobianMethod::kAdjoint, JacobianMethod::kSensitivity}) {
    options_.jacobian = method;
    options_.journal_tag = JacobianMethodName(method);
    const FitSummary first = RunFit();
    ASSERT_TRUE(first.uncertainty && first.uncertainty->is_widened);
    ExpectSame(RunFit(), first);
  }
}

class PrefixTest : public JournaledFitTest, public testing::WithParamInterface<std::tuple<JacobianMethod, int>> {};

INSTANTIATE_TEST_SUITE_P(Methods, PrefixTest,
                         testing::Combine(testing::Values(JacobianMethod::kAdjoint, JacobianMethod::kSensitivity,
                                                          JacobianMethod::kNumeric),
                                          testing::Values(1, 2)));

TEST_P(PrefixTest, AnyPrefixOfTheJournalsLeadsToTheSameEnd) {
  std::tie(options_.jacobian, options_.num_threads) = GetParam();
  const FitSummary uninterrupted = RunWithoutJournal();
  ASSERT_EQ(uninterrupted.status, FitStatus::kConverged) << uninterrupted.message;
  ExpectSame(RunFit(), uninterrupted);
  const std::string journals[] = {Read(0), Read(1)};
  const std::vector<std::size_t> ends[] = {RecordEnds(journals[0]), RecordEnds(journals[1])};
  ASSERT_GE(ends[1].size(), 5u);

  for (std::size_t i = 0; i < ends[1].size(); ++i) {
    // Two recordings side by side may be a record apart when the process ends.
    const std::size_t other = std::min(i + i % 2, ends[0].size() - 1);
    Write(0, journals[0].substr(0, ends[0][other]));
    Write(1, journals[1].substr(0, ends[1][i]));
    ExpectSame(RunFit(), uninterrupted);
    EXPECT_EQ(RecordEnds(Read(0)), ends[0]) << i;
    EXPECT_EQ(RecordEnds(Read(1)), ends[1]) << i;
  }
  // A whole journal leaves nothing to compute and nothing to add.
  Write(0, journals[0]);
  Write(1, journals[1]);
  ExpectSame(RunFit(), uninterrupted);
  EXPECT_EQ(Read(0), journals[0]);
  EXPECT_EQ(Read(1), journals[1]);
  // Predictions that find no room in the journal are made again, in the same bits.
  for (const std::uint64_t room : {std::uint64_t{0}, std::uint64_t{20000}}) {
    options_.journal_room = room;
    for (int r : {0, 1}) Write(r, "");
    ExpectSame(RunFit(), uninterrupted);
    const std::string small[] = {Read(0), Read(1)};
    EXPECT_LT(small[1].size(), journals[1].size() / 2) << room;
    const std::vector<std::size_t> small_ends[] = {RecordEnds(small[0]), RecordEnds(small[1])};
    for (std::size_t i = 0; i < small_ends[1].size(); i += 3) {
      for (int r : {0, 1}) Write(r, small[r].substr(0, small_ends[r][std::min(i, small_ends[r].size() - 1)]));
      ExpectSame(RunFit(), uninterrupted);
      EXPECT_EQ(RecordEnds(Read(1)), small_ends[1]) << room << " " << i;
    }
  }
  RecordProperty("records", static_cast<int>(ends[0].size() + ends[1].size()) - 2);
}

// From the truth, whence it is led nowhere: the first Jacobian is of a point whose cost was known before.
TEST_F(JournaledFitTest, AnyPrefixOfALedFitLeadsToTheSameEnd) {
  motions_.erase(motions_.begin());
  options_.overrides.start = {{"mu", 0.35}, {"k_stretch", 150.0}};
  const auto run = [&] {
    FitProblem problem(motions_, options_);
    return Fit(options_, &problem, &motions_);
  };
  const FitSummary uninterrupted = run();
  ASSERT_EQ(uninterrupted.status, FitStatus::kConverged) << uninterrupted.message;
  ASSERT_GT(uninterrupted.lead.rollouts, 0);
  ASSERT_GE(uninterrupted.iterations.size(), 2u);
  ASSERT_EQ(uninterrupted.iterations[1].values, uninterrupted.iterations[0].values);
  ASSERT_EQ(uninterrupted.iterations[1].rollouts, 2) << "its cost, then its rows";
  for (const std::uint64_t room : {kJournalRoom, std::uint64_t{0}}) {
    options_.journal_room = room;
    Write(0, "");
    ExpectSame(run(), uninterrupted);
    const std::string journal = Read(0);
    const std::vector<std::size_t> ends = RecordEnds(journal);
    for (const std::size_t end : ends) {
      Write(0, journal.substr(0, end));
      ExpectSame(run(), uninterrupted);
      EXPECT_EQ(RecordEnds(Read(0)), ends) << room << " " << end;
    }
  }
  using Entries = std::filesystem::directory_iterator;
  EXPECT_EQ(std::distance(Entries(folder_), Entries()), 1) << "the first frames go on in the journal of the fit";
}

TEST_F(JournaledFitTest, AnInterruptedFitGoesOn) {
  const FitSummary uninterrupted = RunWithoutJournal();
  std::atomic<bool> cancel{false};
  FitOptions interrupted = options_;
  interrupted.cancel = &cancel;
  interrupted.on_iteration = [&](const FitIteration& iteration) { cancel = iteration.iteration == 2; };
  EXPECT_EQ(RunFit(motions_, interrupted).status, FitStatus::kInterrupted);
  const std::size_t size = Read(1).size();
  ExpectSame(RunFit(), uninterrupted);
  EXPECT_LT(size, Read(1).size());
}

// While a prediction that found no room is made again.
TEST_F(JournaledFitTest, AFitThatIsInterruptedInItsReplayGoesOn) {
  options_.journal_room = 0;
  const FitSummary uninterrupted = RunFit();
  const std::string journal = Read(1);
  for (const int last_evaluation : {1, 3}) {
    std::atomic<bool> cancel{false};
    FitOptions interrupted = options_;
    interrupted.cancel = &cancel;
    interrupted.on_progress = [&](const EvaluationProgress& progress) {
      if (progress.evaluation == last_evaluation) cancel = true;
    };
    EXPECT_EQ(RunFit(motions_, interrupted).status, FitStatus::kInterrupted);
    EXPECT_EQ(Read(1), journal) << last_evaluation;
    ExpectSame(RunFit(), uninterrupted);
  }
}

// Their derivatives need more of a rollout than its journal keeps.
TEST_F(JournaledFitTest, AFitOfTheRecordingsOwnParametersGoesOn) {
  options_.each = {"time_offset", "turn.y", "v0.x"};
  const FitSummary uninterrupted = RunWithoutJournal();
  ASSERT_EQ(uninterrupted.status, FitStatus::kConverged) << uninterrupted.message;
  ExpectSame(RunFit(), uninterrupted);
  const std::string journals[] = {Read(0), Read(1)};
  const std::vector<std::size_t> ends[] = {RecordEnds(journals[0]), RecordEnds(journals[1])};
  for (const std::size_t part : {1, 2}) {
    for (int r : {0, 1}) Write(r, journals[r].substr(0, ends[r][part * (ends[r].size() - 1) / 3]));
    ExpectSame(RunFit(), uninterrupted);
    for (int r : {0, 1}) EXPECT_EQ(RecordEnds(Read(r)), ends[r]);
  }
}

TEST_F(JournaledFitTest, FailedRolloutsAreReplayed) {
  motions_[1].scene.solver.max_newton_iterations = 1;
  motions_[1].scene.solver.max_substep_halvings = 0;
  const FitSummary failed = RunWithoutJournal();
  ASSERT_EQ(failed.status, FitStatus::kFailed);
  ASSERT_GT(failed.statistics.counts.failed_steps, 0);
  ExpectSame(RunFit(), failed);
  const std::string journal = Read(1);
  ExpectSame(RunFit(), failed);
  EXPECT_EQ(Read(1), journal);
}

TEST_F(JournaledFitTest, RefusesJournalsThatDoNotFit) {
  RunFit();
  const std::string journal = Read(1);
  const std::vector<std::size_t> ends = RecordEnds(journal);
  // The first record is missing, so the second one answers the first question.
  Write(1, journal.substr(0, ends[0]) + journal.substr(ends[1]));
  ExpectError([&] { RunFit(); }, ErrorKind::kBadData, {Path(1).c_str(), "record 1"});
  Write(1, journal);
  options_.max_iterations = 49;
  ExpectError([&] { RunFit(); }, ErrorKind::kUsage, {Path(0).c_str(), "another"});
}

TEST_F(JournaledFitTest, FingerprintsTellFitsApart) {
  const auto fingerprint = [](const std::vector<RecordedMotion>& motions, const FitOptions& options) {
    return FitFingerprint(motions, MakeBlocks(motions.back().scene, {"mu", "k_stretch"}), options);
  };
  std::vector<std::string> seen = {fingerprint(motions_, options_)};
  const auto expect_new = [&](const std::function<void(std::vector<RecordedMotion>*, FitOptions*)>& change) {
    std::vector<RecordedMotion> motions = motions_;
    FitOptions options = options_;
    change(&motions, &options);
    const std::string changed = fingerprint(motions, options);
    EXPECT_EQ(std::count(seen.begin(), seen.end(), changed), 0) << seen.size();
    seen.push_back(changed);
  };
  using Motions = std::vector<RecordedMotion>;
  expect_new([](Motions* motions, FitOptions*) {
    motions->pop_back();
    motions->push_back(motions->front());
    motions->back().scene = SphereScene();
  });
  expect_new([](Motions* motions, FitOptions*) { motions->back().sha256 = "4567"; });
  expect_new([](Motions* motions, FitOptions*) { motions->back().scene_text = "{ }"; });
  expect_new([](Motions* motions, FitOptions*) { motions->back().positions(0, 0) += 1e-15; });
  expect_new([](Motions* motions, FitOptions*) { motions->back().centroid = Eigen::Vector3d::Zero(); });
  expect_new([](Motions* motions, FitOptions*) { motions->back().scene.time_step /= 2; });
  expect_new([](Motions* motions, FitOptions*) { motions->back().scene.initial_velocities[0] = 1e-9; });
  expect_new([](Motions* motions, FitOptions*) { motions->back().scene.solver.step_tolerance = 1e-7; });
  expect_new([](Motions* motions, FitOptions*) { motions->back().scene.material.stretch_stiffness = 51.0; });
  expect_new([](Motions* motions, FitOptions*) { motions->back().scene.parameters["mu"].lower_bound = 0.1; });
  expect_new([](Motions* motions, FitOptions*) { motions->back().scene.parameters["mu"].upper_bound = 1.0; });
  expect_new([](Motions* motions, FitOptions*) { motions->back().scene.parameters["mu"].frozen = true; });
  expect_new([](Motions*, FitOptions* options) { options->jacobian = JacobianMethod::kNumeric; });
  expect_new([](Motions*, FitOptions* options) { options->precision = FitPrecision::kFull; });
  expect_new([](Motions*, FitOptions* options) { options->loss = ParseRobustLoss("huber:2"); });
  expect_new([](Motions*, FitOptions* options) { options->loss = ParseRobustLoss("huber:3"); });
  expect_new([](Motions*, FitOptions* options) { options->max_iterations = 3; });
  expect_new([](Motions*, FitOptions* options) { options->function_tolerance = 1e-8; });
  expect_new([](Motions*, FitOptions* options) { options->parameter_tolerance = 1e-8; });
  FitOptions threads = options_;
  threads.num_threads = 7;
  EXPECT_EQ(fingerprint(motions_, threads), seen.front());
}

}  // namespace
}  // namespace clothid::journaled_fit_test
