// What repetitions tell, for people.
#ifndef CLOTHID_IDENTIFY_REPORT_REPETITION_REPORT_H_
#define CLOTHID_IDENTIFY_REPORT_REPETITION_REPORT_H_

#include <nlohmann/json.hpp>
#include <string>

#include "identify/repetition/repetitions.h"
#include "identify/verdict/verdict.h"

namespace clothid {

// Rows of the table: of every parameter each estimate with its interval, the mean, the next specimen, the scatter.
std::string RepetitionRows(const Repetitions& repetitions);

// What stands above the forest plot of each parameter, by its name.
nlohmann::ordered_json RepetitionLinesJson(const Repetitions& repetitions);

// The text of report.html for finished fits that were judged together (`FitChecks::repetitions`): verdict, a forest
// plot for each parameter, provenance. One file like that of a fit (identify/report/report_page.h); whatever names hold
// is shown, never run.
std::string PooledHtml(const FitSummary& summary, const FitChecks& checks, const Verdict& verdict);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPORT_REPETITION_REPORT_H_
