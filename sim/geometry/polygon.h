// Polygons in space, cut into triangles.
#ifndef CLOTHID_SIM_GEOMETRY_POLYGON_H_
#define CLOTHID_SIM_GEOMETRY_POLYGON_H_

#include <Eigen/Core>
#include <array>
#include <vector>

namespace clothid {

// n - 2 triangles, by their corners in the order of the polygon, of one with the corners [3 x n], n >= 3. It may be
// bent a little: it is seen along its mean normal (Newell's, the sum of the cross products of successive corners).
// Where the fan about the first corner turns no triangle over, it is that fan; else ears are cut off. Empty where there
// is neither: the polygon crosses or touches itself, or has no area. A triangle is what it is.
std::vector<std::array<int, 3>> TrianglesOfPolygon(const Eigen::Matrix3Xd& corners);

// The same triangles as those of `faces` [3 x F] from `first` on, for a polygon with the vertices `corners`: of a
// surface that deforms. Empty where these have other vertices.
std::vector<std::array<int, 3>> TrianglesLike(const Eigen::Matrix3Xi& faces, Eigen::Index first,
                                              const std::vector<int>& corners);

}  // namespace clothid

#endif  // CLOTHID_SIM_GEOMETRY_POLYGON_H_
