#include "identify/checks/lasting_force.h"

#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

#include "sim/cloth/cloth_model.h"
#include "sim/shell/triangle_element.h"

namespace clothid {
namespace {

// The sum over frames from the second on of the inner products of f_i and f_{i+lag} that `product` takes, over their
// number.
template <typename Product>
double MeanProduct(const Eigen::MatrixXd& forces, Eigen::Index lag, const Product& product) {
  const Eigen::Index num = forces.cols() - 1 - lag;
  double sum = 0.0;
  for (Eigen::Index i = 1; i <= num; ++i) sum += product(forces.col(i), forces.col(i + lag));
  return sum / static_cast<double>(num);
}

}  // namespace

LastingForce DescribeLastingForce(const Eigen::MatrixXd& forces, const Eigen::VectorXd& times,
                                  const ClothModel& cloth) {
  constexpr Eigen::Index kLeastFrames = 5;
  if (forces.cols() < kLeastFrames || cloth.num_free() == 0) return {};
  const Eigen::SparseMatrix<double> laplacian = LaplacianMatrix(cloth.triangles(), cloth.num_nodes());
  double area = 0.0;
  for (const int node : cloth.free_nodes()) area += cloth.node_areas()[node];
  const auto by_area = [&](const auto& a, const auto& b) {
    double sum = 0.0;
    for (const int node : cloth.free_nodes()) {
      sum += cloth.node_areas()[node] * a.template segment<3>(3 * node).dot(b.template segment<3>(3 * node));
    }
    return sum / (3.0 * area);
  };
  const auto by_gradient = [&](const auto& a, const auto& b) {  // a^T L b, edges to handles left out
    double sum = 0.0;
    for (const int node : cloth.free_nodes()) {
      for (Eigen::SparseMatrix<double>::InnerIterator it(laplacian, node); it; ++it) {
        const auto other = static_cast<int>(it.row());
        if (other >= node || cloth.free_index()[other] < 0) continue;
        const Eigen::Vector3d da = a.template segment<3>(3 * node) - a.template segment<3>(3 * other);
        const Eigen::Vector3d db = b.template segment<3>(3 * node) - b.template segment<3>(3 * other);
        sum -= it.value() * da.dot(db);
      }
    }
    return sum / (3.0 * area);
  };
  const double next = MeanProduct(forces, 1, by_area), after = MeanProduct(forces, 2, by_area);
  if (!(next > 0.0)) return {};
  const Eigen::Index last = times.size() - 1;
  const double interval = (times[last] - times[0]) / static_cast<double>(last);
  const double shortest = std::exp(-1.0), longest = std::exp(-1.0 / static_cast<double>(last));
  const double kept = std::clamp(after / next, shortest, longest);
  const double edge = std::sqrt(cloth.node_areas().mean()), size = std::sqrt(area);
  const double slope = MeanProduct(forces, 1, by_gradient);
  const double length = slope > 0.0 ? std::sqrt(next / slope) : size;
  return {std::sqrt(next / kept), interval / -std::log(kept), std::clamp(length, std::min(edge, size), size)};
}

}  // namespace clothid
