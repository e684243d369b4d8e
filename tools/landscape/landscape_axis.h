// Axes of a landscape, and parts of them.
#ifndef CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_AXIS_H_
#define CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_AXIS_H_

#include <string>
#include <vector>

#include "identify/landscape/landscape.h"
#include "sim/scene/parameters.h"

namespace clothid {

// NAME=LOWER:UPPER:CELLS[:log], NAME a parameter of a scene with these obstacles and pieces. Throws `Error` (kUsage),
// naming `flag`, unless the name is known, LOWER < UPPER are values that the parameter can have, of a log axis above 0,
// and CELLS is at least 2.
LandscapeAxis ParseAxis(const std::string& text, const std::string& flag,
                        const std::vector<std::string>& obstacle_names,
                        const std::vector<std::string>& piece_names = {});

// The part of `whole` of `zoom` times its range in its own scale, of as many cells, with `center` in the middle or as
// near to it as `whole` ends. Throws `Error` (kUsage), naming `flag`, where its cells would fall on each other.
LandscapeAxis ZoomInto(const LandscapeAxis& whole, double center, double zoom, const std::string& flag);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_AXIS_H_
