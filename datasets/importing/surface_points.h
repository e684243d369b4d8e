// Marks points of a recording that are not material: a camera saw the cloth there, but not which part of it.
//
// A depth image that is re-gridded in every frame gives such points: point i is the i-th of a grid that was laid over
// what was seen, and in the next frame other cloth is there. The border of that grid lies on the border of the cloth,
// its corners on the corners of the cloth, if the grid was laid so.
#ifndef CLOTHID_DATASETS_IMPORTING_SURFACE_POINTS_H_
#define CLOTHID_DATASETS_IMPORTING_SURFACE_POINTS_H_

#include <string>
#include <vector>

#include "datasets/motion/motion_tensors.h"

namespace clothid {

struct SurfaceMarks {
  bool as_surface = false;  // no point is material; without it the others must be false, too
  bool borders = false;     // but those on the border of the mesh lie on that of the cloth
  bool corners = false;     // and those at its corners are material
};

// `PointKind` of every point [P], as numbers. A corner is a node at which the border of the mesh at rest turns by more
// than 45 degrees. Throws `Error`, naming `source`: kBadData where no point lies on a border or at a corner that was
// asked for, or there are no points; kUsage where the marks do not fit each other.
std::vector<int> MarkSurfacePoints(const MotionTensors& tensors, const SurfaceMarks& marks, const std::string& source);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_IMPORTING_SURFACE_POINTS_H_
