// motion.bin: a safetensors container (8-byte little-endian header length, JSON header, raw little-endian tensors).
//
// Tensors: `positions` F32|F64 [T, P, 3] m, NaN = missing; `times` F64 [T] s, strictly increasing; `rest_positions` F64
// [N, 3]; `faces` I32 [F, 3]; optional `corner_rest` F64 [F, 3, 2] m, `folds` I32 [E, 2], and `link_nodes` I32 [L, 3]
// (p, q_0, q_1) with `link_values` F64 [L, 3] (s, k_s, T), all as in sim/mesh/mesh.h; optional `node_index` I32 [P], or
// `face_index` I32 [P] + `barycentric` F64 [P, 3]; optional `point_kind` I32 [P], 0 material, 1 of the surface, 2 of
// its border (`PointKind`); without it all are material; optional `handle_index` I32 [H] + `handle_positions` F64 [T,
// H, 3], or [K, H, 3] with `handle_times` F64 [K] s, strictly increasing: what moves the handles is often known at
// other times than the cloth is seen; optional `sigma` F64 [P] m; optional `cloud_positions` F32|F64 [M, 3] m with
// `cloud_offsets` I32 [T + 1], unordered points of the surface, of which frame i has the rows offsets[i] .. offsets[i +
// 1] - 1, and `cloud_sigma` F64 [1] m. With them P may be 0. `sequence.NAME` F64 [S, V, 3] m: the vertices of the
// obstacle NAME, which deforms, at the times that the scene gives of its `sequence`.
// `__metadata__` (strings): `format` = "clothid.motion", `version` = "1", `scene` = JSON text, `provenance`, `sha256`
// of the tensor bytes, and `header_sha256` (optional on reading) of the header with that field's value blank: the
// SHA-256 of all header bytes after the length, padding included, in which the 64 digits of that value are replaced by
// 64 blanks. Digests are lower-case hexadecimal. Other tensors, other metadata and overlaps or holes between the
// tensors are errors.
#ifndef CLOTHID_DATASETS_MOTION_MOTION_FILE_H_
#define CLOTHID_DATASETS_MOTION_MOTION_FILE_H_

#include <functional>
#include <string>

#include "datasets/motion/motion_tensors.h"
#include "datasets/motion/recorded_motion.h"

namespace clothid {

struct ReadMotionOptions {
  std::string scene_path;  // a scene.json to use instead of the embedded text; empty: the embedded one
  // Where the scene gives no start: any but `kScene`. All but `kFirstFrame` need no sigma but are better with it; an
  // unknown start comes with one that is estimated where none is known.
  StartSource start = StartSource::kFirstFrame;
  // What sigma the recording has: `kRecorded`, its own, if any; `kEstimated` where it has none; `kGiven`: `sigma` of
  // all points in any case.
  SigmaSource sigma_source = SigmaSource::kRecorded;
  double sigma = 0.0;          // m
  bool smooth_handles = true;  // measured handle paths through `SmoothPath`
  // What to read in place of the scene's text; may be empty.
  std::function<std::string(const std::string& scene_text)> change_scene;
};

// Reads, checks every bound before anything is allocated, verifies the checksums, and interprets the scene. Throws
// `Error`: kIo where the file cannot be opened, else kBadData, naming file, tensor or key and what was expected.
RecordedMotion ReadMotion(const std::string& path, const ReadMotionOptions& options = {});

// What `ReadMotion` makes of the tensors of a file: the recording and its scene. `path` names it in errors, and
// relative file names in the embedded scene start at its folder. The tensors must be those that `WriteMotion` accepts.
RecordedMotion InterpretMotion(MotionTensors tensors, const std::string& path, const ReadMotionOptions& options = {});

// Only the container, for `motion info` and converters. Same errors.
MotionTensors ReadMotionTensors(const std::string& path);

// Writes to a temporary name beside `path` and renames it, so that nothing half-written is left behind. Throws `Error`
// (kIo).
void WriteMotion(const MotionTensors& tensors, const std::string& path);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_MOTION_MOTION_FILE_H_
