#include "datasets/motion/motion_file.h"

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
