// Orders that the points of a regular grid may have been given by mistake.
#ifndef CLOTHID_DATASETS_CHECKING_GRID_ORDERS_H_
#define CLOTHID_DATASETS_CHECKING_GRID_ORDERS_H_

#include <Eigen/Core>
#include <vector>

namespace clothid {

// Renumberings of points that lie on a grid at rest: those that turn or mirror the grid, and the transposed order.
// `order[p]` is the point that stands where p should. The first one is the identity. Only that where the points
// [3 x P] m are no grid.
std::vector<std::vector<int>> GridOrders(const Eigen::Matrix3Xd& rest_points);

// The frames whose points come in another of `orders` than in most frames: successive frames fit three times better in
// that one. `spacing` m is the distance of neighbours at rest.
std::vector<int> FlippedFrames(const Eigen::MatrixXd& positions, const std::vector<std::vector<int>>& orders,
                               double spacing);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CHECKING_GRID_ORDERS_H_
