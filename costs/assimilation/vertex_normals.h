// Normals at the vertices of a cloth, and how they turn with it.
//
// m_k = sum of (x_b - x_a) x (x_c - x_a) over the faces (a, b, c) of vertex k, m^2: the sum of their normals, each
// times twice the area. What is interpolated between them, sum_k w_k m_k, turns continuously over the cloth.
#ifndef CLOTHID_COSTS_ASSIMILATION_VERTEX_NORMALS_H_
#define CLOTHID_COSTS_ASSIMILATION_VERTEX_NORMALS_H_

#include <Eigen/Core>

namespace clothid {

class VertexNormals {
 public:
  // `faces` [3 x F] and `nodes` [3N] m; the first must outlive the object.
  VertexNormals(const Eigen::Matrix3Xi* faces, Eigen::VectorXd nodes);

  Eigen::Vector3d At(int node) const { return normals_.segment<3>(3 * static_cast<Eigen::Index>(node)); }  // m_k
  // Of changes of the nodes, those of m [3N x s], and the transpose, added to `by_nodes` [3N x s].
  Eigen::MatrixXd Times(const Eigen::MatrixXd& changes) const;
  void AddTimesTransposed(const Eigen::MatrixXd& by_normals, Eigen::MatrixXd* by_nodes) const;

 private:
  const Eigen::Matrix3Xi* faces_;
  Eigen::VectorXd nodes_, normals_;  // [3N]
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_ASSIMILATION_VERTEX_NORMALS_H_
