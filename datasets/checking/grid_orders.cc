#include "datasets/checking/grid_orders.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "datasets/checking/track_statistics.h"

namespace clothid {
namespace {

constexpr double kMaxExtent = 1e6;       // of the spacing: no grid has more points along an axis
constexpr double kSamePlace = 0.1;       // of the spacing
constexpr double kSameDirection = 0.99;  // cosine
constexpr double kFlip = 3.0;            // how much better another order has to fit
constexpr double kLeastShift = 0.5;      // of the spacing: by which a wrong order moves points at least

// Points of a plane by their place, with coordinates in units of the spacing.
class PlaneIndex {
 public:
  explicit PlaneIndex(const Eigen::Matrix2Xd& points) : points_(points) {
    for (int p = 0; p < static_cast<int>(points.cols()); ++p) cells_[CellOf(points.col(p))].push_back(p);
  }

  std::optional<int> Find(const Eigen::Vector2d& place) const {
    const Cell cell = CellOf(place);
    for (long long u = cell.first - 1; u <= cell.first + 1; ++u) {
      for (long long v = cell.second - 1; v <= cell.second + 1; ++v) {
        const auto found = cells_.find({u, v});
        if (found == cells_.end()) continue;
        for (const int p : found->second) {
          if ((points_.col(p) - place).norm() <= kSamePlace) return p;
        }
      }
    }
    return std::nullopt;
  }

 private:
  using Cell = std::pair<long long, long long>;
  static Cell CellOf(const Eigen::Vector2d& place) { return {std::llround(place[0]), std::llround(place[1])}; }

  const Eigen::Matrix2Xd& points_;
  std::map<Cell, std::vector<int>> cells_;
};

// Coordinates in the plane of the points, in units of their spacing, along the line from the first point to the nearest
// other one; nothing where the points are not in a plane.
std::optional<Eigen::Matrix2Xd> InPlane(const Eigen::Matrix3Xd& points) {
  Eigen::VectorXd distances = (points.colwise() - points.col(0)).colwise().norm().transpose();
  distances[0] = std::numeric_limits<double>::infinity();
  Eigen::Index nearest = 0, farthest = 0;
  const double spacing = distances.minCoeff(&nearest);
  if (!(spacing > 0.0)) return std::nullopt;
  const Eigen::Vector3d along = (points.col(nearest) - points.col(0)) / spacing;
  const Eigen::Matrix3Xd centered = points.colwise() - points.rowwise().mean();
  const Eigen::Matrix3Xd across = centered - along * (along.transpose() * centered);
  const double width = across.colwise().norm().maxCoeff(&farthest);
  if (!(width > kSamePlace * spacing)) return std::nullopt;
  const Eigen::Vector3d second = across.col(farthest) / width;
  Eigen::Matrix2Xd plane(2, points.cols());
  plane.row(0) = along.transpose() * centered / spacing;
  plane.row(1) = second.transpose() * centered / spacing;
  if (!plane.allFinite() || plane.cwiseAbs().maxCoeff() > kMaxExtent) return std::nullopt;
  const double off_plane = (along.cross(second).transpose() * centered).cwiseAbs().maxCoeff();
  if (off_plane > kSamePlace * spacing) return std::nullopt;
  return plane;
}

// Where `turn` takes the points of the grid; nothing where it does not take them to points.
std::optional<std::vector<int>> OrderOf(const Eigen::Matrix2Xd& points, const PlaneIndex& index,
                                        const Eigen::Matrix2d& turn) {
  std::vector<int> order;
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    const std::optional<int> image = index.Find(turn * points.col(p));
    if (!image) return std::nullopt;
    order.push_back(*image);
  }
  return order;
}

// The order in which the other axis runs fastest; empty where the points are not listed line by line.
std::vector<int> TransposedOrder(const Eigen::Matrix3Xd& points) {
  const Eigen::Index count = points.cols();
  const Eigen::Vector3d first = (points.col(1) - points.col(0)).normalized();
  Eigen::Index line = 1;
  while (line < count && (points.col(line) - points.col(line - 1)).normalized().dot(first) > kSameDirection) ++line;
  if (line == count || line < 2 || count % line != 0) return {};
  const Eigen::Index num_lines = count / line;
  std::vector<int> order(static_cast<std::size_t>(count));
  for (Eigen::Index i = 0; i < line; ++i) {
    for (Eigen::Index j = 0; j < num_lines; ++j) {
      order[static_cast<std::size_t>(i + line * j)] = static_cast<int>(j + num_lines * i);
    }
  }
  return order;
}

// How far a frame in `order` is from `reference` [3 x P], up to a shift of the whole: the root mean square over the
// points, m.
double Misfit(const Eigen::Matrix3Xd& frame, const std::vector<int>& order, const Eigen::Matrix3Xd& reference) {
  Eigen::Matrix3Xd moved(3, frame.cols());
  Eigen::Index num_seen = 0;
  for (Eigen::Index p = 0; p < frame.cols(); ++p) {
    const Eigen::Vector3d difference = frame.col(order[static_cast<std::size_t>(p)]) - reference.col(p);
    if (difference.allFinite()) moved.col(num_seen++) = difference;
  }
  if (2 * num_seen < frame.cols()) return std::numeric_limits<double>::quiet_NaN();
  const Eigen::Vector3d mean = moved.leftCols(num_seen).rowwise().mean();  // once, not once for every point
  return std::sqrt((moved.leftCols(num_seen).colwise() - mean).squaredNorm() / static_cast<double>(num_seen));
}

Eigen::Matrix3Xd InOrder(const Eigen::Matrix3Xd& frame, const std::vector<int>& order) {
  return frame(Eigen::all, order);
}

}  // namespace

std::vector<std::vector<int>> GridOrders(const Eigen::Matrix3Xd& rest_points) {
  std::vector<int> identity;
  for (int p = 0; p < static_cast<int>(rest_points.cols()); ++p) identity.push_back(p);
  std::vector<std::vector<int>> orders = {identity};
  if (rest_points.cols() < 4) return orders;
  const auto add = [&](const std::vector<int>& order) {
    if (!order.empty() && std::find(orders.begin(), orders.end(), order) == orders.end()) orders.push_back(order);
  };
  if (const std::optional<Eigen::Matrix2Xd> plane = InPlane(rest_points)) {
    const PlaneIndex index(*plane);
    for (int turn = 1; turn < 8; ++turn) {
      const double u = turn & 1 ? -1.0 : 1.0, v = turn & 2 ? -1.0 : 1.0;
      Eigen::Matrix2d matrix;
      matrix << u, 0.0, 0.0, v;
      if (turn & 4) matrix.col(0).swap(matrix.col(1));
      if (const auto order = OrderOf(*plane, index, matrix)) add(*order);
    }
    add(TransposedOrder(rest_points));
  }
  return orders;
}

std::vector<int> FlippedFrames(const Eigen::MatrixXd& positions, const std::vector<std::vector<int>>& orders,
                               double spacing) {
  const Eigen::Index num_points = positions.rows() / 3;
  std::vector<std::size_t> state(static_cast<std::size_t>(positions.cols()), 0);
  Eigen::Matrix3Xd reference = positions.col(0).reshaped(3, num_points);
  for (std::size_t frame = 1; frame < state.size(); ++frame) {
    const Eigen::Matrix3Xd points = positions.col(static_cast<Eigen::Index>(frame)).reshaped(3, num_points);
    std::size_t best = state[frame - 1];
    const double kept = Misfit(points, orders[best], reference);
    double least = kept / kFlip;
    for (std::size_t k = 0; k < orders.size() && kept > kLeastShift * spacing; ++k) {
      const double misfit = Misfit(points, orders[k], reference);
      if (!(misfit < least)) continue;
      least = misfit;
      best = k;
    }
    state[frame] = best;
    if (!std::isnan(kept)) reference = InOrder(points, orders[best]);
  }
  std::vector<long long> count(orders.size(), 0);
  for (const std::size_t k : state) ++count[k];
  const auto usual = static_cast<std::size_t>(std::max_element(count.begin(), count.end()) - count.begin());
  std::vector<int> flipped;
  for (std::size_t frame = 0; frame < state.size(); ++frame) {
    if (state[frame] != usual) flipped.push_back(static_cast<int>(frame));
  }
  return flipped;
}

}  // namespace clothid
