#include "costs/assimilation/vertex_normals.h"

#include <Eigen/Geometry>
#include <utility>

namespace clothid {
namespace {

// v x a for the columns a.
Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return matrix;
}

// The derivative of the normal of a face by its corner k: the side opposite of it, turned.
Eigen::Matrix3d ByCorner(const Eigen::Vector3i& corners, int k, const Eigen::VectorXd& nodes) {
  const Eigen::Vector3d next = nodes.segment<3>(3 * corners[(k + 1) % 3]);
  const Eigen::Vector3d last = nodes.segment<3>(3 * corners[(k + 2) % 3]);
  return CrossMatrix(last - next);
}

}  // namespace

VertexNormals::VertexNormals(const Eigen::Matrix3Xi* faces, Eigen::VectorXd nodes)
    : faces_(faces), nodes_(std::move(nodes)), normals_(Eigen::VectorXd::Zero(nodes_.size())) {
  for (const auto& corners : faces_->colwise()) {
    const Eigen::Vector3d first = nodes_.segment<3>(3 * corners[0]);
    const Eigen::Vector3d one = nodes_.segment<3>(3 * corners[1]), other = nodes_.segment<3>(3 * corners[2]);
    const Eigen::Vector3d normal = (one - first).cross(other - first);
    for (int k = 0; k < 3; ++k) normals_.segment<3>(3 * corners[k]) += normal;
  }
}

Eigen::MatrixXd VertexNormals::Times(const Eigen::MatrixXd& changes) const {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(changes.rows(), changes.cols());
  Eigen::Matrix<double, 3, Eigen::Dynamic> own(3, changes.cols());
  for (const auto& corners : faces_->colwise()) {
    own.setZero();
    for (int k = 0; k < 3; ++k) own += ByCorner(corners, k, nodes_) * changes.middleRows<3>(3 * corners[k]);
    for (int k = 0; k < 3; ++k) result.middleRows<3>(3 * corners[k]) += own;
  }
  return result;
}

void VertexNormals::AddTimesTransposed(const Eigen::MatrixXd& by_normals, Eigen::MatrixXd* by_nodes) const {
  Eigen::Matrix<double, 3, Eigen::Dynamic> own(3, by_normals.cols());
  for (const auto& corners : faces_->colwise()) {
    own.setZero();
    for (int k = 0; k < 3; ++k) own += by_normals.middleRows<3>(3 * corners[k]);
    for (int k = 0; k < 3; ++k) {
      by_nodes->middleRows<3>(3 * corners[k]) += ByCorner(corners, k, nodes_).transpose() * own;
    }
  }
}

}  // namespace clothid
