#include "datasets/formats/track_file.h"

#include <filesystem>
#include <system_error>
#include <vector>

#include "datasets/files/atomic_file.h"
#include "datasets/files/file_kind.h"
#include "datasets/formats/mesh_sequence.h"
#include "datasets/formats/npy_tracks.h"
#include "datasets/formats/pc2_file.h"
#include "datasets/formats/ply_file.h"
#include "datasets/formats/ros_csv.h"
#include "datasets/formats/track_checks.h"
#include "datasets/formats/tracks_csv.h"
#include "datasets/formats/trc_file.h"
#include "datasets/formats/vtp_file.h"
#include "sim/base/error.h"
#include "sim/base/frame_names.h"
#include "sim/base/text_file.h"
#include "sim/mesh/obj_file.h"

namespace clothid {
namespace {

namespace fs = std::filesystem;

constexpr char kKnown[] =
    "known are .npy, .csv, .trc, .pc2, .pvd (output only), sequences like cloth_####.obj or cloth_####.ply, and "
    "folders "
    "of .obj or .ply files";

PolygonMesh ReadObjTriangles(const std::string& path, const PolygonMesh* like) {
  const auto faces = [&] {
    return Eigen::Map<const Eigen::Matrix3Xi>(like->corners.data(), 3, static_cast<Eigen::Index>(like->sizes.size()));
  };
  const Mesh mesh = like != nullptr ? ReadObjLike(path, faces()) : ReadObj(path);
  PolygonMesh triangles = OfTriangles(mesh.faces);
  triangles.positions = mesh.rest_positions;
  return triangles;
}

MeshFormat ObjFormat() { return {".obj", &ReadObjTriangles, &ObjText}; }
MeshFormat PlyFormat() {
  return {".ply", [](const std::string& path, const PolygonMesh*) { return ReadPlyPolygons(path); }, &PlyBytes};
}

// In small letters.
std::string Extension(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c | 0x20) : c;
  return extension;
}

TrackFormat FormatOfCsv(const std::string& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return TrackFormat::kTidyCsv;
  if (IsRosCsv(path)) return TrackFormat::kRosCsv;
  const std::string kind = FileKind(ReadStart(path, kKindBytes));
  if (kind.empty() || kind == "text") return TrackFormat::kTidyCsv;
  throw Error(ErrorKind::kUsage, path + ": is " + kind + "; expected a header with t, id, x, y and z, or one of ROS " +
                                     "that starts with %time");
}

TrackFormat FormatOfFolder(const std::string& path) {
  std::error_code error;
  bool has_obj = false, has_ply = false;
  for (fs::directory_iterator entry(path, error); !error && entry != fs::directory_iterator(); entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    has_obj = has_obj || (name.front() != '.' && Extension(name) == ".obj");
    has_ply = has_ply || (name.front() != '.' && Extension(name) == ".ply");
  }
  if (error) throw Error(ErrorKind::kIo, path + ": cannot be read: " + error.message());
  if (has_obj && has_ply) {
    throw Error(ErrorKind::kUsage, path + ": holds .obj and .ply files; name one sequence, like cloth_####.obj");
  }
  if (!has_obj && !has_ply) throw Error(ErrorKind::kUsage, path + ": holds no sequence; " + kKnown);
  return has_obj ? TrackFormat::kObjSequence : TrackFormat::kPlySequence;
}

// Of a sequence that need not be there.
std::vector<std::string> FramePathsOrNone(const std::string& path, const std::string& extension) {
  try {
    return FramePaths(path, extension);
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::kBadData) throw;
    return {path};
  }
}

}  // namespace

TrackFormat OutputFormatOf(const std::string& path) {
  const std::string extension = Extension(path);
  if (extension == ".npy") return TrackFormat::kNpy;
  if (extension == ".csv") return TrackFormat::kTidyCsv;
  if (extension == ".trc") return TrackFormat::kTrc;
  if (extension == ".obj") return TrackFormat::kObjSequence;
  if (extension == ".ply") return TrackFormat::kPlySequence;
  if (extension == ".pc2") return TrackFormat::kPc2;
  if (extension == ".pvd" || extension == ".vtp") return TrackFormat::kVtp;
  throw Error(ErrorKind::kUsage, path + ": unknown format; " + kKnown);
}

TrackFormat FormatOf(const std::string& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return FormatOfFolder(path);
  const TrackFormat format = OutputFormatOf(path);
  return format == TrackFormat::kTidyCsv ? FormatOfCsv(path) : format;
}

bool HoldsFaces(TrackFormat format) {
  return format == TrackFormat::kNpy || format == TrackFormat::kObjSequence || format == TrackFormat::kPlySequence ||
         format == TrackFormat::kVtp;
}

std::vector<std::string> TrackPaths(const std::string& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) {
    return FramePaths(path, FormatOfFolder(path) == TrackFormat::kObjSequence ? ".obj" : ".ply");
  }
  const std::string extension = Extension(path);
  if (extension == ".npy") return NpyPaths(path);
  const bool is_sequence = (extension == ".obj" || extension == ".ply") && IsFramePattern(path);
  return is_sequence ? FramePathsOrNone(path, extension) : std::vector<std::string>{path};
}

PointTracks ReadTracks(const std::string& path, const Eigen::Matrix3Xi* like) {
  const auto read_meshes = [&](const MeshFormat& format) {
    if (like == nullptr) return ReadMeshSequence(path, format);
    const PolygonMesh triangles = OfTriangles(*like);
    return ReadMeshSequence(path, format, &triangles);
  };
  switch (FormatOf(path)) {
    case TrackFormat::kNpy:
      return ReadNpyTracks(path);
    case TrackFormat::kTidyCsv:
      return ReadTracksCsv(path);
    case TrackFormat::kRosCsv:
      return ReadRosGrid(path);
    case TrackFormat::kTrc:
      return ReadTrc(path);
    case TrackFormat::kObjSequence:
      return read_meshes(ObjFormat());
    case TrackFormat::kPlySequence:
      return read_meshes(PlyFormat());
    case TrackFormat::kPc2:
      return ReadPc2(path);
    case TrackFormat::kVtp:
      break;
  }
  throw Error(ErrorKind::kUsage, path + ": .pvd and .vtp files are written, never read");
}

void WriteTracks(const PointTracks& tracks, const std::string& path) {
  CheckTracks(tracks);
  switch (OutputFormatOf(path)) {
    case TrackFormat::kNpy:
      return WriteNpyTracks(tracks, path);
    case TrackFormat::kTidyCsv:
    case TrackFormat::kRosCsv:
      return WriteFileAtomically(path, {TracksCsvText(tracks)});
    case TrackFormat::kTrc:
      return WriteFileAtomically(path, {TrcText(tracks)});
    case TrackFormat::kObjSequence:
      RequireEveryPoint(tracks, "OBJ");
      return WriteMeshSequence(tracks, path, ObjFormat());
    case TrackFormat::kPlySequence:
      return WriteMeshSequence(tracks, path, PlyFormat());
    case TrackFormat::kPc2:
      return WriteFileAtomically(path, {Pc2Bytes(tracks)});
    case TrackFormat::kVtp:
      return WriteVtpSeries(tracks, path);
  }
}

}  // namespace clothid
