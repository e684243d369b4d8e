// plan.html: a plan as a page by itself that any browser opens.
#ifndef CLOTHID_IDENTIFY_EXPERIMENT_PLAN_PAGE_H_
#define CLOTHID_IDENTIFY_EXPERIMENT_PLAN_PAGE_H_

#include <string>

#include "identify/experiment/experiment_plan.h"

namespace clothid {

// What plan.json says, as pictures: the motion that tells each parameter best, expected intervals as bars on a common
// axis, and every motion as a replay in the colours of the information per node, with that per frame below it. The page
// is like that of a fit (identify/report/report_page.h): one file below kMaxReportBytes, for which frames are left out,
// that asks no server for anything, in which names are shown and never run. The same bytes for the same plan.
std::string PlanHtml(const PlanOptions& options, const Plan& plan);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_EXPERIMENT_PLAN_PAGE_H_
