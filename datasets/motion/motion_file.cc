#include "datasets/motion/motion_file.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string_view>
#include <utility>

#include "datasets/files/atomic_file.h"
#include "datasets/files/safetensors.h"
#include "datasets/files/sha256.h"
#include "datasets/motion/motion_container.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr char kFormat[] = "clothid.motion";
constexpr char kVersion[] = "1";
constexpr std::size_t kDigestLength = 64;
constexpr long long kAny = -1;  // a size that the shape leaves open

constexpr std::string_view kMetadataKeys[] = {"format", "version", "scene", "provenance", "sha256", "header_sha256"};
constexpr std::string_view kTensorNames[] = {"positions",        "times",       "rest_positions", "faces",
                                             "node_index",       "face_index",  "barycentric",    "handle_index",
                                             "handle_positions", "sigma",       "cloud_offsets",  "cloud_positions",
                                             "cloud_sigma",      "handle_times"};

template <std::size_t kSize>
bool Contains(const std::string_view (&names)[kSize], std::string_view name) {
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

[[noreturn]] void Fail(const std::string& path, const std::string& message) {
  throw Error(ErrorKind::kBadData, path + ": " + message);
}

// ---- Checksums

std::string HeaderDigest(std::string header, std::size_t digest_position) {
  header.replace(digest_position, kDigestLength, kDigestLength, ' ');
  return Sha256Hex({header});
}

// Where the value of `header_sha256` stands in the header; npos where it does not. The quotes around the key cannot
// stand inside a JSON string, so nothing but a key is found, and only `__metadata__` may hold this one.
std::size_t FindHeaderDigest(const std::string& header, const std::string& digest) {
  constexpr char kKey[] = "\"header_sha256\"";
  constexpr char kBlanks[] = " \t\r\n";
  const std::size_t key = header.find(kKey);
  if (key == std::string::npos) return key;
  const std::size_t colon = header.find_first_not_of(kBlanks, key + sizeof(kKey) - 1);
  if (colon == std::string::npos || header[colon] != ':') return std::string::npos;
  const std::size_t quote = header.find_first_not_of(kBlanks, colon + 1);
  if (quote == std::string::npos || header.compare(quote, digest.size() + 2, "\"" + digest + "\"") != 0) {
    return std::string::npos;
  }
  return quote + 1;
}

const std::string& RequireMetadata(const Safetensors& file, const std::string& path, const std::string& key) {
  const auto found = file.metadata.find(key);
  if (found == file.metadata.end()) Fail(path, "key '__metadata__." + key + "': is missing; expected a string");
  return found->second;
}

void ExpectMetadata(const Safetensors& file, const std::string& path, const std::string& key,
                    const std::string& expected) {
  const std::string& found = RequireMetadata(file, path, key);
  if (found != expected) {
    Fail(path, "key '__metadata__." + key + "': expected '" + expected + "', found '" + Printable(found) + "'");
  }
}

void VerifyMetadata(const Safetensors& file, const std::string& path) {
  ExpectMetadata(file, path, "format", kFormat);
  ExpectMetadata(file, path, "version", kVersion);
  for (const auto& [key, value] : file.metadata) {
    if (!Contains(kMetadataKeys, key)) Fail(path, "unknown key '__metadata__." + Printable(key) + "'");
  }
  const auto header_digest = file.metadata.find("header_sha256");
  if (header_digest != file.metadata.end()) {
    const std::size_t position = FindHeaderDigest(file.header, header_digest->second);
    if (header_digest->second.size() != kDigestLength || position == std::string::npos ||
        HeaderDigest(file.header, position) != header_digest->second) {
      Fail(path, "key '__metadata__.header_sha256': does not match the header; the file is damaged");
    }
  }
  if (RequireMetadata(file, path, "sha256") != Sha256Hex({file.data})) {
    Fail(path, "key '__metadata__.sha256': does not match the tensors; the file is damaged");
  }
}

// ---- From the container to tensors

class TensorReader {
 public:
  TensorReader(const Safetensors& file, const std::string& path) : file_(file), path_(path) {}

  bool Has(const std::string& name) const { return file_.tensors.count(name) > 0; }

  const TensorInfo& Require(const std::string& name, const std::vector<TensorType>& types,
                            const std::vector<long long>& shape, long long least_size = 1) const {
    const auto found = file_.tensors.find(name);
    if (found == file_.tensors.end()) Fail(path_, "tensor '" + name + "' is missing");
    const TensorInfo& tensor = found->second;
    if (std::find(types.begin(), types.end(), tensor.type) == types.end()) {
      Fail(path_, "tensor '" + name + "': expected dtype " + TensorTypeName(types.front()) + ", found " +
                      TensorTypeName(tensor.type));
    }
    bool fits = tensor.shape.size() == shape.size();
    for (std::size_t k = 0; fits && k < shape.size(); ++k) {
      const long long size = tensor.shape[k];
      fits =
          size >= least_size && size <= std::numeric_limits<int>::max() / 3 && (shape[k] == kAny || size == shape[k]);
    }
    if (!fits)
      Fail(path_, "tensor '" + name + "': expected shape " + ToString(shape) + ", found " + ToString(tensor.shape));
    return tensor;
  }

  Eigen::MatrixXd Doubles(const TensorInfo& tensor, Eigen::Index rows) const {
    return tensor.type == TensorType::kF32 ? Copy<float, double>(tensor, rows) : Copy<double, double>(tensor, rows);
  }

  Eigen::MatrixXi Integers(const TensorInfo& tensor, Eigen::Index rows) const {
    return Copy<std::int32_t, int>(tensor, rows);
  }

  std::vector<int> Indices(const std::string& name, long long count) const {
    const Eigen::MatrixXi values = Integers(Require(name, {TensorType::kI32}, {count}), 1);
    return {values.data(), values.data() + values.size()};
  }

 private:
  static std::string ToString(const std::vector<long long>& shape) {
    std::string text;
    for (const long long size : shape)
      text += (text.empty() ? "" : ", ") + (size == kAny ? "any" : std::to_string(size));
    return "[" + text + "]";
  }

  template <typename Stored, typename T>
  Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic> Copy(const TensorInfo& tensor, Eigen::Index rows) const {
    const Eigen::Index count = static_cast<Eigen::Index>(tensor.num_elements());
    Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic> result(rows, rows > 0 ? count / rows : tensor.shape[0]);
    const char* bytes = file_.bytes(tensor).data();
    for (Eigen::Index i = 0; i < count; ++i) {
      Stored value;
      std::memcpy(&value, bytes + static_cast<std::size_t>(i) * sizeof(Stored), sizeof(Stored));
      result.data()[i] = static_cast<T>(value);
    }
    return result;
  }

  const Safetensors& file_;
  const std::string& path_;
};

void RejectUnknownTensors(const Safetensors& file, const std::string& path) {
  for (const auto& [name, tensor] : file.tensors) {
    if (!Contains(kTensorNames, name)) Fail(path, "unknown tensor '" + Printable(name) + "'");
  }
}

// Offsets that do not ascend from 0 to the number of points are errors, before anything is cut by them.
std::vector<Eigen::Matrix3Xd> ReadClouds(const TensorReader& reader, const TensorInfo& positions, long long num_times,
                                         const std::string& path) {
  const std::vector<int> offsets = reader.Indices("cloud_offsets", num_times + 1);
  const Eigen::Matrix3Xd all = reader.Doubles(positions, 3);
  bool ascends = offsets.front() == 0 && offsets.back() == all.cols();
  for (std::size_t i = 1; i < offsets.size(); ++i) ascends &= offsets[i] >= offsets[i - 1];
  if (!ascends) {
    Fail(path, "tensor 'cloud_offsets': expected numbers that ascend from 0 to the " + std::to_string(all.cols()) +
                   " points of 'cloud_positions'");
  }
  std::vector<Eigen::Matrix3Xd> clouds;
  for (std::size_t i = 1; i < offsets.size(); ++i) {
    clouds.emplace_back(all.middleCols(offsets[i - 1], offsets[i] - offsets[i - 1]));
  }
  return clouds;
}

void ReadClouds(const TensorReader& reader, const std::string& path, MotionTensors* tensors) {
  if (!reader.Has("cloud_positions") && !reader.Has("cloud_offsets") && !reader.Has("cloud_sigma")) return;
  const TensorInfo& positions = reader.Require("cloud_positions", {TensorType::kF32, TensorType::kF64}, {kAny, 3});
  tensors->single_precision_clouds = positions.type == TensorType::kF32;
  tensors->clouds = ReadClouds(reader, positions, tensors->times.size(), path);
  if (!reader.Has("cloud_sigma")) return;
  tensors->cloud_sigma = reader.Doubles(reader.Require("cloud_sigma", {TensorType::kF64}, {1}), 1)(0);
  if (!(tensors->cloud_sigma > 0.0)) Fail(path, "tensor 'cloud_sigma': is not a number > 0");
}

MotionTensors ToMotionTensors(const Safetensors& file, const std::string& path) {
  RejectUnknownTensors(file, path);
  const TensorReader reader(file, path);
  const std::vector<TensorType> f64 = {TensorType::kF64}, i32 = {TensorType::kI32};
  MotionTensors tensors;
  tensors.times = reader.Doubles(reader.Require("times", f64, {kAny}), 1).transpose();
  const long long num_times = tensors.times.size();
  ReadClouds(reader, path, &tensors);
  const TensorInfo& positions = reader.Require("positions", {TensorType::kF32, TensorType::kF64}, {num_times, kAny, 3},
                                               /*least_size=*/tensors.clouds.empty() ? 1 : 0);
  const long long num_points = positions.shape[1];
  tensors.single_precision = positions.type == TensorType::kF32;
  tensors.positions = reader.Doubles(positions, 3 * num_points);
  tensors.mesh.rest_positions = reader.Doubles(reader.Require("rest_positions", f64, {kAny, 3}), 3);
  tensors.mesh.faces = reader.Integers(reader.Require("faces", i32, {kAny, 3}), 3);
  if (reader.Has("node_index")) tensors.node_index = reader.Indices("node_index", num_points);
  if (reader.Has("face_index")) tensors.face_index = reader.Indices("face_index", num_points);
  if (reader.Has("barycentric")) {
    tensors.barycentric = reader.Doubles(reader.Require("barycentric", f64, {num_points, 3}), 3);
  }
  if (reader.Has("handle_index")) tensors.handle_index = reader.Indices("handle_index", kAny);
  if (reader.Has("handle_times")) {
    tensors.handle_times = reader.Doubles(reader.Require("handle_times", f64, {kAny}), 1).transpose();
  }
  if (reader.Has("handle_positions")) {
    const long long num_handles = static_cast<long long>(tensors.handle_index.size());
    const long long num_knots = tensors.handle_times.size() > 0 ? tensors.handle_times.size() : num_times;
    tensors.handle_positions =
        reader.Doubles(reader.Require("handle_positions", f64, {num_knots, num_handles, 3}), 3 * num_handles);
  }
  if (reader.Has("sigma")) tensors.sigma = reader.Doubles(reader.Require("sigma", f64, {num_points}), 1).transpose();
  tensors.scene_text = RequireMetadata(file, path, "scene");
  const auto provenance = file.metadata.find("provenance");
  if (provenance != file.metadata.end()) tensors.provenance = provenance->second;
  return tensors;
}

// ---- From tensors to the container

template <typename Stored, typename Derived>
std::string ToBytes(const Eigen::DenseBase<Derived>& values) {
  const Eigen::Array<Stored, Eigen::Dynamic, Eigen::Dynamic> stored = values.derived().array().template cast<Stored>();
  std::string bytes(static_cast<std::size_t>(stored.size()) * sizeof(Stored), '\0');
  if (!bytes.empty()) std::memcpy(bytes.data(), stored.data(), bytes.size());
  return bytes;
}

std::string ToBytes(const std::vector<int>& values) {
  return ToBytes<std::int32_t>(
      Eigen::Map<const Eigen::VectorXi>(values.data(), static_cast<Eigen::Index>(values.size())));
}

// [M x 3] of all frames, as columns.
Eigen::Matrix3Xd JoinClouds(const std::vector<Eigen::Matrix3Xd>& clouds, std::vector<int>* offsets) {
  offsets->assign(1, 0);
  for (const Eigen::Matrix3Xd& cloud : clouds) offsets->push_back(offsets->back() + static_cast<int>(cloud.cols()));
  Eigen::Matrix3Xd all(3, offsets->back());
  for (std::size_t i = 0; i < clouds.size(); ++i) all.middleCols((*offsets)[i], clouds[i].cols()) = clouds[i];
  return all;
}

// The doubles come first, so that every tensor stands on a multiple of its element size.
std::vector<TensorBytes> ToContainer(const MotionTensors& tensors) {
  const TensorType f64 = TensorType::kF64, i32 = TensorType::kI32;
  const long long num_times = tensors.times.size(), num_points = tensors.positions.rows() / 3;
  const long long num_handles = static_cast<long long>(tensors.handle_index.size());
  std::vector<TensorBytes> result;
  // Every missing coordinate is written as the same NaN: the same motion gives the same bytes.
  const Eigen::MatrixXd positions =
      tensors.positions.array().isNaN().select(std::numeric_limits<double>::quiet_NaN(), tensors.positions);
  result.push_back({"times", f64, {num_times}, ToBytes<double>(tensors.times)});
  result.push_back(
      {"rest_positions", f64, {tensors.mesh.num_nodes(), 3}, ToBytes<double>(tensors.mesh.rest_positions)});
  if (!tensors.face_index.empty()) {
    result.push_back({"barycentric", f64, {num_points, 3}, ToBytes<double>(tensors.barycentric)});
  }
  if (num_handles > 0) {
    const long long num_knots = tensors.handle_positions.cols();
    result.push_back({"handle_positions", f64, {num_knots, num_handles, 3}, ToBytes<double>(tensors.handle_positions)});
  }
  if (tensors.handle_times.size() > 0) {
    result.push_back({"handle_times", f64, {tensors.handle_times.size()}, ToBytes<double>(tensors.handle_times)});
  }
  if (tensors.sigma.size() > 0) result.push_back({"sigma", f64, {num_points}, ToBytes<double>(tensors.sigma)});
  std::vector<int> offsets;
  const Eigen::Matrix3Xd cloud = JoinClouds(tensors.clouds, &offsets);
  if (tensors.cloud_sigma > 0.0) {
    result.push_back({"cloud_sigma", f64, {1}, ToBytes<double>(Eigen::VectorXd::Constant(1, tensors.cloud_sigma))});
  }
  if (!tensors.clouds.empty() && !tensors.single_precision_clouds) {
    result.push_back({"cloud_positions", f64, {cloud.cols(), 3}, ToBytes<double>(cloud)});
  }
  result.push_back({"positions",
                    tensors.single_precision ? TensorType::kF32 : f64,
                    {num_times, num_points, 3},
                    tensors.single_precision ? ToBytes<float>(positions) : ToBytes<double>(positions)});
  if (!tensors.clouds.empty()) {
    if (tensors.single_precision_clouds) {
      result.push_back({"cloud_positions", TensorType::kF32, {cloud.cols(), 3}, ToBytes<float>(cloud)});
    }
    result.push_back({"cloud_offsets", i32, {num_times + 1}, ToBytes(offsets)});
  }
  result.push_back({"faces", i32, {tensors.mesh.num_faces(), 3}, ToBytes<std::int32_t>(tensors.mesh.faces)});
  if (!tensors.node_index.empty()) result.push_back({"node_index", i32, {num_points}, ToBytes(tensors.node_index)});
  if (!tensors.face_index.empty()) result.push_back({"face_index", i32, {num_points}, ToBytes(tensors.face_index)});
  if (num_handles > 0) result.push_back({"handle_index", i32, {num_handles}, ToBytes(tensors.handle_index)});
  return result;
}

}  // namespace

VerifiedMotion ReadVerifiedMotion(const std::string& path) {
  const Safetensors file = ReadSafetensors(path);
  VerifyMetadata(file, path);
  VerifiedMotion motion;
  motion.tensors = ToMotionTensors(file, path);
  ValidateMotionTensors(motion.tensors, path);
  motion.sha256 = Sha256Hex({file.length_bytes, file.header, file.data});
  return motion;
}

MotionTensors ReadMotionTensors(const std::string& path) { return ReadVerifiedMotion(path).tensors; }

void WriteMotion(const MotionTensors& tensors, const std::string& path) {
  ValidateMotionTensors(tensors, path);
  const std::vector<TensorBytes> container = ToContainer(tensors);
  std::string data;
  for (const TensorBytes& tensor : container) data += tensor.bytes;
  const std::string blank(kDigestLength, ' ');
  std::string header = SafetensorsHeader({{"format", kFormat},
                                          {"version", kVersion},
                                          {"scene", tensors.scene_text},
                                          {"provenance", tensors.provenance},
                                          {"sha256", Sha256Hex({data})},
                                          {"header_sha256", blank}},
                                         container);
  header.replace(FindHeaderDigest(header, blank), kDigestLength, Sha256Hex({header}));
  WriteFileAtomically(path, {LengthBytes(header.size()), header, data});
}

}  // namespace clothid
