// What a fit means: whether its answer can be used, in words, and as an exit code.
//
// A verdict is made of reasons. Each speaks of some parameters or of the whole answer, says whether they can be used
// all the same, and names figures. The overall line is the conclusion from all of them; the reasons follow in the order
// of their weight, first what forbids the whole answer, then what forbids single parameters, then what asks for care,
// then what is good to know. Limits and their derivations stand with the reasons, in identify/verdict/*_reasons.cc, and
// in identify/README.md.
#ifndef CLOTHID_IDENTIFY_VERDICT_VERDICT_H_
#define CLOTHID_IDENTIFY_VERDICT_VERDICT_H_

#include <string>
#include <vector>

#include "identify/estimate/fit_summary.h"
#include "identify/verdict/fit_checks.h"
#include "identify/verdict/told.h"
#include "identify/verdict/usability.h"
#include "sim/base/error.h"

namespace clothid {

struct Verdict {
  Usability overall = Usability::kDoNotUse;
  std::vector<Usability> parameters;  // [p]; of a frozen one kUsable
  std::string line;                   // "usable: ..", "usable with care: ..", "do not use mu (..)", "do not use: .."
  std::vector<std::string> reasons;   // one line each, the gravest first
  ExitCode exit_code = kExitNotConverged;

  std::vector<std::string> Lines() const;  // the overall line and the reasons
};

Verdict Judge(const FitSummary& summary, const FitChecks& checks);

// That of the verdict. Where several apply: 130, 3, 6, 4, 5 in that order.
ExitCode FitExitCode(const FitSummary& summary, const FitChecks& checks);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_VERDICT_VERDICT_H_
