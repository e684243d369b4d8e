// One reason for a verdict, and who looks for which.
#ifndef CLOTHID_IDENTIFY_VERDICT_REASON_H_
#define CLOTHID_IDENTIFY_VERDICT_REASON_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "identify/base/join_words.h"
#include "identify/estimate/fit_summary.h"
#include "identify/verdict/fit_checks.h"
#include "identify/verdict/usability.h"
#include "sim/base/error.h"

namespace clothid {

struct Reason {
  Usability usability = Usability::kUsable;  // of what it speaks of
  ExitCode exit_code = kExitSuccess;
  std::vector<int> parameters;  // of which it speaks; empty: of the whole answer
  // For the overall line; empty where usable. Of the whole answer and with care a clause, "the error is of the size of
  // the cloth"; of parameters that are not to be used a few words, "at its bound".
  std::string brief;
  std::string line;  // with figures; empty: `brief` says it all
};

// Good to know; what asks for care; the same against the whole answer, which must not be used where it is grave; and
// parameters that must not be used, for nothing tells them.
Reason Remark(const std::string& line, std::vector<int> parameters = {});
Reason Careful(std::vector<int> parameters, const std::string& brief, const std::string& line);
Reason AgainstAll(bool is_grave, const std::string& brief, const std::string& line);
Reason NotTold(std::vector<int> parameters, const std::string& brief, const std::string& line);

// Each appends what it finds. What the model misses, and what a fit moved to make up for it.
void AddModelErrorReasons(const FitSummary& summary, const FitChecks& checks, std::vector<Reason>* reasons);
// The fit: its end, its error in every recording, its residuals, the points that its checks
// have met.
void AddFitReasons(const FitSummary& summary, const FitChecks& checks, std::vector<Reason>* reasons);
// Its parameters: what the recordings tell of each, and what their intervals are worth.
void AddParameterReasons(const FitSummary& summary, const FitChecks& checks, std::vector<Reason>* reasons);
// Parameters farther beyond what was measured of any cloth than one can be (sim/fabric/fabric.h), and the units and
// sizes that would explain it.
void AddMeasuredReasons(const FitSummary& summary, std::vector<Reason>* reasons);
// Parameters whose interval a step of 1 % leads out of (identify/estimate/interval_check.h).
void AddDentReasons(const FitSummary& summary, const FitChecks& checks, std::vector<Reason>* reasons);
// What parameters and knots owe to what was believed of them, and where recordings contradict it.
void AddPriorReasons(const FitSummary& summary, std::vector<Reason>* reasons);
// What time step and mesh do to the estimates.
void AddDiscretizationReasons(const FitSummary& summary, const FitChecks& checks, std::vector<Reason>* reasons);
// What repetitions tell of the parameters that they share.
void AddRepetitionReasons(const FitSummary& summary, const FitChecks& checks, std::vector<Reason>* reasons);
// What was looked at besides: other starts, profiles, held-out measurements.
void AddCheckReasons(const FitSummary& summary, const FitChecks& checks, std::vector<Reason>* reasons);

// "mu 0.3, k_stretch 50" of the values of all that are not frozen; "mu and drag" of names.
std::string ValuesText(const FitSummary& summary, const Eigen::VectorXd& values);
std::string NamesText(const FitSummary& summary, const std::vector<int>& parameters);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_VERDICT_REASON_H_
