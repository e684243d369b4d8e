// Which material point of the mesh a measured point is.
#ifndef CLOTHID_DATASETS_IMPORTING_POINT_MAP_H_
#define CLOTHID_DATASETS_IMPORTING_POINT_MAP_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "datasets/formats/point_tracks.h"
#include "sim/mesh/mesh.h"

namespace clothid {

inline constexpr std::uint64_t kMaxPointMapBytes = std::uint64_t{1} << 28;

// Either nodes or places on triangles; neither: point p is node p.
struct PointMap {
  std::vector<int> points;       // [Q] the points of the file that are used, ascending
  std::vector<int> node_index;   // [Q] or empty
  std::vector<int> face_index;   // [Q] or empty
  Eigen::Matrix3Xd barycentric;  // [3 x Q] or empty
};

// Where points are placed by their distance to the rest shape.
struct PlacementOptions {
  bool on_triangles = false;  // the nearest place of a triangle; else the nearest node
  double max_distance = 0.0;  // m: a point farther off is an error; 0: half the median edge at rest
};

// Point p is node p. Throws `Error` (kBadData) unless there are as many points as nodes.
PointMap MapToNodes(const PointTracks& tracks, const Mesh& mesh);

// Places the points of one frame: the first in which every point is seen, or else the first of those with most points
// seen. The rest shape has to lie near them, turned as they are; it is then moved as a rigid body until points and
// their places are closest (iterated closest points, Besl and McKay 1992). Throws `Error` (kBadData), naming the point,
// where one is not seen in that frame or too far off, or where two have the same node.
PointMap MapToNearest(const PointTracks& tracks, const Mesh& mesh, const PlacementOptions& options);

// Reads a table (sim/base/table.h) with the columns `id,node` or `id,face,b0,b1,b2`: a row per point, by its label, or
// its number where the file has no labels. Points that are not listed are left out. Throws `Error`: kIo, or kBadData
// naming file and line.
PointMap ReadPointMap(const std::string& path, const PointTracks& tracks, const Mesh& mesh);

// The mesh of a grid of n[0] x n[1] points in the order in which a file lists them: the first axis runs fastest, point
// (i, j) has index i + n[0] j, or with `second_axis_first` the second, index j + n[1] i. It lies in the plane z = 0,
// its normal along z, point (i, j) at (i size[0]/(n[0] - 1), j size[1]/(n[1] - 1), 0).
Mesh MakePointGrid(const std::array<int, 2>& nodes, const std::array<double, 2>& size, bool second_axis_first);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_IMPORTING_POINT_MAP_H_
