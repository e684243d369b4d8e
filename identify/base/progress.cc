#include "identify/base/progress.h"

#include <cmath>
#include <cstddef>
#include <iomanip>
#include <sstream>
#include <utility>

#include "identify/base/knot_names.h"
#include "sim/base/phase_seconds.h"

namespace clothid {
namespace {

constexpr char kEraseToEnd[] = "\033[K";
// Of a fit of more parameters an iteration does not show the knots of the wind.
constexpr std::size_t kMostNames = 12;
// How many steps of an evaluation, and iterations of a fit, tell how long the others take. The first ones set up what
// is made once, or start far from the solution.
constexpr int kFewestSteps = 10, kFewestIterations = 3;
// s. An evaluation that takes less does not show its steps; between two such lines.
constexpr double kTerminalPatience = 1.0, kTerminalInterval = 0.2, kPlainInterval = 10.0;

// "14 s", "33 min" or "2 h 10 min": no estimate is known better.
std::string Duration(double seconds) {
  constexpr double kMostSeconds = 100.0, kMostMinutes = 100.0;
  if (seconds < kMostSeconds) return std::to_string(std::lround(seconds)) + " s";
  const long minutes = std::lround(seconds / 60.0);
  if (seconds / 60.0 < kMostMinutes) return std::to_string(minutes) + " min";
  return std::to_string(minutes / 60) + " h " + std::to_string(minutes % 60) + " min";
}

std::string PassName(RolloutPass pass) {
  constexpr const char* kNames[] = {"rollout", "forward sweep", "reverse sweep"};
  return kNames[static_cast<int>(pass)];
}

std::string StepLine(const EvaluationProgress& progress) {
  std::ostringstream line;
  if (progress.purpose == EvaluationPurpose::kInterval) line << "intervals, ";
  line << "evaluation " << progress.evaluation;
  if (progress.num_recordings > 1) {
    line << ", recording " << progress.recording + 1 << " of " << progress.num_recordings;
  }
  line << ", " << PassName(progress.step.pass) << ": step " << progress.step.num_done << " of "
       << progress.step.num_steps;
  if (progress.num_done >= kFewestSteps) line << ", about " << Duration(progress.seconds_left) << " left";
  return line.str();
}

}  // namespace

ProgressPrinter::ProgressPrinter(std::ostream* out, bool is_terminal, int max_iterations, std::function<double()> clock,
                                 std::function<int()> columns)
    : out_(out),
      is_terminal_(is_terminal),
      max_iterations_(max_iterations),
      clock_(clock ? std::move(clock) : SteadySeconds),
      columns_(std::move(columns)),
      last_output_(clock_()) {}

ProgressPrinter::~ProgressPrinter() { EndLine(); }

// A step is not worth a line that stays.
void ProgressPrinter::EndLine() {
  if (open_line_ == OpenLine::kIteration) {
    if (Cut(open_text_) != open_text_) *out_ << "\r" << open_text_ << kEraseToEnd;
    *out_ << "\n" << std::flush;
  }
  if (open_line_ == OpenLine::kStep) *out_ << "\r" << kEraseToEnd << std::flush;
  open_line_ = OpenLine::kNone;
}

std::string ProgressPrinter::Cut(const std::string& line) const {
  const std::string end = "...";
  // A character in the last column may start the next row.
  const int room = (columns_ ? columns_() : 0) - 1 - static_cast<int>(end.size());
  if (room <= 0 || line.size() < static_cast<std::size_t>(room) + end.size() + 1) return line;
  return line.substr(0, static_cast<std::size_t>(room)) + end;
}

void ProgressPrinter::Rewrite(const std::string& line, OpenLine what) {
  last_output_ = clock_();
  if (!is_terminal_) {
    *out_ << line << "\n" << std::flush;
    return;
  }
  if (what == OpenLine::kStep && open_line_ == OpenLine::kIteration) EndLine();
  *out_ << "\r" << Cut(line) << kEraseToEnd << std::flush;
  open_line_ = what;
  open_text_ = line;
}

void ProgressPrinter::PrintStart(int start, int num_starts) {
  EndFit();
  *out_ << "start " << start + 1 << " of " << num_starts << "\n" << std::flush;
}

void ProgressPrinter::PrintStage(const FitPlan& plan, int stage) {
  const FitStage& own = plan[static_cast<std::size_t>(stage)];
  if (own.state == StageState::kDone) return;
  EndLine();
  if (stage == 0) *out_ << "a plan of " << plan.size() << (plan.size() == 1 ? " stage\n" : " stages\n");
  *out_ << "stage " << stage + 1 << ": " << own.Words();
  if (own.state == StageState::kSkipped) *out_ << ": skipped, " << own.note;
  *out_ << "\n" << std::flush;
}

void ProgressPrinter::EndFit() {
  EndLine();
  has_stepped_ = false;
  num_timed_ = iterations_left_ = 0;
  timed_seconds_ = last_seconds_ = 0.0;
}

void ProgressPrinter::Print(const std::vector<std::string>& names, const FitIteration& iteration) {
  // The first is the start, not a step of the optimiser.
  if (has_stepped_ && iteration.iteration > 0) {
    ++num_timed_;
    timed_seconds_ += iteration.seconds - last_seconds_;
  }
  has_stepped_ = false;
  last_seconds_ = iteration.seconds;
  iterations_left_ = max_iterations_ - iteration.iteration;
  std::ostringstream line;
  line << "iteration " << iteration.iteration << "  cost " << std::setprecision(6) << iteration.cost;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names.size() > kMostNames && FindKnot(names[i])) continue;
    line << "  " << names[i] << " " << iteration.values[i];
  }
  line << "  rollouts " << iteration.rollouts;
  if (is_terminal_ && num_timed_ >= kFewestIterations) {
    const double seconds_each = timed_seconds_ / num_timed_;
    line << std::setprecision(2) << "  " << seconds_each << " s/iteration, at most "
         << Duration(seconds_each * iterations_left_) << " left";
  }
  Rewrite(line.str(), OpenLine::kIteration);
}

bool ProgressPrinter::IsDue(const EvaluationProgress& progress) const {
  const double since_last = clock_() - last_output_;
  if (!is_terminal_) return since_last >= kPlainInterval;
  return progress.seconds >= kTerminalPatience && since_last >= kTerminalInterval;
}

// Nothing before enough iterations are timed.
std::string ProgressPrinter::FitLeft() const {
  if (num_timed_ < kFewestIterations || iterations_left_ <= 0) return "";
  return "; fit: at most " + std::to_string(iterations_left_) + " iterations and " +
         Duration(timed_seconds_ / num_timed_ * iterations_left_) + " more";
}

void ProgressPrinter::Print(const EvaluationProgress& progress) {
  has_stepped_ = true;
  if (!IsDue(progress)) return;
  Rewrite(StepLine(progress) + (progress.purpose == EvaluationPurpose::kFit ? FitLeft() : ""), OpenLine::kStep);
}

}  // namespace clothid
