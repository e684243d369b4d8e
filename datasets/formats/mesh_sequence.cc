#include "datasets/formats/mesh_sequence.h"

#include <algorithm>
#include <filesystem>
#include <vector>

#include "datasets/files/atomic_file.h"
#include "datasets/files/file_group.h"
#include "datasets/formats/track_checks.h"
#include "sim/base/error.h"
#include "sim/base/frame_names.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

namespace fs = std::filesystem;

// The files that match the pattern already and would stay.
void CheckForOtherFrames(const std::string& pattern, const std::vector<std::string>& names,
                         const std::string& extension) {
  std::vector<std::string> present;
  try {
    present = FramePaths(pattern, extension);
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::kUsage) return;  // none
    throw;
  }
  for (const std::string& path : present) {
    if (std::find(names.begin(), names.end(), fs::path(path).filename().string()) != names.end()) continue;
    throw Error(ErrorKind::kUsage, pattern + ": " + path +
                                       " would count as a frame and would not be replaced; remove it, or choose "
                                       "another name");
  }
}

}  // namespace

std::string ObjText(const Eigen::Ref<const Eigen::Matrix3Xd>& positions, const Eigen::Matrix3Xi& faces) {
  std::string text;
  for (const auto& position : positions.colwise()) {
    text +=
        "v " + ShortestText(position.x()) + ' ' + ShortestText(position.y()) + ' ' + ShortestText(position.z()) + '\n';
  }
  for (const auto& face : faces.colwise()) {
    text += 'f';
    for (const int index : face) text += ' ' + std::to_string(index + 1);
    text += '\n';
  }
  return text;
}

PointTracks ReadMeshSequence(const std::string& path, const MeshFormat& format, const PolygonMesh* like) {
  const std::vector<std::string> paths = FramePaths(path, format.extension);
  PointTracks tracks;
  tracks.name = path;
  tracks.frame_numbers = FrameNumbers(paths);
  PolygonMesh first;
  for (std::size_t frame = 0; frame < paths.size(); ++frame) {
    PolygonMesh mesh = format.read(paths[frame], frame == 0 ? like : &first);
    if (frame == 0) {
      CheckTrackSize(paths[0], static_cast<std::uint64_t>(mesh.positions.cols()), paths.size());
      tracks.positions.resize(mesh.positions.size(), static_cast<Eigen::Index>(paths.size()));
      first = mesh;
    }
    if (mesh.positions.cols() != tracks.num_points()) {
      throw Error(ErrorKind::kBadData, paths[frame] + ": has " + std::to_string(mesh.positions.cols()) +
                                           " vertices; expected " + std::to_string(tracks.num_points()) + " as in " +
                                           paths[0]);
    }
    const bool has_faces = !mesh.sizes.empty() && !first.sizes.empty();
    if (has_faces && (mesh.sizes != first.sizes || mesh.corners != first.corners)) {
      throw Error(ErrorKind::kBadData, paths[frame] + ": has other faces than " + paths[0] +
                                           "; expected the same points in every file, in the same order");
    }
    tracks.positions.col(static_cast<Eigen::Index>(frame)) = mesh.positions.reshaped();
  }
  tracks.faces = CutPolygons(paths[0], first, tracks.positions, like);
  CheckTracks(tracks);
  return tracks;
}

void WriteMeshSequence(const PointTracks& tracks, const std::string& path, const MeshFormat& format) {
  const auto bytes = [&](int frame) {
    return format.bytes(tracks.positions.col(frame).reshaped(3, tracks.num_points()), tracks.faces);
  };
  if (!IsFramePattern(path)) {
    if (tracks.num_frames() == 1) return WriteFileAtomically(path, {bytes(0)});
    const std::string example = fs::path(path).replace_extension().string() + "_####" + format.extension;
    throw Error(ErrorKind::kUsage, path + ": expected '#' for the number of the frame, like " + example);
  }
  std::vector<std::string> names;
  for (int frame = 0; frame < tracks.num_frames(); ++frame) {
    const bool is_numbered = !tracks.frame_numbers.empty();
    names.push_back(FrameName(path, is_numbered ? tracks.frame_numbers[static_cast<std::size_t>(frame)] : frame));
  }
  FileGroup group(path);
  CheckForOtherFrames(path, names, format.extension);
  for (int frame = 0; frame < tracks.num_frames(); ++frame) {
    group.Write(names[static_cast<std::size_t>(frame)], bytes(frame));
  }
  group.Commit();
}

}  // namespace clothid
