// What was written comes back bit by bit, and nothing else does.
#include "costs/rows/evaluation_journal.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <atomic>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <memory>

#include "costs/rollout_cost.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"

namespace clothid::evaluation_journal_test {
namespace {

using Need = EvaluationNeed;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

const std::string kFingerprint(64, 'a');

bool SameBits(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         (a.size() == 0 || std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0);
}

bool SameBits(double a, double b) { return std::memcmp(&a, &b, sizeof(a)) == 0; }

EvaluationKey KeyNumber(int i) {
  return {Eigen::Vector2d(0.25 * i, -0.0), Precision::kLoose, i % 2 == 0 ? Need::kCost : Need::kRows, {1}};
}

// With every number that a comparison by value would get wrong.
EvaluationOutcome OutcomeNumber(int i) {
  EvaluationOutcome outcome;
  outcome.evaluation.coordinates = KeyNumber(i).coordinates;
  outcome.evaluation.precision = Precision::kLoose;
  outcome.evaluation.predicted = Eigen::MatrixXd::Constant(3, 2, 1.0 / 3.0 + i);
  outcome.evaluation.predicted(1, 1) = kNan;
  outcome.evaluation.cost = std::numeric_limits<double>::denorm_min();
  outcome.evaluation.loss_row = -0.0;
  outcome.evaluation.has_rows = true;
  outcome.evaluation.rows = {{0, 1},
                             "digest",
                             Eigen::Vector2d(kInfinity, -kInfinity),
                             Eigen::MatrixXd::Constant(2, 2, -kNan),
                             Eigen::MatrixXd::Constant(2, 3, kNan)};
  outcome.evaluation.has_gradient = i % 2 == 1;
  outcome.evaluation.gradient = Eigen::Vector2d(1e300, i);
  outcome.evaluation.product = Eigen::Vector2d(-0.0, kNan);
  outcome.statistics.rollouts = 3 + i;
  outcome.statistics.sweeps = 5;
  outcome.statistics.counts = {1, 2, 3, 4, 5, 6, 7, 8 + i};
  outcome.statistics.rollout_seconds = 0.1;
  outcome.statistics.derivative_seconds = 0.2;
  outcome.rollout_coordinates = Eigen::Vector2d(kNan, i);
  outcome.first_jacobian = Eigen::MatrixXd::Constant(3, 2, -0.0);
  return outcome;
}

EvaluationOutcome FailedOutcome() {
  EvaluationOutcome outcome;
  outcome.evaluation.failure = "step 3 did not converge";
  return outcome;
}

void ExpectSameEvaluation(const RolloutEvaluation& a, const RolloutEvaluation& b) {
  EXPECT_TRUE(SameBits(a.coordinates, b.coordinates));
  EXPECT_EQ(a.precision, b.precision);
  EXPECT_EQ(a.failure, b.failure);
  EXPECT_TRUE(SameBits(a.predicted, b.predicted));
  EXPECT_TRUE(SameBits(a.cost, b.cost));
  EXPECT_TRUE(SameBits(a.loss_row, b.loss_row));
  EXPECT_EQ(a.has_rows, b.has_rows);
  EXPECT_EQ(a.rows.active, b.rows.active);
  EXPECT_EQ(a.rows.along, b.rows.along);
  EXPECT_TRUE(SameBits(a.rows.residuals, b.rows.residuals));
  EXPECT_TRUE(SameBits(a.rows.jacobian, b.rows.jacobian));
  EXPECT_TRUE(SameBits(a.rows.frame_scores, b.rows.frame_scores));
  EXPECT_EQ(a.has_gradient, b.has_gradient);
  EXPECT_TRUE(SameBits(a.gradient, b.gradient));
  EXPECT_TRUE(SameBits(a.product, b.product));
}

void ExpectSame(const EvaluationOutcome& a, const EvaluationOutcome& b) {
  ExpectSameEvaluation(a.evaluation, b.evaluation);
  EXPECT_EQ(a.statistics.rollouts, b.statistics.rollouts);
  EXPECT_EQ(a.statistics.sweeps, b.statistics.sweeps);
  EXPECT_EQ(std::memcmp(&a.statistics.counts, &b.statistics.counts, sizeof(RolloutCounts)), 0);
  EXPECT_TRUE(SameBits(a.statistics.rollout_seconds, b.statistics.rollout_seconds));
  EXPECT_TRUE(SameBits(a.statistics.derivative_seconds, b.statistics.derivative_seconds));
  EXPECT_TRUE(SameBits(a.rollout_coordinates, b.rollout_coordinates));
  EXPECT_TRUE(SameBits(a.first_jacobian, b.first_jacobian));
}

void Append(const EvaluationKey& key, EvaluationOutcome outcome, EvaluationJournal* journal) {
  journal->Append(key, &outcome);
}

class EvaluationJournalTest : public testing::Test {
 protected:
  EvaluationJournalTest() {
    std::string name = testing::TempDir() + "clothid_journal_XXXXXX";
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    path_ = (folder_ / "journal.bin").string();
  }
  ~EvaluationJournalTest() override { std::filesystem::remove_all(folder_); }

  std::string Read() const {
    std::ifstream file(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }
  void Write(const std::string& bytes) const { std::ofstream(path_, std::ios::binary | std::ios::trunc) << bytes; }

  // Writes the outcomes 0 .. count - 1; the sizes of the file before each and after the last.
  std::vector<std::size_t> WriteRecords(int count) const {
    EvaluationJournal journal(path_, kFingerprint);
    std::vector<std::size_t> sizes = {Read().size()};
    for (int i = 0; i < count; ++i) {
      Append(KeyNumber(i), OutcomeNumber(i), &journal);
      sizes.push_back(Read().size());
    }
    return sizes;
  }

  // Replays what is there, which must be the outcomes 0, 1, ..; returns how many there were.
  static int ReplayAll(EvaluationJournal* journal) {
    int count = 0;
    while (const auto outcome = journal->Replay(KeyNumber(count))) ExpectSame(*outcome, OutcomeNumber(count++));
    return count;
  }

  std::filesystem::path folder_;
  std::string path_;
};

TEST_F(EvaluationJournalTest, GivesBackEveryBit) {
  WriteRecords(3);
  {
    EvaluationJournal journal(path_, kFingerprint);
    EXPECT_EQ(ReplayAll(&journal), 3);
    Append(KeyNumber(3), FailedOutcome(), &journal);
    EXPECT_EQ(journal.num_records(), 4);
  }
  EvaluationJournal journal(path_, kFingerprint);
  for (int i = 0; i < 3; ++i) journal.Replay(KeyNumber(i));
  const auto failed = journal.Replay(KeyNumber(3));
  ASSERT_TRUE(failed.has_value());
  ExpectSame(*failed, FailedOutcome());
  EXPECT_FALSE(journal.Replay(KeyNumber(4)).has_value());
}

TEST_F(EvaluationJournalTest, KnowsItsRoom) {
  constexpr std::uint64_t kEach = 3 * 2 + 3 * 2;  // the numbers of a prediction and a first Jacobian
  {
    EvaluationJournal journal(path_, kFingerprint, 2 * kEach * sizeof(double));
    EXPECT_TRUE(journal.HasRoomFor(2 * kEach));
    EXPECT_FALSE(journal.HasRoomFor(2 * kEach + 1));
    Append(KeyNumber(0), OutcomeNumber(0), &journal);
    EXPECT_TRUE(journal.HasRoomFor(kEach));
    EXPECT_FALSE(journal.HasRoomFor(kEach + 1));
  }
  EvaluationJournal journal(path_, kFingerprint, kEach * sizeof(double));
  EXPECT_TRUE(journal.HasRoomFor(kEach));
  journal.Replay(KeyNumber(0));
  EXPECT_FALSE(journal.HasRoomFor(1)) << "what is replayed takes its room";
  EXPECT_TRUE(journal.HasRoomFor(0));
}

TEST_F(EvaluationJournalTest, GoesOnFromEveryTornTail) {
  const std::vector<std::size_t> sizes = WriteRecords(3);
  const std::string whole = Read();
  for (std::size_t length = 0; length < whole.size(); ++length) {
    Write(whole.substr(0, length));
    int num_whole = 0;
    while (num_whole < 3 && sizes[num_whole + 1] <= length) ++num_whole;
    {
      EvaluationJournal journal(path_, kFingerprint);
      ASSERT_EQ(ReplayAll(&journal), num_whole) << length;
      for (int i = num_whole; i < 3; ++i) Append(KeyNumber(i), OutcomeNumber(i), &journal);
    }
    ASSERT_EQ(Read(), whole) << length;
  }
}

TEST_F(EvaluationJournalTest, NeverGivesBackADamagedRecord) {
  const std::vector<std::size_t> sizes = WriteRecords(2);
  const std::string whole = Read();
  for (std::size_t i = sizes[0]; i < whole.size(); ++i) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << (i % 8)));
    Write(damaged);
    EvaluationJournal journal(path_, kFingerprint);
    ASSERT_EQ(ReplayAll(&journal), i < sizes[1] ? 0 : 1) << i;
    ASSERT_EQ(Read(), whole.substr(0, i < sizes[1] ? sizes[0] : sizes[1])) << i;
  }
}

TEST_F(EvaluationJournalTest, RefusesDamagedHeaders) {
  const std::size_t header_size = WriteRecords(1).front();
  const std::string whole = Read();
  for (std::size_t i = 0; i < header_size; ++i) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ 1);
    Write(damaged);
    EXPECT_THROW(EvaluationJournal(path_, kFingerprint), Error) << i;
    EXPECT_EQ(Read(), damaged) << i;
  }
}

TEST_F(EvaluationJournalTest, RefusesTheJournalOfAnotherFit) {
  WriteRecords(1);
  const std::string whole = Read();
  ExpectError([&] { EvaluationJournal(path_, std::string(64, 'b')); }, ErrorKind::kUsage,
              {"journal.bin", "another", "remove"});
  EXPECT_EQ(Read(), whole);
  Write("a file of somebody else");
  ExpectError([&] { EvaluationJournal(path_, kFingerprint); }, ErrorKind::kBadData, {"journal.bin", "expected"});
  EXPECT_EQ(Read(), "a file of somebody else");
}

TEST_F(EvaluationJournalTest, RefusesOtherQuestions) {
  WriteRecords(1);
  const auto expect_refused = [&](const EvaluationKey& key) {
    EvaluationJournal journal(path_, kFingerprint);
    ExpectError([&] { journal.Replay(key); }, ErrorKind::kBadData, {"journal.bin", "record 1"});
  };
  EvaluationKey key = KeyNumber(0);
  key.coordinates[1] = 0.0;  // not -0.0
  expect_refused(key);
  key = KeyNumber(0);
  key.need = Need::kGradient;
  expect_refused(key);
  key = KeyNumber(0);
  key.precision = Precision::kFull;
  expect_refused(key);
  key = KeyNumber(0);
  key.active = {0};
  expect_refused(key);
  key.active = {0, 1};
  expect_refused(key);
  key = KeyNumber(0);
  key.coordinates.conservativeResize(1);
  expect_refused(key);
}

TEST_F(EvaluationJournalTest, HasOneUserAtATime) {
  EvaluationJournal journal(path_, kFingerprint);
  ExpectError([&] { EvaluationJournal(path_, kFingerprint); }, ErrorKind::kIo, {"journal.bin", "process"});
  ExpectError([&] { EvaluationJournal(path_ + "/below", kFingerprint); }, ErrorKind::kIo, {"below", "opened"});
}

class JournaledCostTest : public EvaluationJournalTest {
 protected:
  JournaledCostTest() : motion_(MakeMotion(SphereScene(), {{{"k_stretch", 150.0}}, 0.0, 0.0, 0.0})) {}

  RolloutCost MakeCost(const std::atomic<bool>* cancel) {
    RolloutCostOptions options;
    options.journal = std::make_shared<EvaluationJournal>(path_, kFingerprint);
    options.cancel = cancel;
    return RolloutCost(motion_, MakeBlocks(motion_.scene, {"k_stretch"}), options);
  }

  RecordedMotion motion_;
};

TEST_F(JournaledCostTest, KeepsNothingThatWasCancelled) {
  const std::size_t header_size = WriteRecords(0).front();
  const std::shared_ptr<const Obstacle> ball = motion_.scene.obstacles[0].shape;
  std::atomic<bool> cancel{false};
  motion_.scene.obstacles[0].shape = std::make_shared<InterruptingSphere>(200, &cancel);
  const Eigen::VectorXd start = StartOf(MakeBlocks(motion_.scene, {"k_stretch"}));
  double cost = 0.0;
  EXPECT_FALSE(MakeCost(&cancel).EvaluateGradient(start, &cost, nullptr));
  EXPECT_TRUE(cancel);
  EXPECT_EQ(Read().size(), header_size);

  motion_.scene.obstacles[0].shape = ball;
  EXPECT_TRUE(MakeCost(nullptr).EvaluateGradient(start, &cost, nullptr));
  EXPECT_GT(Read().size(), header_size);
  EXPECT_FALSE(MakeCost(&cancel).EvaluateGradient(start, &cost, nullptr)) << "nothing is replayed either";
}

TEST_F(JournaledCostTest, FailsForGoodOnAWrongRecord) {
  double cost = 0.0;
  Eigen::VectorXd start;
  {
    const RolloutCost rollout_cost = MakeCost(nullptr);
    start = StartOf(rollout_cost.model().blocks());
    EXPECT_TRUE(rollout_cost.EvaluateGradient(start, &cost, nullptr));
    rollout_cost.CheckJournal();
  }
  const RolloutCost rollout_cost = MakeCost(nullptr);
  Eigen::VectorXd other = start;
  other[0] += 0.1;
  for (const Eigen::VectorXd& point : {other, start}) {
    EXPECT_FALSE(rollout_cost.EvaluateGradient(point, &cost, nullptr));
    EXPECT_NE(rollout_cost.last_failure().find("journal.bin"), std::string::npos);
    ExpectError([&] { rollout_cost.CheckJournal(); }, ErrorKind::kBadData, {"journal.bin", "record 1"});
  }
}

}  // namespace
}  // namespace clothid::evaluation_journal_test
