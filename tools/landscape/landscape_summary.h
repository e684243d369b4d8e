// What a scan found, in numbers: per setting and window the minimum, how rough the cost is and how often contacts
// change. A function of the cells alone: the same for every number of threads and shards.
#ifndef CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_SUMMARY_H_
#define CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_SUMMARY_H_

#include <limits>
#include <string>
#include <vector>

#include "identify/landscape/landscape.h"
#include "tools/landscape/landscape_roughness.h"

namespace clothid {

// Means over the rollouts that did not fail; NaN where there is none.
struct ContactMeans {
  double contact_changes = std::numeric_limits<double>::quiet_NaN();  // per rollout, as all that follow
  double nodes_joined = std::numeric_limits<double>::quiet_NaN();
  double nodes_left = std::numeric_limits<double>::quiet_NaN();
  double branch_switches = std::numeric_limits<double>::quiet_NaN();
  double obstacle_switches = std::numeric_limits<double>::quiet_NaN();
  double contacts_per_step = std::numeric_limits<double>::quiet_NaN();  // nodes in contact at the end of a solve
};

// One window of one setting.
struct WindowSummary {
  // The lowest cost of any cell, the first one of several, and the values of the parameters there; NaN where every cell
  // failed.
  double minimum = std::numeric_limits<double>::quiet_NaN();
  double x = std::numeric_limits<double>::quiet_NaN();
  double y = std::numeric_limits<double>::quiet_NaN();
  LandscapeRoughness roughness;
  ContactMeans contact;
  // Over all rollouts, the failed ones included.
  long long failed_steps = 0;
  long long substeps = 0;
};

struct LandscapeSummary {
  LandscapePlan plan;
  std::vector<WindowSummary> windows;  // [settings * windows], the windows of the first setting first

  const WindowSummary& Of(int setting, int window) const {
    return windows[static_cast<std::size_t>(setting) * plan.windows.size() + static_cast<std::size_t>(window)];
  }
};

LandscapeSummary Summarize(const Landscape& landscape);

// The text of summary.json, schema "clothid.landscape_summary/1". Numbers are written so that they read back exactly,
// NaN as null.
std::string SummaryJson(const LandscapeSummary& summary);

// A table, one line per setting and window, and under it why numbers are missing and what the columns are. "-" where
// there is no number.
std::string SummaryTable(const LandscapeSummary& summary);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_SUMMARY_H_
