#include "datasets/motion/motion_file.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include "datasets/files/atomic_file.h"
#include "datasets/files/safetensors.h"
#include "datasets/files/sha256.h"
#include "datasets/motion/motion_container.h"
#include "datasets/motion/motion_header.h"
#include "datasets/motion/motion_validation.h"

namespace clothid {
namespace {

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

void AddForces(const ForceReadings& forces, std::vector<TensorBytes>* result) {
  if (forces.is_empty()) return;
  const long long num_groups = forces.num_groups();
  // As of positions, every missing component is the same NaN.
  const Eigen::MatrixXd values =
      forces.values.array().isNaN().select(std::numeric_limits<double>::quiet_NaN(), forces.values);
  result->push_back({"force_times", TensorType::kF64, {forces.times.size()}, ToBytes<double>(forces.times)});
  result->push_back({"handle_forces", TensorType::kF64, {forces.times.size(), num_groups, 3}, ToBytes<double>(values)});
  if (forces.moments.size() > 0) {
    result->push_back(
        {"handle_moments", TensorType::kF64, {forces.times.size(), num_groups, 3}, ToBytes<double>(forces.moments)});
  }
  result->push_back({"force_sigma", TensorType::kF64, {num_groups}, ToBytes<double>(forces.sigma)});
}

// What is double in every file.
void AddDoubles(const MotionTensors& tensors, std::vector<TensorBytes>* result) {
  const TensorType f64 = TensorType::kF64;
  const long long num_points = tensors.positions.rows() / 3;
  const long long num_handles = static_cast<long long>(tensors.handle_index.size());
  result->push_back({"times", f64, {tensors.times.size()}, ToBytes<double>(tensors.times)});
  result->push_back(
      {"rest_positions", f64, {tensors.mesh.num_nodes(), 3}, ToBytes<double>(tensors.mesh.rest_positions)});
  const Mesh& mesh = tensors.mesh;
  if (mesh.has_corner_rest()) {
    result->push_back({"corner_rest", f64, {mesh.num_faces(), 3, 2}, ToBytes<double>(mesh.corner_rest)});
  }
  if (!mesh.links.empty()) {
    Eigen::Matrix3Xd values(3, static_cast<Eigen::Index>(mesh.links.size()));
    for (Eigen::Index i = 0; i < values.cols(); ++i) {
      const SeamLink& link = mesh.links[static_cast<std::size_t>(i)];
      values.col(i) << link.share, link.stiffness, link.closing_time;
    }
    result->push_back({"link_values", f64, {values.cols(), 3}, ToBytes<double>(values)});
  }
  if (!tensors.face_index.empty()) {
    result->push_back({"barycentric", f64, {num_points, 3}, ToBytes<double>(tensors.barycentric)});
  }
  if (num_handles > 0) {
    const long long num_knots = tensors.handle_positions.cols();
    result->push_back(
        {"handle_positions", f64, {num_knots, num_handles, 3}, ToBytes<double>(tensors.handle_positions)});
  }
  if (tensors.handle_times.size() > 0) {
    result->push_back({"handle_times", f64, {tensors.handle_times.size()}, ToBytes<double>(tensors.handle_times)});
  }
  if (tensors.sigma.size() > 0) result->push_back({"sigma", f64, {num_points}, ToBytes<double>(tensors.sigma)});
  AddForces(tensors.forces, result);
  for (const auto& [name, positions] : tensors.sequences) {
    result->push_back({std::string(kSequencePrefix) + name,
                       f64,
                       {positions.cols(), positions.rows() / 3, 3},
                       ToBytes<double>(positions)});
  }
  if (tensors.cloud_sigma > 0.0) {
    result->push_back({"cloud_sigma", f64, {1}, ToBytes<double>(Eigen::VectorXd::Constant(1, tensors.cloud_sigma))});
  }
}

// What was measured, double or single; first what is double.
void AddMeasured(const MotionTensors& tensors, std::vector<TensorBytes>* result) {
  const long long num_times = tensors.times.size(), num_points = tensors.positions.rows() / 3;
  std::vector<int> offsets;
  const Eigen::Matrix3Xd cloud = JoinClouds(tensors.clouds, &offsets);
  if (!tensors.clouds.empty() && !tensors.single_precision_clouds) {
    result->push_back({"cloud_positions", TensorType::kF64, {cloud.cols(), 3}, ToBytes<double>(cloud)});
  }
  // Every missing coordinate is written as the same NaN: the same motion gives the same bytes.
  const Eigen::MatrixXd positions =
      tensors.positions.array().isNaN().select(std::numeric_limits<double>::quiet_NaN(), tensors.positions);
  result->push_back({"positions",
                     tensors.single_precision ? TensorType::kF32 : TensorType::kF64,
                     {num_times, num_points, 3},
                     tensors.single_precision ? ToBytes<float>(positions) : ToBytes<double>(positions)});
  if (tensors.clouds.empty()) return;
  if (tensors.single_precision_clouds) {
    result->push_back({"cloud_positions", TensorType::kF32, {cloud.cols(), 3}, ToBytes<float>(cloud)});
  }
  result->push_back({"cloud_offsets", TensorType::kI32, {num_times + 1}, ToBytes(offsets)});
}

void AddSewing(const Mesh& mesh, std::vector<TensorBytes>* result) {
  std::vector<int> folds, nodes;
  for (const std::array<int, 2>& fold : mesh.folds) folds.insert(folds.end(), fold.begin(), fold.end());
  for (const SeamLink& link : mesh.links) nodes.insert(nodes.end(), {link.node, link.edge[0], link.edge[1]});
  const auto num_folds = static_cast<long long>(mesh.folds.size()),
             num_links = static_cast<long long>(mesh.links.size());
  if (num_folds > 0) result->push_back({"folds", TensorType::kI32, {num_folds, 2}, ToBytes(folds)});
  if (num_links > 0) result->push_back({"link_nodes", TensorType::kI32, {num_links, 3}, ToBytes(nodes)});
}

void AddIndices(const MotionTensors& tensors, std::vector<TensorBytes>* result) {
  result->push_back(
      {"faces", TensorType::kI32, {tensors.mesh.num_faces(), 3}, ToBytes<std::int32_t>(tensors.mesh.faces)});
  AddSewing(tensors.mesh, result);
  const auto add = [&](const char* name, const std::vector<int>& indices) {
    if (indices.empty()) return;
    result->push_back({name, TensorType::kI32, {static_cast<long long>(indices.size())}, ToBytes(indices)});
  };
  add("node_index", tensors.node_index);
  add("face_index", tensors.face_index);
  add("point_kind", tensors.point_kind);
  add("handle_index", tensors.handle_index);
  if (tensors.forces.groups.empty()) return;
  std::vector<int> nodes, offsets = {0};
  for (const std::vector<int>& group : tensors.forces.groups) {
    nodes.insert(nodes.end(), group.begin(), group.end());
    offsets.push_back(static_cast<int>(nodes.size()));
  }
  add("force_nodes", nodes);
  add("force_offsets", offsets);
}

// The doubles come first, so that every tensor stands on a multiple of its element size.
std::vector<TensorBytes> ToContainer(const MotionTensors& tensors) {
  std::vector<TensorBytes> result;
  AddDoubles(tensors, &result);
  AddMeasured(tensors, &result);
  AddIndices(tensors, &result);
  return result;
}

}  // namespace

MotionTensors ReadMotionTensors(const std::string& path) { return ReadVerifiedMotion(path).tensors; }

void WriteMotion(const MotionTensors& tensors, const std::string& path) {
  ValidateMotionTensors(tensors, path);
  const std::vector<TensorBytes> container = ToContainer(tensors);
  std::string data;
  for (const TensorBytes& tensor : container) data += tensor.bytes;
  const std::string header = MotionHeader(tensors.scene_text, tensors.provenance, Sha256Hex({data}), container);
  WriteFileAtomically(path, {LengthBytes(header.size()), header, data});
}

}  // namespace clothid
