// Points that are compared with the surface in corrections of a rollout by its recording.
//
// The innovation of such a point is e = q - c, from the nearest point c = sum_k w_k x_k of the predicted cloth to the
// measured one (datasets/observation/surface_offset.h): along the normal, as in the cost. It asks the nodes around c to
// move so that the cloth comes to the point, and says hardly anything of how it is to move along itself: the
// displacement u of the nodes is the minimum of
//   sum_j omega (psi_j - u_j)^T N_j (psi_j - u_j) + ..,   u_j = sum_k w_jk u_k,   N_j = n_j n_j^T + .01 (I - n_j n_j^T)
// with psi_j what the loss leaves of e_j, n_j the normal of the cloth at c, sum_k w_jk m_k over its length
// (costs/assimilation/vertex_normals.h), and omega = min(1, N/M) with N nodes and M points in the frame: a dense cloud
// counts as if every node were seen once. The minimum is K u = b, to which the points add
//   K = .. + sum_j omega w_j w_j^T x N_j,   b = .. + sum_j omega w_j x N_j psi_j.
//
// Which feature of the cloth is nearest is held fixed in derivatives, nothing else is: e, w and n follow the nodes, and
//   K du = .. + sum_j omega (dw_j x N_j r_j + w_j x (dN_j r_j + N_j (dpsi_j - sum_k dw_jk u_k))),   r_j = psi_j - u_j,
//   dN_j r_j = .99 ((n_j . r_j) dn_j + n_j (dn_j . r_j)).
#ifndef CLOTHID_COSTS_ASSIMILATION_SURFACE_PAIRS_H_
#define CLOTHID_COSTS_ASSIMILATION_SURFACE_PAIRS_H_

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "costs/assimilation/assimilation.h"
#include "costs/assimilation/vertex_normals.h"
#include "datasets/observation/cloud_observation.h"

namespace clothid {

// Of one frame, at one place of the nodes.
class SurfacePairs {
 public:
  // `nodes` [3N] m. `weight`: omega is multiplied by it. `influence` may be empty.
  // `faces` [3 x F] must outlive the object.
  SurfacePairs(const CloudObservation& clouds, int frame, const Eigen::Matrix3Xi* faces, const Eigen::VectorXd& nodes,
               double weight, const InfluenceOf& influence);

  // Adds the part of K; `add` is called with two nodes and their block.
  void AddMatrix(const std::function<void(int row, int column, const Eigen::Matrix3d& block)>& add) const;
  // Adds the part of b [3N].
  void AddRight(Eigen::VectorXd* right) const;
  // What follows is at the solution u [3N], zero at nodes that do not move.
  void SetSolution(const Eigen::VectorXd& solution);
  // Adds K du of changes of the nodes [3N x s], and the transpose.
  void AddTimes(const Eigen::MatrixXd& changes, Eigen::MatrixXd* right) const;
  void AddTimesTransposed(const Eigen::MatrixXd& by_right, Eigen::MatrixXd* by_nodes) const;

 private:
  struct Pair {
    SurfaceOffset offset;
    Eigen::Vector3d counted = Eigen::Vector3d::Zero();    // psi
    Eigen::Matrix3d slope = Eigen::Matrix3d::Identity();  // dpsi/de
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();     // n
    double length = 1.0;                                  // |sum_k w_k m_k|
    Eigen::Matrix3d metric = Eigen::Matrix3d::Zero();     // N
    // Of K du by the nodes of the pair, and by m of them.
    Eigen::Matrix<double, 9, 9> by_nodes, by_normals;
  };

  VertexNormals normals_;
  std::vector<Pair> pairs_;
  double weight_ = 0.0;  // omega
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_ASSIMILATION_SURFACE_PAIRS_H_
