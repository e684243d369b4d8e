// Knots of the wind's profile among parameters, "wind.y.3" or, of one recording, "wind.y.3@2", and short lists of them.
#ifndef CLOTHID_IDENTIFY_BASE_KNOT_NAMES_H_
#define CLOTHID_IDENTIFY_BASE_KNOT_NAMES_H_

#include <optional>
#include <string>
#include <vector>

#include "sim/scene/parameters.h"

namespace clothid {

// Of a name that a file or a flag has; a block knows what it is of. Nothing for any other name.
std::optional<ParameterId> FindKnot(const std::string& name);

// `names` with runs of successive knots, of three or more, as one: "wind.y.3 to wind.y.7".
std::vector<std::string> WithKnotRuns(const std::vector<std::string>& names);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_BASE_KNOT_NAMES_H_
