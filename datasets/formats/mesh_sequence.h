// Point tracks as a sequence of mesh files, OBJ or PLY, one per frame. Internal to datasets/.
#ifndef CLOTHID_DATASETS_FORMATS_MESH_SEQUENCE_H_
#define CLOTHID_DATASETS_FORMATS_MESH_SEQUENCE_H_

#include <Eigen/Core>
#include <string>

#include "datasets/formats/point_tracks.h"
#include "datasets/formats/polygon_mesh.h"

namespace clothid {

struct MeshFormat {
  std::string extension;  // ".obj"
  // Throws `Error`. A format that cuts polygons itself cuts them into the triangles `like` (may be null).
  PolygonMesh (*read)(const std::string& path, const PolygonMesh* like);
  // The text or bytes of a file.
  std::string (*bytes)(const Eigen::Ref<const Eigen::Matrix3Xd>& positions, const Eigen::Matrix3Xi& faces);
};

// The OBJ text with every digit; `positions` [3 x N] must be finite.
std::string ObjText(const Eigen::Ref<const Eigen::Matrix3Xd>& positions, const Eigen::Matrix3Xi& faces);

// Reads the files that `path` stands for (FramePaths of sim/base/frame_names.h). Faces are those of the first,
// and the others must have as many vertices, and the same faces where they have any. Polygons are cut as CutPolygons
// does. The files know no times, but their numbers (FrameNumbers). Throws `Error`, naming the file.
PointTracks ReadMeshSequence(const std::string& path, const MeshFormat& format, const PolygonMesh* like = nullptr);

// Writes a frame to the file that the pattern `path` ("cloth_####.obj") has for its number; without '#', the only frame
// to `path`. All or none (datasets/files/file_group.h). Throws `Error`: kUsage where there is no '#' for several
// frames, or a file matches the pattern that would not be replaced, since it would be read as a frame; kIo where a file
// cannot be written.
void WriteMeshSequence(const PointTracks& tracks, const std::string& path, const MeshFormat& format);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FORMATS_MESH_SEQUENCE_H_
