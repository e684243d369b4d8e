// One cell as a line of text, exactly.
#ifndef CLOTHID_IDENTIFY_LANDSCAPE_LANDSCAPE_ROW_H_
#define CLOTHID_IDENTIFY_LANDSCAPE_LANDSCAPE_ROW_H_

#include <string>
#include <string_view>

#include "identify/landscape/landscape.h"

namespace clothid {

// The columns: x,y,setting,contact,cost,contact_changes,contacts,failed_steps,zoom,nodes_joined,nodes_left,
// branch_switches,obstacle_switches,pair_changes,steps,substeps[,gradient_x,gradient_y],failure.
std::string RowHeader(const LandscapePlan& plan);

// Without an end of line. Numbers are the shortest text that reads back exactly. A cell that failed has no cost and no
// gradient but a reason, in quotes, in the last column.
std::string CellRow(const LandscapePlan& plan, int cell, const LandscapeCell& result);

// The cell of a row; its counts are those that have a column. Throws `Error` (kBadData), led by `source`, for a row
// that is not of this cell, or damaged.
LandscapeCell ParseRow(const LandscapePlan& plan, int cell, std::string_view row, const std::string& source);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_LANDSCAPE_LANDSCAPE_ROW_H_
