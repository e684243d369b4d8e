// What a mesh file holds: vertices, and faces that may be polygons. Internal to datasets/.
#ifndef CLOTHID_DATASETS_FORMATS_POLYGON_MESH_H_
#define CLOTHID_DATASETS_FORMATS_POLYGON_MESH_H_

#include <Eigen/Core>
#include <string>
#include <vector>

namespace clothid {

struct PolygonMesh {
  Eigen::Matrix3Xd positions;  // [3 x N], NaN: not seen
  std::vector<int> corners;    // of all polygons, one after the other: vertices from 0 to N - 1
  std::vector<int> sizes;      // of each polygon, at least 3
  std::vector<int> lines;      // of each polygon in its file, from 1 on; empty: it has no lines
};

PolygonMesh OfTriangles(const Eigen::Matrix3Xi& faces);

// The triangles of the polygons of `mesh`, the file `path`, whose vertices are at `frames` [3N x T] (sim/geometry/
// polygon.h): as a polygon lies in the first frame that shows all its corners and can be cut. Without such a frame the
// fan about its first corner, where no frame shows it; else throws `Error` (kBadData), naming line or number of the
// face. Where the triangles `like` have its vertices it is cut into these.
Eigen::Matrix3Xi CutPolygons(const std::string& path, const PolygonMesh& mesh, const Eigen::MatrixXd& frames,
                             const PolygonMesh* like = nullptr);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FORMATS_POLYGON_MESH_H_
