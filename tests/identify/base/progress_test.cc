// What people read while a fit runs: where an evaluation stands and how long it will take yet.
#include "identify/base/progress.h"

#include <gtest/gtest.h>

#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "identify/base/evaluation_progress.h"
#include "identify/fit/fit.h"
#include "identify/problem/problem.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::progress_test {
namespace {

// A tracker and what it told last, on a clock that stands still until it is set.
class TrackerTest : public testing::Test {
 protected:
  void Step(double time, int recording, RolloutPass pass, int num_done, int num_steps, int passes_left = 0) {
    now_ = time;
    tracker_.AddStep(recording, {pass, num_done, num_steps, passes_left});
  }

  double now_ = 100.0;
  EvaluationProgress last_;
  EvaluationTracker tracker_{[this](const EvaluationProgress& progress) { last_ = progress; }, [this] { return now_; }};
};

TEST_F(TrackerTest, TimeLeftGoesWithTheStepsThatAreLeft) {
  tracker_.AddRecording(10);
  tracker_.Begin(EvaluationPurpose::kFit);
  Step(102.0, 0, RolloutPass::kRollout, 1, 10);
  EXPECT_EQ(last_.evaluation, 1);
  EXPECT_EQ(last_.seconds, 2.0);
  EXPECT_EQ(last_.seconds_left, 18.0);
  Step(103.0, 0, RolloutPass::kRollout, 2, 10);
  EXPECT_EQ(last_.seconds_left, 12.0);
  for (int step = 3; step <= 10; ++step) Step(110.0, 0, RolloutPass::kRollout, step, 10);
  EXPECT_EQ(last_.seconds_left, 0.0);
}

TEST_F(TrackerTest, PassesThatFollowAreCounted) {
  tracker_.AddRecording(4);
  tracker_.Begin(EvaluationPurpose::kFit);
  for (int step = 1; step <= 4; ++step) Step(100.0 + step, 0, RolloutPass::kRollout, step, 4, /*passes_left=*/1);
  EXPECT_EQ(last_.seconds_left, 4.0);
  Step(105.0, 0, RolloutPass::kReverseSweep, 1, 4);
  EXPECT_EQ(last_.seconds_left, 3.0);
  EXPECT_EQ(last_.evaluation, 1);
}

// On two threads: the third recording has yet to begin, and will need a reverse sweep as the others do.
TEST_F(TrackerTest, RecordingsAddUp) {
  for (const int num_steps : {10, 20, 5}) tracker_.AddRecording(num_steps);
  tracker_.Begin(EvaluationPurpose::kFit);
  Step(101.0, 1, RolloutPass::kRollout, 1, 20, 1);
  EXPECT_EQ(last_.seconds_left, 39.0 + 20.0 + 10.0);
  Step(101.0, 0, RolloutPass::kRollout, 1, 10, 1);
  EXPECT_EQ(last_.seconds_left, 0.5 * (39.0 + 19.0 + 10.0));
  EXPECT_EQ(last_.num_recordings, 3);
  EXPECT_EQ(last_.recording, 0);
  // One that failed, or came from a journal, needs no more.
  tracker_.End(0);
  Step(103.0, 1, RolloutPass::kRollout, 2, 20, 1);
  EXPECT_EQ(last_.seconds_left, 38.0 + 10.0);
}

TEST_F(TrackerTest, EvaluationsWithoutStepsDoNotCount) {
  tracker_.AddRecording(10);
  for (int i = 0; i < 3; ++i) {
    tracker_.Begin(EvaluationPurpose::kFit);
    tracker_.End(0);
  }
  tracker_.Begin(EvaluationPurpose::kInterval);
  Step(101.0, 0, RolloutPass::kForwardSweep, 1, 10);
  EXPECT_EQ(last_.evaluation, 1);
  EXPECT_EQ(last_.purpose, EvaluationPurpose::kInterval);
}

class ProgressPrinterTest : public testing::Test {
 protected:
  void PrintIteration(int iteration, double seconds, ProgressPrinter* printer) {
    FitIteration row;
    row.iteration = iteration;
    row.seconds = now_ = seconds;
    row.cost = 2.5;
    row.values = Eigen::VectorXd::Constant(1, 0.25);
    row.rollouts = iteration + 1;
    printer->Print({"mu"}, row);
  }
  // A step at `time` of an evaluation that began at `start`.
  void PrintStep(double time, double start, ProgressPrinter* printer,
                 EvaluationPurpose purpose = EvaluationPurpose::kFit) {
    now_ = time;
    EvaluationProgress progress;
    progress.evaluation = 3;
    progress.purpose = purpose;
    progress.num_recordings = num_recordings_;
    progress.step = {RolloutPass::kReverseSweep, 120, 299, 0};
    progress.num_done = num_done_;
    progress.seconds = time - start;
    progress.seconds_left = 14.4;
    printer->Print(progress);
  }
  std::string Take() {
    std::string text = out_.str();
    out_.str("");
    return text;
  }

  int num_recordings_ = 1, num_done_ = 120;
  double now_ = 0.0;
  std::ostringstream out_;
  std::function<double()> clock_ = [this] { return now_; };
};

constexpr char kIteration0[] = "iteration 0  cost 2.5  mu 0.25  rollouts 1";
constexpr char kStep[] = "evaluation 3, reverse sweep: step 120 of 299, about 14 s left";

TEST_F(ProgressPrinterTest, LogHasALineOfStepsEveryTenSeconds) {
  ProgressPrinter printer(&out_, /*is_terminal=*/false, 50, clock_);
  PrintStep(9.9, 0.0, &printer);
  EXPECT_EQ(Take(), "");
  PrintStep(10.0, 0.0, &printer);
  EXPECT_EQ(Take(), kStep + std::string("\n"));
  PrintStep(15.0, 0.0, &printer);
  EXPECT_EQ(Take(), "");
  PrintIteration(0, 16.0, &printer);
  EXPECT_EQ(Take(), kIteration0 + std::string("\n"));
  PrintStep(25.0, 16.0, &printer);
  EXPECT_EQ(Take(), "");
  PrintStep(26.0, 16.0, &printer);
  EXPECT_EQ(Take(), kStep + std::string("\n"));
}

TEST_F(ProgressPrinterTest, TerminalRewritesALineBelowTheIteration) {
  ProgressPrinter printer(&out_, /*is_terminal=*/true, 50, clock_);
  PrintIteration(0, 5.0, &printer);
  EXPECT_EQ(Take(), "\r" + std::string(kIteration0) + "\033[K");
  PrintStep(5.9, 5.0, &printer);  // too quick to tell
  EXPECT_EQ(Take(), "");
  PrintStep(6.0, 5.0, &printer);
  EXPECT_EQ(Take(), "\n\r" + std::string(kStep) + "\033[K");
  PrintStep(6.1, 5.0, &printer);
  EXPECT_EQ(Take(), "");
  PrintStep(6.3, 5.0, &printer);
  EXPECT_EQ(Take(), "\r" + std::string(kStep) + "\033[K");
  printer.EndFit();
  EXPECT_EQ(Take(), "\r\033[K");
  printer.EndFit();
  EXPECT_EQ(Take(), "");
}

TEST_F(ProgressPrinterTest, StagesHaveLinesOfTheirOwn) {
  ProgressPrinter printer(&out_, /*is_terminal=*/true, 50, clock_);
  PrintIteration(0, 5.0, &printer);
  Take();
  FitPlan plan(2);
  plan[0].share = 0.125;
  plan[0].precision = Precision::kLoose;
  plan[0].state = StageState::kSkipped;
  plan[0].note = "its frames hold nothing to fit";
  plan[1].state = StageState::kRunning;
  plan[1].with_starts = true;
  plan[1].field_modes = 4;
  printer.PrintStage(plan, 0);
  EXPECT_EQ(Take(),
            "\na plan of 2 stages\nstage 1: first 12.5 % of the time, loosely: parameters: skipped, its frames hold "
            "nothing to fit\n");
  printer.PrintStage(plan, 1);
  EXPECT_EQ(Take(), "stage 2: all frames: parameters, starts, fields in 4 x 4 modes\n");
  plan[1].state = StageState::kDone;
  printer.PrintStage(plan, 1);
  EXPECT_EQ(Take(), "");
}

TEST_F(ProgressPrinterTest, TimeLeftOfTheFitGoesWithTheIterationsThatAreLeft) {
  ProgressPrinter printer(&out_, /*is_terminal=*/false, 50, clock_);
  PrintStep(1.0, 0.0, &printer);
  PrintIteration(0, 20.0, &printer);
  PrintStep(30.0, 20.0, &printer);
  PrintIteration(1, 60.0, &printer);
  PrintStep(70.0, 60.0, &printer);
  PrintIteration(2, 100.0, &printer);
  Take();
  PrintStep(110.0, 100.0, &printer);
  EXPECT_EQ(Take(), kStep + std::string("\n")) << "two iterations do not tell how long the others take";
  PrintIteration(3, 140.0, &printer);
  Take();
  PrintStep(150.0, 140.0, &printer);
  EXPECT_EQ(Take(), kStep + std::string("; fit: at most 47 iterations and 31 min more\n"));
  PrintStep(160.0, 140.0, &printer, EvaluationPurpose::kInterval);
  EXPECT_EQ(Take(), "intervals, " + std::string(kStep) + "\n");
  printer.EndFit();
  PrintStep(170.0, 140.0, &printer);
  EXPECT_EQ(Take(), kStep + std::string("\n"));
}

// Iterations of a journal take no time, and say nothing about those to come.
TEST_F(ProgressPrinterTest, ReplayedIterationsAreNotTimed) {
  ProgressPrinter printer(&out_, /*is_terminal=*/false, 20, clock_);
  for (int i = 0; i < 10; ++i) PrintIteration(i, 0.1 * i, &printer);
  Take();
  PrintStep(11.0, 0.9, &printer);
  EXPECT_EQ(Take(), kStep + std::string("\n"));
  for (int i = 10; i < 13; ++i) {
    PrintIteration(i, 0.9 + 720.0 * (i - 9), &printer);
    Take();
    PrintStep(20.0 + 720.0 * (i - 9), 0.9 + 720.0 * (i - 9), &printer);
  }
  EXPECT_EQ(Take(), kStep + std::string("; fit: at most 8 iterations and 96 min more\n"));
}

// The first steps set up what the others use.
TEST_F(ProgressPrinterTest, FirstStepsDoNotTellTheTimeLeft) {
  ProgressPrinter printer(&out_, /*is_terminal=*/false, 20, clock_);
  num_done_ = 9;
  PrintStep(10.0, 0.0, &printer);
  EXPECT_EQ(Take(), "evaluation 3, reverse sweep: step 120 of 299\n");
  num_done_ = 10;
  PrintStep(20.0, 0.0, &printer);
  EXPECT_EQ(Take(), kStep + std::string("\n"));
}

TEST_F(ProgressPrinterTest, LinesThatAreRewrittenFitTheTerminal) {
  int columns = 30;
  ProgressPrinter printer(&out_, /*is_terminal=*/true, 50, clock_, [&] { return columns; });
  PrintIteration(0, 5.0, &printer);
  EXPECT_EQ(Take(), "\r" + std::string(kIteration0).substr(0, 26) + "...\033[K");
  PrintStep(6.0, 5.0, &printer);
  EXPECT_EQ(Take(), "\r" + std::string(kIteration0) + "\033[K\n\r" + std::string(kStep).substr(0, 26) + "...\033[K")
      << "what stays is whole";
  columns = static_cast<int>(std::string(kIteration0).size()) + 1;
  PrintIteration(0, 7.0, &printer);
  EXPECT_EQ(Take(), "\r" + std::string(kIteration0) + "\033[K");
  columns = 0;  // not known
  PrintStep(8.0, 7.0, &printer);
  EXPECT_EQ(Take(), "\n\r" + std::string(kStep) + "\033[K");
}

TEST_F(ProgressPrinterTest, NamesTheRecordingOfSeveral) {
  num_recordings_ = 3;
  ProgressPrinter printer(&out_, /*is_terminal=*/false, 20, clock_);
  PrintStep(10.0, 0.0, &printer);
  EXPECT_EQ(Take(), "evaluation 3, recording 1 of 3, reverse sweep: step 120 of 299, about 14 s left\n");
}

class FitProgressTest : public testing::Test {
 protected:
  FitProgressTest() {
    MotionOptions options;
    options.true_values = {{"mu", 0.35}, {"k_stretch", 90.0}};
    motions_.push_back(MakeMotion(SphereScene(), options));
    options.true_values = {{"mu", 0.35}, {"k_stretch", 95.0}};
    motions_.push_back(MakeMotion(SphereScene(), options));
    options_.parameters = {"mu", "k_stretch"};
    options_.max_iterations = 5;
  }

  FitSummary Run(FitOptions options) const {
    FitProblem problem(motions_, options);
    return Fit(options, &problem);
  }

  std::vector<RecordedMotion> motions_;
  FitOptions options_;
};

TEST_F(FitProgressTest, ChangesNoBitOfTheResult) {
  for (const JacobianMethod jacobian : {JacobianMethod::kAdjoint, JacobianMethod::kNumeric}) {
    options_.jacobian = jacobian;
    FitOptions observed = options_;
    int num_steps = 0;
    observed.num_threads = 2;
    observed.on_progress = [&](const EvaluationProgress&) { ++num_steps; };
    const FitSummary a = Run(options_), b = Run(observed);
    EXPECT_GT(num_steps, 0);
    EXPECT_EQ(a.coordinates, b.coordinates);
    EXPECT_EQ(a.cost, b.cost);
    EXPECT_EQ(a.predicted, b.predicted);
    EXPECT_EQ(a.statistics.rollouts, b.statistics.rollouts);
    EXPECT_EQ(a.statistics.sweeps, b.statistics.sweeps);
  }
}

// Every pass is told of from its first step to its last, and an evaluation ends without passes left.
TEST_F(FitProgressTest, TellsEveryStepOfEveryPass) {
  for (const int num_threads : {1, 2}) {
    for (const JacobianMethod jacobian :
         {JacobianMethod::kAdjoint, JacobianMethod::kSensitivity, JacobianMethod::kNumeric}) {
      options_.jacobian = jacobian;
      options_.num_threads = num_threads;
      options_.estimate_uncertainty = false;
      std::map<int, PassStep> last;
      std::map<RolloutPass, int> num_passes;
      int last_evaluation = 0;
      options_.on_progress = [&](const EvaluationProgress& progress) {
        const PassStep before = last.count(progress.recording) > 0 ? last[progress.recording] : PassStep();
        if (progress.evaluation != last_evaluation) {
          EXPECT_EQ(progress.evaluation, last_evaluation + 1);
          EXPECT_EQ(before.passes_left, 0);
        }
        last_evaluation = progress.evaluation;
        EXPECT_EQ(progress.step.num_done, before.num_done < before.num_steps ? before.num_done + 1 : 1);
        EXPECT_EQ(progress.step.num_steps, 20);
        last[progress.recording] = progress.step;
        if (progress.step.num_done == 1) ++num_passes[progress.step.pass];
      };
      const FitSummary summary = Run(options_);
      for (const auto& [recording, step] : last) {
        EXPECT_EQ(step.num_done, step.num_steps);
        EXPECT_EQ(step.passes_left, 0);
      }
      EXPECT_EQ(last.size(), 2u);
      EXPECT_EQ(num_passes[RolloutPass::kRollout] + num_passes[RolloutPass::kForwardSweep],
                summary.statistics.rollouts);
      EXPECT_EQ(num_passes[RolloutPass::kReverseSweep] + num_passes[RolloutPass::kForwardSweep],
                summary.statistics.sweeps);
    }
  }
}

}  // namespace
}  // namespace clothid::progress_test
