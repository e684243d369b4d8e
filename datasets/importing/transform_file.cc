#include "datasets/importing/transform_file.h"

#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "datasets/formats/ros_csv.h"
#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"
#include "sim/matrix/dense.h"

namespace clothid {
namespace {

constexpr double kRotationTolerance = 1e-3;    // of R^T R - I, for matrices that were printed with few digits
constexpr double kUnitLengthTolerance = 1e-2;  // of a quaternion

Eigen::Quaterniond ToQuaternion(const Eigen::Vector4d& xyzw) {
  return Eigen::Quaterniond(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
}

std::vector<double> Numbers(const JsonNode& list, std::size_t count) {
  const std::vector<JsonNode> items = list.items();
  if (items.size() != count) list.Fail("expected " + std::to_string(count) + " numbers");
  std::vector<double> numbers;
  for (const JsonNode& item : items) numbers.push_back(item.Number());
  return numbers;
}

Eigen::Matrix4d ReadMatrix(const JsonNode& node) {
  std::vector<double> numbers;
  const std::vector<JsonNode> items = node.items();
  if (items.size() == 4) {
    for (const JsonNode& row : items) {
      const std::vector<double> values = Numbers(row, 4);
      numbers.insert(numbers.end(), values.begin(), values.end());
    }
  } else if (items.size() == 16) {
    numbers = Numbers(node, 16);
  } else {
    node.Fail("expected four rows of four numbers");
  }
  return Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
}

Eigen::Isometry3d ToIsometry(const JsonNode& node, const Eigen::Matrix4d& matrix) {
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  if (matrix.row(3) != Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0)) node.Fail("expected the last row to be 0, 0, 0, 1");
  const double error = (rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(error <= kRotationTolerance)) node.Fail("expected a rotation, found one that scales or shears");
  if (!(rotation.determinant() > 0.0)) node.Fail("expected a rotation, found one that mirrors");
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  transform.linear() = NearestRotation(rotation);
  transform.translation() = matrix.topRightCorner<3, 1>();
  return transform;
}

Eigen::Isometry3d ReadJsonTransform(const std::string& path) {
  const JsonValue document = ParseJson(ReadText(path, kMaxJsonBytes), path);
  const JsonNode root(document, path);
  root.ExpectKeys({"matrix", "rotation", "translation"});
  const auto matrix = root.Find("matrix"), rotation = root.Find("rotation"), translation = root.Find("translation");
  if (matrix.has_value() == (rotation || translation)) {
    root.Fail("expected either \"matrix\" or \"rotation\" and \"translation\"");
  }
  if (matrix) return ToIsometry(*matrix, ReadMatrix(*matrix));
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  if (translation) transform.translation() = translation->Vector3();
  if (rotation) {
    const std::vector<double> numbers = Numbers(*rotation, 4);
    const Eigen::Vector4d xyzw = Eigen::Map<const Eigen::Vector4d>(numbers.data());
    if (!(std::abs(xyzw.stableNorm() - 1.0) <= kUnitLengthTolerance)) {
      rotation->Fail("expected a quaternion [qx, qy, qz, qw] of unit length");
    }
    transform.linear() = ToQuaternion(xyzw).normalized().toRotationMatrix();
  }
  return transform;
}

}  // namespace

Eigen::Isometry3d ReadTransform(const std::string& path) {
  if (!IsRosCsv(path)) return ReadJsonTransform(path);
  const PoseTrack poses = ReadRosPoses(path);
  const Eigen::Index last = poses.times.size() - 1;
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  transform.linear() = ToQuaternion(poses.rotations.col(last)).toRotationMatrix();
  transform.translation() = poses.positions.col(last);
  return transform;
}

}  // namespace clothid
