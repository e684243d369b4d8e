// How rough a landscape is: numbers of one window of one setting.
//
// Let c(i, j) be the cost on the window's grid, even in the scales of its axes, with coordinates s, t in [-1, 1] along
// them, and R = max c - min c, the range. q is the full quadratic (1, s, t, s^2, s t, t^2) fitted to c by least
// squares, e = c - q. "rms" is the root of the mean square.
//
//   off_quadratic     = rms(e)/R
//   second_difference = rms({e(i-1, j) - 2 e(i, j) + e(i+1, j)}, {e(i, j-1) - 2 e(i, j) + e(i, j+1)})/R
//   gradient_gap      = max |w g(i, j) - w (c(i+1, j) - c(i-1, j))/(2 d)|/R   over cells and both axes
//
// with d the spacing of the cells, w the width of the window (both in the scale of that axis) and g the adjoint
// gradient along it. All three are 0 for a quadratic, but for rounding, free of units, and unchanged by a factor on the
// cost.
//
// The second differences are taken of e, as those of a smooth bowl are constants of the size R (2/cells)^2 that would
// hide roughness below. They see the roughness from cell to cell alone: a smooth landscape that is no quadratic may
// have a large off_quadratic, while its second differences are of second order in the spacing. Independent noise of
// standard deviation s in the cells gives sqrt(6) s/R.
//
// The gap of a smooth landscape is of second order in the spacing. A step of height J between two cells, which no
// gradient sees, gives about J (cells - 1)/(2 R). 1 means: a gradient that is off by the whole range over the window.
#ifndef CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_ROUGHNESS_H_
#define CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_ROUGHNESS_H_

#include <Eigen/Core>
#include <limits>
#include <string>

#include "identify/landscape/landscape.h"

namespace clothid {

// The cells of one window of one setting. A value that is not finite marks a cell that failed.
struct CostGrid {
  Eigen::MatrixXd costs;                   // [nx x ny]
  Eigen::MatrixXd gradient_x, gradient_y;  // [nx x ny], per unit of each axis' scale; both empty: there are none
  double width_x = 2.0, width_y = 2.0;     // of the window, in the scales of the axes; used with gradients alone
};

struct LandscapeRoughness {
  int cells = 0;         // all of the window
  int failed_cells = 0;  // left out of every number
  double range = std::numeric_limits<double>::quiet_NaN();
  double off_quadratic = std::numeric_limits<double>::quiet_NaN();
  double second_difference = std::numeric_limits<double>::quiet_NaN();
  double gradient_gap = std::numeric_limits<double>::quiet_NaN();  // NaN without gradients, too
  // Why a number that was asked for is NaN, one line; empty: none is. A grid that does not determine the quadratic, a
  // range of zero but for rounding, no three cells in a row.
  std::string reason;
};

// Of `setting` and `window`, numbers as in `landscape.plan`.
CostGrid GridOf(const Landscape& landscape, int setting, int window);

LandscapeRoughness RoughnessOf(const CostGrid& grid);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_ROUGHNESS_H_
