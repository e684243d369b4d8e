// Meshes and point clouds in PLY files. The format: datasets/formats/ply_header.h
#ifndef CLOTHID_DATASETS_FORMATS_PLY_FILE_H_
#define CLOTHID_DATASETS_FORMATS_PLY_FILE_H_

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "datasets/formats/polygon_mesh.h"
#include "sim/mesh/mesh.h"

namespace clothid {

inline constexpr std::uint64_t kMaxPlyBytes = std::uint64_t{1} << 29;

// Reads x, y and z of the element `vertex`, of any type of number (NaN: not seen), and the list `vertex_indices` or
// `vertex_index` of the element `face`, where it is there. Everything else is read over.
// Ascii, binary little-endian and binary big-endian. Throws `Error`: kIo where the file cannot be read, else kBadData
// naming the file and the line, element or byte, also for a file of more than kMaxPlyBytes.
PolygonMesh ReadPlyPolygons(const std::string& path);
// The same with the polygons cut into triangles as they lie there, see CutPolygons.
Mesh ReadPly(const std::string& path);
// The vertices alone, whatever the faces are; infinite coordinates are as NaN.
Eigen::Matrix3Xd ReadPlyPoints(const std::string& path);

// The bytes of a binary little-endian file with the positions [3 x N] as double and, where there are any, the triangles
// [3 x F] as lists of int.
std::string PlyBytes(const Eigen::Ref<const Eigen::Matrix3Xd>& positions, const Eigen::Matrix3Xi& faces);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FORMATS_PLY_FILE_H_
