#include "sim/shell/seam_energy.h"

#include <algorithm>
#include <utility>

namespace clothid {
namespace {

std::array<int, 3> LinkedNodes(const SeamLink& link) { return {link.node, link.edge[0], link.edge[1]}; }

std::array<double, 3> LinkWeights(const SeamLink& link) { return {1.0, link.share - 1.0, -link.share}; }

}  // namespace

Eigen::SparseMatrix<double> SeamMatrix(const Mesh& mesh) {
  std::vector<Eigen::Triplet<double>> triplets;
  for (const SeamLink& link : mesh.links) {
    const std::array<int, 3> nodes = LinkedNodes(link);
    const std::array<double, 3> weights = LinkWeights(link);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double entry = link.stiffness * (weights[i] * weights[k]);
        if (entry != 0.0) triplets.emplace_back(nodes[i], nodes[k], entry);
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(mesh.num_nodes(), mesh.num_nodes());
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

SeamEnergy::SeamEnergy(const Mesh& mesh, Eigen::SparseMatrix<double> matrix, const std::vector<int>& free_index,
                       const BlockPattern& pattern)
    : quadratic_(std::move(matrix), free_index, pattern) {
  for (const SeamLink& link : mesh.links) {
    Link own{LinkedNodes(link), LinkWeights(link), link.stiffness, link.closing_time, Eigen::Vector3d::Zero()};
    for (std::size_t i = 0; i < 3; ++i) own.offset += own.weights[i] * mesh.rest_positions.col(own.nodes[i]);
    links_.push_back(own);
  }
}

Eigen::Vector3d SeamEnergy::Gap(const Link& link, double time, const Eigen::VectorXd& positions) {
  Eigen::Vector3d gap = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 3; ++i) gap += link.weights[i] * positions.segment<3>(3 * link.nodes[i]);
  if (time < link.closing_time) gap -= std::min(1.0, 1.0 - time / link.closing_time) * link.offset;
  return gap;
}

double SeamEnergy::AddForce(double time, const Eigen::VectorXd& positions, Eigen::VectorXd* force) const {
  double energy = 0.0;
  for (const Link& link : links_) {
    const Eigen::Vector3d gap = Gap(link, time, positions);
    energy += 0.5 * link.stiffness * gap.squaredNorm();
    for (std::size_t i = 0; i < 3; ++i) {
      force->segment<3>(3 * link.nodes[i]) -= link.stiffness * link.weights[i] * gap;
    }
  }
  return energy;
}

double SeamEnergy::Power(double time, const Eigen::VectorXd& positions) const {
  double power = 0.0;
  for (const Link& link : links_) {
    if (link.closing_time == 0.0 || time < 0.0 || time > link.closing_time) continue;
    power += link.stiffness / link.closing_time * Gap(link, time, positions).dot(link.offset);
  }
  return power;
}

}  // namespace clothid
