#include <gflags/gflags.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/files/atomic_file.h"
#include "datasets/files/overwrite.h"
#include "datasets/formats/table_note.h"
#include "datasets/formats/track_file.h"
#include "datasets/importing/import_motion.h"
#include "datasets/importing/transform_file.h"
#include "datasets/motion/motion_file.h"
#include "datasets/motion/motion_name.h"
#include "datasets/synthetic/synthetic.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/mesh/obj_file.h"
#include "sim/scene/scene_json.h"
#include "tools/motion/force_flags.h"
#include "tools/motion/motion_commands.h"
#include "tools/motion/obstacle_flags.h"
#include "tools/motion/track_flags.h"

DEFINE_string(scene, "", "convert: scene.json of the recording");
DEFINE_string(faces, "", "convert: OBJ file with the mesh at rest");
DEFINE_string(grid, "", "convert: flat mesh of a grid, NXxNY:WIDTHxHEIGHT, m");
DEFINE_bool(transpose, false, "convert: the points of --grid run along y first");
DEFINE_string(transform, "", "convert: file with a rigid transform of the points");
DEFINE_bool(invert_transform, false, "convert: apply the inverse of --transform");
DEFINE_string(missing, "", "convert: positions of the file that stand for points not seen");
DEFINE_double(scale, 1.0, "convert: factor of positions");
DEFINE_string(times, "", "convert: file with the times of the frames, s");
DEFINE_double(frame_rate, 0.0, "convert: frames per second; 0: times of the file");
DEFINE_double(time_scale, 1.0, "convert: factor of times");
DEFINE_string(start_at, "", "convert: time of the first frame, s");
DEFINE_string(frames, "", "convert: frames A:B to keep");
DEFINE_string(skip_frames, "", "convert: frames to leave out");
DEFINE_string(map, "nodes", "convert: nodes, nearest, markers or a CSV file");
DEFINE_double(map_distance, 0.0, "convert: how far a point may be off its place, m");
DEFINE_bool(as_surface, false, "convert: the points lie on the cloth, but are not material");
DEFINE_bool(borders, false, "convert: those of the mesh's border lie on that of the cloth");
DEFINE_bool(corners, false, "convert: those of its corners are material");
DEFINE_double(sigma, 0.0, "convert, convert_clouds, convert_cantilever: standard deviation of a coordinate, m");
DEFINE_string(handle_nodes, "", "convert: nodes with a prescribed path");
DEFINE_string(handles, "", "convert: file with their paths");
DEFINE_string(handle_offsets, "", "convert: file with the places where a tool holds them");
DEFINE_string(handle_transform, "", "convert: file with a rigid transform of the handles");
DEFINE_double(handle_time_offset, 0.0, "convert: clock of --handles minus that of the recording, s");

namespace clothid {
namespace {

// Flags that only a motion.bin can keep, and the others.
constexpr char kSceneFlags[] =
    "scene map map_distance as_surface borders corners sigma handle_nodes handles handle_offsets handle_transform "
    "handle_time_offset obstacle obstacle_transform obstacle_time_offset forces force_times force_sigma force_nodes "
    "force_axis force_scale force_time_offset";
constexpr char kPointFlags[] =
    "faces grid transpose missing transform invert_transform scale times frame_rate time_scale start_at skip_frames "
    "frames";

bool IsSet(const std::string& flag) { return !gflags::GetCommandLineFlagInfoOrDie(flag.c_str()).is_default; }

// "0,56": numbers from 0 to `limit` - 1; `what` names them in the message.
std::vector<int> ParseList(const std::string& flag, const std::string& text, int limit, const std::string& what) {
  std::vector<int> numbers;
  if (text.empty()) return numbers;
  for (const std::string& item : Split(text, ',')) {
    const std::optional<long long> number = ParseInteger(item);
    if (!number || *number < 0 || *number >= limit)
      FailFlag(flag, "expected " + what + ", got '" + Printable(item) + "'");
    numbers.push_back(static_cast<int>(*number));
  }
  return numbers;
}

void ParseFrames(TrackEdit* edit) {
  if (FLAGS_frames.empty()) return;
  const std::vector<std::string> ends = Split(FLAGS_frames, ':');
  const std::optional<long long> first = ParseInteger(ends.front()), end = ParseInteger(ends.back());
  if (ends.size() != 2 || !first || !end || *first < 0 || *end <= *first || *end > edit->end_frame) {
    FailFlag("frames", "expected A:B with 0 <= A < B, got '" + Printable(FLAGS_frames) + "'");
  }
  edit->first_frame = static_cast<int>(*first);
  edit->end_frame = static_cast<int>(*end);
}

// "NXxNY:WIDTHxHEIGHT".
Mesh ParseGrid(const std::string& text, bool transpose) {
  const std::vector<std::string> parts = Split(text, ':');
  const auto fail = [&] {
    FailFlag("grid", "expected NXxNY:WIDTHxHEIGHT as in 8x8:0.3x0.3, got '" + Printable(text) + "'");
  };
  if (parts.size() != 2) fail();
  const std::vector<std::string> counts = Split(parts[0], 'x'), lengths = Split(parts[1], 'x');
  if (counts.size() != 2 || lengths.size() != 2) fail();
  std::array<int, 2> nodes{};
  std::array<double, 2> size{};
  for (std::size_t k = 0; k < 2; ++k) {
    const std::optional<long long> count = ParseInteger(counts[k]);
    const std::optional<double> length = ParseNumber(lengths[k]);
    if (!count || *count < 2 || *count > kMaxNodes || !length || !(*length > 0.0)) fail();
    nodes[k] = static_cast<int>(*count);
    size[k] = *length;
  }
  if (nodes[0] > kMaxNodes / nodes[1]) FailFlag("grid", "expected at most " + std::to_string(kMaxNodes) + " nodes");
  return MakePointGrid(nodes, size, transpose);
}

std::optional<Mesh> MeshFromFlags() {
  if (IsSet("grid")) return ParseGrid(FLAGS_grid, FLAGS_transpose);
  if (!IsSet("faces")) return std::nullopt;
  Mesh mesh = ReadObj(FLAGS_faces);
  ValidateObjMesh(mesh, FLAGS_faces);
  return mesh;
}

TrackEdit EditFromFlags(const std::string& input) {
  TrackEdit edit;
  edit.missing = MissingValues::Parse(FLAGS_missing, "--missing");
  edit.scale = FLAGS_scale;
  edit.transform = TransformFromFlags();
  if (IsSet("times")) {
    const FrameTimes times = FrameTimesFromFlags(TrackPaths(input));
    edit.times = times.times;
    edit.times_since_first = times.since_first;
  }
  edit.times_name = TimesNameFromFlags();
  edit.frame_rate = FLAGS_frame_rate;
  edit.time_scale = FLAGS_time_scale;
  edit.start_at = StartFromFlags();
  ParseFrames(&edit);
  edit.skipped_frames = ParseList("skip_frames", FLAGS_skip_frames, kMaxFrames, "frames as in 12,31");
  return edit;
}

void SetMap(ImportOptions* options) {
  if (FLAGS_map == "nodes") {
    options->map = PointMapKind::kNodes;
  } else if (FLAGS_map == "nearest") {
    options->map = PointMapKind::kNearest;
  } else if (FLAGS_map == "markers") {
    options->map = PointMapKind::kMarkers;
  } else {
    options->map = PointMapKind::kFile;
    options->map_path = FLAGS_map;
  }
  options->map_distance = FLAGS_map_distance;
  if (!(FLAGS_map_distance >= 0.0)) FailFlag("map_distance", "expected a distance >= 0 (m)");
  options->surface = {FLAGS_as_surface, FLAGS_borders, FLAGS_corners};
}

void SetHandleFile(ImportOptions* options) {
  constexpr std::string_view kClamp = ":clamp";
  std::string nodes = FLAGS_handle_nodes;
  if (nodes.size() > kClamp.size() && nodes.compare(nodes.size() - kClamp.size(), kClamp.size(), kClamp) == 0) {
    options->clamps_handles = true;
    nodes.resize(nodes.size() - kClamp.size());
  }
  options->handle_nodes = ParseList("handle_nodes", nodes, kMaxNodes, "nodes");
  if (!IsSet("handles")) return;
  HandleFile file;
  file.path = FLAGS_handles;
  file.offsets_path = FLAGS_handle_offsets;
  file.time_offset = FLAGS_handle_time_offset;
  if (IsSet("handle_transform")) file.transform = ReadTransform(FLAGS_handle_transform);
  options->handle_file = file;
}

// No input is to be lost to an output.
void CheckOutputs(const std::string& input, const std::string& output) {
  std::vector<std::string> inputs = TrackPaths(input);
  for (const std::string& file : {FLAGS_faces, FLAGS_transform, FLAGS_times, FLAGS_map, FLAGS_handles,
                                  FLAGS_handle_offsets, FLAGS_handle_transform}) {
    inputs.push_back(file);
  }
  for (const std::vector<std::string>& more : {ForceInputs(), ObstacleInputs()}) {
    inputs.insert(inputs.end(), more.begin(), more.end());
  }
  if (!FLAGS_scene.empty()) {
    for (const std::string& file : FilesOfScene(FLAGS_scene)) inputs.push_back(file);
  }
  for (const std::string& file : TrackPaths(output)) RefuseOverwrite(file, inputs);
}

// The flags that were given, and the names of files in place of their paths.
std::string Provenance(const std::string& input) {
  std::string text = "converted from " + std::filesystem::path(input).filename().string();
  const auto add = [&](const std::string& flag) {
    if (!IsSet(flag)) return;
    const gflags::CommandLineFlagInfo info = gflags::GetCommandLineFlagInfoOrDie(flag.c_str());
    const std::optional<double> number = ParseNumber(info.current_value);
    const bool is_file = info.current_value.find('/') != std::string::npos;
    text += " --" + flag;
    if (info.type == "bool") return;
    text += " " + (flag == "obstacle"                ? ObstacleWords()
                   : is_file                         ? std::filesystem::path(info.current_value).filename().string()
                   : info.type == "double" && number ? ShortestText(*number)
                                                     : info.current_value);
  };
  for (const char* flags : {kPointFlags, kSceneFlags}) {
    for (const std::string& flag : Split(flags, ' ')) add(flag);
  }
  return text;
}

void PrintSummary(const MotionTensors& motion, const std::string& path) {
  std::cout << path << ": " << motion.times.size() << " frames from " << TimeText(motion.times[0]) << " s to "
            << TimeText(motion.times[motion.times.size() - 1]) << " s, " << motion.positions.rows() / 3
            << " points on a mesh of " << motion.mesh.num_nodes() << " nodes, " << motion.handle_index.size()
            << " handles";
  const auto num_material = std::count(motion.point_kind.begin(), motion.point_kind.end(), 0);
  if (!motion.point_kind.empty()) std::cout << ", " << num_material << " of the points material";
  if (!motion.forces.is_empty()) std::cout << ", " << motion.forces.num_readings() << " readings of forces";
  std::cout << "\n";
}

void PrintNote(const std::string& path, const std::string& note) {
  if (!note.empty()) std::cerr << "motion: " << path << ": note: " << note << "\n";
}

// What was made of the files beside the points.
void PrintTableNotes() {
  std::vector<std::string> files = {FLAGS_times, FLAGS_map, FLAGS_handles};
  for (const std::vector<std::string>& more : {ForceInputs(), ObstacleInputs()}) {
    files.insert(files.end(), more.begin(), more.end());
  }
  for (const std::string& file : files) PrintNote(file, TableNote(file));
}

void PrintPointNotes(const PointTracks& tracks) {
  PrintNote(tracks.name, TableNote(tracks.name));
  if (FLAGS_frame_rate == 0.0 || tracks.sample_rate == 1.0 || tracks.sample_rate == FLAGS_frame_rate) return;
  PrintNote(tracks.name, "its header has a sample rate of " + ShortestText(tracks.sample_rate) +
                             ", in frames per sample, or per second; --frame_rate " + ShortestText(FLAGS_frame_rate) +
                             " is taken for the rate of the samples");
}

int ToMotionFile(const std::string& input, const std::string& output, ImportOptions options) {
  CheckFileCanBeWritten(output);
  options.scene_path = FLAGS_scene;
  SetMap(&options);
  SetHandleFile(&options);
  options.force_file = ForceFileFromFlags();
  options.obstacle_files = ObstacleFilesFromFlags();
  options.sigma = FLAGS_sigma;
  MotionTensors motion;
  if (IsMotionName(input)) {
    const MotionTensors read = ReadMotionTensors(input);
    options.provenance = (read.provenance.empty() ? "" : read.provenance + "; ") + Provenance(input);
    motion = ConvertMotion(read, input, options);
  } else {
    options.provenance = Provenance(input);
    const PointTracks tracks = ReadTracks(input);
    motion = ImportMotion(tracks, options);
    PrintPointNotes(tracks);
  }
  WriteMotion(motion, output);
  PrintTableNotes();
  PrintSummary(motion, output);
  return kExitSuccess;
}

int ToTrackFile(const std::string& input, const std::string& output, const ImportOptions& options) {
  for (const std::string& flag : Split(kSceneFlags, ' ')) {
    if (IsSet(flag)) FailFlag(flag, "expected with a motion.bin to write, a name that ends in .bin");
  }
  PointTracks tracks = IsMotionName(input) ? ToTracks(ReadMotionTensors(input), input) : ReadTracks(input);
  tracks = EditTracks(tracks, options.edit).tracks;
  if (options.mesh) {
    MapToNodes(tracks, *options.mesh);
    tracks.faces = options.mesh->faces;
  }
  WriteTracks(tracks, output);
  if (!IsMotionName(input)) PrintPointNotes(tracks);
  PrintNote(FLAGS_times, TableNote(FLAGS_times));
  const TrackFormat format = OutputFormatOf(output);
  const std::string name =
      format == TrackFormat::kVtp ? std::filesystem::path(output).replace_extension(".pvd").string() : output;
  std::cout << name << ": " << tracks.num_frames() << " frames, " << tracks.num_points() << " points";
  if (HoldsFaces(format)) std::cout << ", " << tracks.faces.cols() << " faces";
  std::cout << "\n";
  return kExitSuccess;
}

}  // namespace

std::string ConvertFlags() { return std::string(kPointFlags) + " " + kSceneFlags; }

int MotionConvert(const std::vector<std::string>& arguments) {
  const std::string &input = arguments[0], &output = arguments[1];
  if (!IsMotionName(output)) OutputFormatOf(output);
  CheckOutputs(input, output);
  ImportOptions options;
  options.edit = EditFromFlags(input);
  options.mesh = MeshFromFlags();
  return IsMotionName(output) ? ToMotionFile(input, output, options) : ToTrackFile(input, output, options);
}

}  // namespace clothid
