// From points of another program to a recording: tracks, a scene and a mesh become the tensors of a motion.bin.
#ifndef CLOTHID_DATASETS_IMPORTING_IMPORT_MOTION_H_
#define CLOTHID_DATASETS_IMPORTING_IMPORT_MOTION_H_

#include <optional>
#include <string>
#include <vector>

#include "datasets/formats/point_tracks.h"
#include "datasets/importing/force_file.h"
#include "datasets/importing/handle_tracks.h"
#include "datasets/importing/obstacle_tracks.h"
#include "datasets/importing/point_map.h"
#include "datasets/importing/surface_points.h"
#include "datasets/importing/track_edit.h"
#include "datasets/motion/motion_file.h"
#include "sim/mesh/mesh.h"

namespace clothid {

// How points are told where on the cloth they are.
enum class PointMapKind {
  kNodes,    // point p is node p
  kNearest,  // the nearest node of the rest shape
  kMarkers,  // the nearest place on a triangle of the rest shape
  kFile,     // as a file says
};

struct ImportOptions {
  TrackEdit edit;
  std::string scene_path;    // scene.json
  std::string scene_text;    // in place of what stands in scene_path, which names it and the folder of its files
  std::optional<Mesh> mesh;  // at rest, m; without it the scene's
  PointMapKind map = PointMapKind::kNodes;
  std::string map_path;               // kFile
  std::optional<PointMap> given_map;  // in place of `map`
  double map_distance = 0.0;          // m, of kNearest and kMarkers, see `PlacementOptions`
  SurfaceMarks surface;  // without `as_surface` what a recording says is kept, and imported points are material
  std::vector<int> handle_nodes;
  bool clamps_handles = false;            // the cloth leaves `handle_nodes` with a slope (sim/scene/attached_handles.h)
  std::optional<HandleFile> handle_file;  // paths of the handles; without it those of their measured points
  std::optional<HandlePath> handle_path;  // the same, from memory, on the clock of the recording; one of both
  std::vector<ObstacleFile> obstacle_files;  // paths of obstacles, in place of those that the scene gives them
  std::optional<ForceFile> force_file;       // what the handles bear; without it what a recording has
  double sigma = 0.0;                        // m, of every point; 0: not known
  std::string provenance;
};

// The recording, which `ReadMotion` has been tried on: whatever cannot be read back is an error here. Its scene text is
// self-contained (surfaces of obstacles inline, no file names); without `handle_nodes` the scene's own handles and
// their path are taken. Positions are kept as F64. Throws `Error`: kUsage for options that do not fit each other, kIo
// and kBadData for files, naming file, line or key.
MotionTensors ImportMotion(const PointTracks& tracks, const ImportOptions& options);

// The same for a recording: unit, frame of reference, clock and frames change; paths of handles go with the points,
// those of obstacles with the clock. Where a handle was measured as not seen, its path is filled in; a handle that is
// there all the time stays.
// Scene, mesh with map, handles, paths of obstacles, forces and sigma are replaced where `options` give them.
MotionTensors ConvertMotion(const MotionTensors& tensors, const std::string& name, const ImportOptions& options);

// The observed points of a recording, for export; with the faces of its mesh where point p is node p.
PointTracks ToTracks(const MotionTensors& tensors, const std::string& name);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_IMPORTING_IMPORT_MOTION_H_
