#include "datasets/motion/motion_container.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>
#include <string_view>
#include <vector>

#include "datasets/files/safetensors.h"
#include "datasets/files/sha256.h"
#include "datasets/motion/motion_header.h"
#include "datasets/motion/motion_validation.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr long long kAny = -1;  // a size that the shape leaves open

constexpr std::string_view kTensorNames[] = {
    "positions",     "times",          "rest_positions",  "faces",        "node_index",
    "face_index",    "barycentric",    "point_kind",      "handle_index", "handle_positions",
    "sigma",         "cloud_offsets",  "cloud_positions", "cloud_sigma",  "handle_times",
    "handle_forces", "handle_moments", "force_times",     "force_sigma",  "force_nodes",
    "force_offsets", "corner_rest",    "folds",           "link_nodes",   "link_values"};

class TensorReader {
 public:
  TensorReader(const Safetensors& file, const std::string& path) : file_(file), path_(path) {}

  bool Has(const std::string& name) const { return file_.tensors.count(name) > 0; }

  const TensorInfo& Require(const std::string& name, const std::vector<TensorType>& types,
                            const std::vector<long long>& shape, long long least_size = 1) const {
    const auto found = file_.tensors.find(name);
    if (found == file_.tensors.end()) FailOnData(path_, "tensor '" + name + "' is missing");
    const TensorInfo& tensor = found->second;
    if (std::find(types.begin(), types.end(), tensor.type) == types.end()) {
      FailOnData(path_, "tensor '" + name + "': expected dtype " + TensorTypeName(types.front()) + ", found " +
                            TensorTypeName(tensor.type));
    }
    bool fits = tensor.shape.size() == shape.size();
    for (std::size_t k = 0; fits && k < shape.size(); ++k) {
      const long long size = tensor.shape[k];
      fits =
          size >= least_size && size <= std::numeric_limits<int>::max() / 3 && (shape[k] == kAny || size == shape[k]);
    }
    if (!fits)
      FailOnData(path_,
                 "tensor '" + name + "': expected shape " + ToString(shape) + ", found " + ToString(tensor.shape));
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

bool IsSequence(const std::string& name) { return name.rfind(kSequencePrefix, 0) == 0; }

void RejectUnknownTensors(const Safetensors& file, const std::string& path) {
  for (const auto& [name, tensor] : file.tensors) {
    const bool is_known = std::find(std::begin(kTensorNames), std::end(kTensorNames), name) != std::end(kTensorNames);
    if (!is_known && !IsSequence(name)) FailOnData(path, "unknown tensor '" + Printable(name) + "'");
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
    FailOnData(path, "tensor 'cloud_offsets': expected numbers that ascend from 0 to the " +
                         std::to_string(all.cols()) + " points of 'cloud_positions'");
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
  if (!(tensors->cloud_sigma > 0.0)) FailOnData(path, "tensor 'cloud_sigma': is not a number > 0");
}

// Offsets that do not ascend from 0 to the number of nodes are errors, before anything is cut by them.
std::vector<std::vector<int>> ReadForceGroups(const TensorReader& reader, long long num_groups,
                                              const std::string& path) {
  if (!reader.Has("force_nodes") && !reader.Has("force_offsets")) {
    if (num_groups == 1) return {};
    FailOnData(path, "tensor 'force_nodes' is missing; expected the handles of the " + std::to_string(num_groups) +
                         " groups of 'handle_forces'");
  }
  const std::vector<int> nodes = reader.Indices("force_nodes", kAny);
  const std::vector<int> offsets = reader.Indices("force_offsets", num_groups + 1);
  bool ascends = offsets.front() == 0 && offsets.back() == static_cast<int>(nodes.size());
  for (std::size_t i = 1; i < offsets.size(); ++i) ascends &= offsets[i] > offsets[i - 1];
  if (!ascends) {
    FailOnData(path, "tensor 'force_offsets': expected numbers that ascend from 0 to the " +
                         std::to_string(nodes.size()) + " entries of 'force_nodes', each group with a node");
  }
  std::vector<std::vector<int>> groups;
  for (std::size_t i = 1; i < offsets.size(); ++i) {
    groups.emplace_back(nodes.begin() + offsets[i - 1], nodes.begin() + offsets[i]);
  }
  return groups;
}

ForceReadings ReadForces(const TensorReader& reader, const std::string& path) {
  ForceReadings forces;
  if (!reader.Has("handle_forces")) {
    for (const char* name : {"force_times", "force_sigma", "force_nodes", "force_offsets", "handle_moments"}) {
      if (reader.Has(name))
        FailOnData(path, "tensor 'handle_forces' is missing; expected beside '" + std::string(name) + "'");
    }
    return forces;
  }
  const std::vector<TensorType> f64 = {TensorType::kF64};
  forces.times = reader.Doubles(reader.Require("force_times", f64, {kAny}), 1).transpose();
  const TensorInfo& values = reader.Require("handle_forces", f64, {forces.times.size(), kAny, 3});
  const long long num_groups = values.shape[1];
  forces.values = reader.Doubles(values, 3 * num_groups);
  forces.sigma = reader.Doubles(reader.Require("force_sigma", f64, {num_groups}), 1).transpose();
  forces.groups = ReadForceGroups(reader, num_groups, path);
  if (reader.Has("handle_moments")) {
    forces.moments =
        reader.Doubles(reader.Require("handle_moments", f64, {forces.times.size(), num_groups, 3}), 3 * num_groups);
  }
  return forces;
}

// What a mesh may have beside its nodes and faces.
void ReadSewing(const TensorReader& reader, Mesh* mesh) {
  const std::vector<TensorType> f64 = {TensorType::kF64}, i32 = {TensorType::kI32};
  if (reader.Has("corner_rest")) {
    mesh->corner_rest = reader.Doubles(reader.Require("corner_rest", f64, {mesh->num_faces(), 3, 2}), 2);
  }
  if (reader.Has("folds")) {
    const Eigen::MatrixXi folds = reader.Integers(reader.Require("folds", i32, {kAny, 2}), 2);
    for (const auto& fold : folds.colwise()) mesh->folds.push_back({fold[0], fold[1]});
  }
  if (!reader.Has("link_nodes") && !reader.Has("link_values")) return;
  const Eigen::MatrixXi nodes = reader.Integers(reader.Require("link_nodes", i32, {kAny, 3}), 3);
  const Eigen::MatrixXd values = reader.Doubles(reader.Require("link_values", f64, {nodes.cols(), 3}), 3);
  for (Eigen::Index i = 0; i < nodes.cols(); ++i) {
    mesh->links.push_back({nodes(0, i), {nodes(1, i), nodes(2, i)}, values(0, i), values(1, i), values(2, i)});
  }
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
  ReadSewing(reader, &tensors.mesh);
  if (reader.Has("node_index")) tensors.node_index = reader.Indices("node_index", num_points);
  if (reader.Has("face_index")) tensors.face_index = reader.Indices("face_index", num_points);
  if (reader.Has("barycentric")) {
    tensors.barycentric = reader.Doubles(reader.Require("barycentric", f64, {num_points, 3}), 3);
  }
  if (reader.Has("point_kind")) tensors.point_kind = reader.Indices("point_kind", num_points);
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
  tensors.forces = ReadForces(reader, path);
  for (const auto& [name, found] : file.tensors) {
    if (!IsSequence(name)) continue;
    const TensorInfo& tensor = reader.Require(name, f64, {kAny, kAny, 3});
    tensors.sequences[name.substr(kSequencePrefix.size())] = reader.Doubles(tensor, 3 * tensor.shape[1]);
  }
  tensors.scene_text = RequireMetadata(file, path, "scene");
  const auto provenance = file.metadata.find("provenance");
  if (provenance != file.metadata.end()) tensors.provenance = provenance->second;
  return tensors;
}

}  // namespace

VerifiedMotion ReadVerifiedMotion(const std::string& path) {
  const Safetensors file = ReadSafetensors(path);
  VerifyMotionHeader(file, path);
  VerifiedMotion motion;
  motion.tensors = ToMotionTensors(file, path);
  ValidateMotionTensors(motion.tensors, path);
  motion.sha256 = Sha256Hex({file.length_bytes, file.header, file.data});
  return motion;
}

}  // namespace clothid
