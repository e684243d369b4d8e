#include "sim/scene/sequence_json.h"

#include <cctype>
#include <filesystem>

#include "sim/base/error.h"
#include "sim/base/frame_names.h"
#include "sim/base/npy_file.h"
#include "sim/base/text_file.h"
#include "sim/mesh/obj_file.h"
#include "sim/mesh/point_cache.h"
#include "sim/obstacle/triangulated_surface.h"

namespace clothid {
namespace {

using Kind = JsonValue::Kind;

struct Frames {
  Eigen::MatrixXd positions;         // [3V x T]
  std::vector<double> numbers;       // [T], which a frame rate makes times of
  std::vector<std::string> sources;  // [T] where frames are files of their own; else one, of all of them
};

bool EndsIn(const std::string& path, const std::string& extension) {
  std::string own = std::filesystem::path(path).extension().string();
  for (char& c : own) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return own == extension;
}

std::vector<double> Count(Eigen::Index frames, double first, double step) {
  std::vector<double> numbers;
  for (Eigen::Index i = 0; i < frames; ++i) numbers.push_back(first + static_cast<double>(i) * step);
  return numbers;
}

Frames ReadNpyFrames(const std::string& path) {
  const NpyArray array = ReadNpy(path);
  if (array.shape.size() != 3 || array.shape[0] < 1 || array.shape[1] < 1 || array.shape[2] != 3) {
    throw Error(ErrorKind::kBadData, path + ": expected an array of frames x vertices x 3");
  }
  const Eigen::Map<const Eigen::MatrixXd> positions(array.values.data(), 3 * array.shape[1], array.shape[0]);
  return {positions, Count(positions.cols(), 0.0, 1.0), {path}};
}

Frames ReadCacheFrames(const std::string& path) {
  PointCache cache = ReadPointCache(path);
  std::vector<double> numbers = Count(cache.positions.cols(), cache.first_frame, cache.frames_per_sample);
  return {std::move(cache.positions), std::move(numbers), {path}};
}

Frames ReadObjFrames(const std::vector<std::string>& paths, const TriangulatedSurface& surface) {
  Frames frames;
  frames.positions.resize(surface.vertices().size(), static_cast<Eigen::Index>(paths.size()));
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const Mesh mesh = ReadObjLike(paths[i], surface.faces());
    const auto expect = [&](Eigen::Index found, Eigen::Index expected, const char* what) {
      if (found == expected) return;
      throw Error(ErrorKind::kBadData, paths[i] + ": has " + std::to_string(found) + what + "; expected the " +
                                           std::to_string(expected) + " of the mesh");
    };
    expect(mesh.num_nodes(), surface.vertices().cols(), " vertices");
    expect(mesh.num_faces(), surface.faces().cols(), " triangles");
    for (int face = 0; face < mesh.num_faces(); ++face) {
      if (mesh.faces.col(face) == surface.faces().col(face)) continue;
      FailOnData(PlaceInObj(paths[i], {face}),
                 "triangle " + std::to_string(face) + " has other vertices than that of the mesh");
    }
    frames.positions.col(static_cast<Eigen::Index>(i)) = mesh.rest_positions.reshaped();
  }
  const std::vector<long long> numbers = FrameNumbers(paths);
  frames.numbers = Count(frames.positions.cols(), 0.0, 1.0);
  for (std::size_t i = 0; i < numbers.size(); ++i) frames.numbers[i] = static_cast<double>(numbers[i]);
  frames.sources = paths;
  return frames;
}

Frames ReadFrames(const JsonNode& file, const TriangulatedSurface& surface, const std::string& folder) {
  if (!file.is(Kind::kArray)) {
    const std::string path = file.Path(folder);
    if (EndsIn(path, ".npy")) return ReadNpyFrames(path);
    if (EndsIn(path, ".pc2")) return ReadCacheFrames(path);
    return ReadObjFrames(FramePaths(path, ".obj"), surface);
  }
  std::vector<std::string> paths;
  for (const JsonNode& item : file.items()) paths.push_back(item.Path(folder));
  if (paths.empty()) file.Fail("expected at least one OBJ file");
  return ReadObjFrames(paths, surface);
}

Eigen::VectorXd ReadTimes(const JsonNode& times, const std::string& folder) {
  std::vector<double> values;
  if (times.is(Kind::kString)) {
    const NpyArray array = ReadNpy(times.Path(folder));
    if (array.shape.size() != 1) times.Fail("expected an array of one dimension in " + times.Path(folder));
    values = array.values;
  } else {
    for (const JsonNode& item : times.items()) values.push_back(item.Number());
  }
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

Eigen::VectorXd TimesOf(const JsonNode& node, const std::vector<double>& numbers, const std::string& folder) {
  const auto times = node.Find("times"), rate = node.Find("frame_rate"), start = node.Find("start_time");
  if (times.has_value() == rate.has_value()) {
    node.Fail("expected either \"times\" (s, one of every frame) or \"frame_rate\" (Hz)");
  }
  if (times) {
    if (start) start->Fail("expected none beside \"times\"");
    return ReadTimes(*times, folder);
  }
  const double first = start ? start->Number() : 0.0, interval = 1.0 / rate->PositiveNumber();
  return first + interval * Eigen::Map<const Eigen::ArrayXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

// The file of the frame that a message "frame K: .." is about, and the line of `part` in it.
std::string SourceOf(const Frames& frames, const std::string& message, MeshPart part) {
  constexpr char kFrame[] = "frame ";
  if (frames.sources.empty()) return "";
  const bool names_frame = message.rfind(kFrame, 0) == 0;
  const std::size_t frame = names_frame ? std::stoul(message.substr(sizeof(kFrame) - 1)) : 0;
  const std::string& source = frames.sources[frames.sources.size() > 1 ? frame : 0];
  return (EndsIn(source, ".obj") ? PlaceInObj(source, part) : source) + ": ";
}

}  // namespace

std::shared_ptr<const SurfaceSequence> ReadSequence(const JsonNode& node, const Obstacle& shape,
                                                    const Eigen::MatrixXd* recorded, const std::string& folder) {
  node.ExpectKeys({"file", "times", "frame_rate", "start_time"});
  const auto& surface = dynamic_cast<const TriangulatedSurface&>(shape);
  const auto file = node.Find("file");
  Frames frames;
  if (!file && recorded != nullptr) {
    frames = {*recorded, Count(recorded->cols(), 0.0, 1.0), {}};
  } else {
    frames =
        ReadFrames(node.Require("file", "a .npy array, a .pc2 file, OBJ files like body_####.obj or a list of them"),
                   surface, folder);
  }
  const Eigen::VectorXd times = TimesOf(node, frames.numbers, folder);
  std::string problem;
  MeshPart part;
  try {
    return std::make_shared<SurfaceSequence>(surface, times, frames.positions);
  } catch (const MeshError& error) {
    problem = error.what();
    part = error.part();
  } catch (const Error& error) {
    problem = error.what();
  }
  node.Fail(SourceOf(frames, problem, part) + problem);
}

std::vector<std::string> FilesOfSequence(const std::string& path) {
  if (EndsIn(path, ".npy") || EndsIn(path, ".pc2")) return {path};
  try {
    return FramePaths(path, ".obj");
  } catch (const Error&) {
    return {path};
  }
}

}  // namespace clothid
