#include "datasets/importing/point_map.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/matrix/dense.h"

namespace clothid {
namespace {

constexpr int kMaxAlignments = 50;
constexpr double kAligned = 1e-9;    // a move of this share of the points' extent ends the alignment
constexpr double kCollinear = 1e-3;  // second extent of points that leave a rotation open, to the first

std::string NameOf(const PointTracks& tracks, int point) {
  const std::string number = "point " + std::to_string(point);
  return tracks.labels.empty() ? number : number + " ('" + Printable(tracks.labels[point]) + "')";
}

struct Place {
  double squared_distance = std::numeric_limits<double>::infinity();
  int index = 0;  // of the node or the triangle
  Eigen::Vector3d weights = Eigen::Vector3d::UnitX();
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

// Barycentric coordinates of the point of segment a b that is nearest to p: the weight of b.
double OnSegment(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& p) {
  return std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
}

// Of the point of a triangle that is nearest to p: inside, or else on the nearest of its edges.
Eigen::Vector3d NearestWeights(const Eigen::Matrix3d& corners, const Eigen::Vector3d& p) {
  const Eigen::Vector3d normal = (corners.col(1) - corners.col(0)).cross(corners.col(2) - corners.col(0));
  Eigen::Vector3d weights;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d from = corners.col((k + 1) % 3), to = corners.col((k + 2) % 3);
    weights[k] = normal.dot((to - from).cross(p - from)) / normal.squaredNorm();
  }
  if (weights.minCoeff() >= 0.0) return weights;
  double nearest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    const double share = OnSegment(corners.col(k), corners.col(next), p);
    const Eigen::Vector3d position = (1.0 - share) * corners.col(k) + share * corners.col(next);
    if ((position - p).squaredNorm() >= nearest) continue;
    nearest = (position - p).squaredNorm();
    weights.setZero();
    weights[k] = 1.0 - share;
    weights[next] = share;
  }
  return weights;
}

Place NearestNode(const Mesh& mesh, const Eigen::Vector3d& p) {
  Place place;
  Eigen::Index node = 0;
  place.squared_distance = (mesh.rest_positions.colwise() - p).colwise().squaredNorm().minCoeff(&node);
  place.index = static_cast<int>(node);
  place.position = mesh.rest_positions.col(node);
  return place;
}

// The triangles of a mesh in spheres, so that far ones are passed over.
class NearestTriangle {
 public:
  explicit NearestTriangle(const Mesh& mesh) : mesh_(mesh), centers_(3, mesh.num_faces()), radii_(mesh.num_faces()) {
    for (int face = 0; face < mesh.num_faces(); ++face) {
      const Eigen::Matrix3d corners = Corners(face);
      centers_.col(face) = corners.rowwise().mean();
      radii_[face] = (corners.colwise() - centers_.col(face)).colwise().norm().maxCoeff();
    }
  }

  Place At(const Eigen::Vector3d& p) const {
    Place best;
    double distance = best.squared_distance;
    for (int face = 0; face < mesh_.num_faces(); ++face) {
      if ((centers_.col(face) - p).norm() - radii_[face] > distance) continue;
      const Eigen::Matrix3d corners = Corners(face);
      const Eigen::Vector3d weights = NearestWeights(corners, p);
      const Eigen::Vector3d position = corners * weights;
      if ((position - p).squaredNorm() >= best.squared_distance) continue;
      best = {(position - p).squaredNorm(), face, weights, position};
      distance = std::sqrt(best.squared_distance);
    }
    return best;
  }

 private:
  Eigen::Matrix3d Corners(int face) const {
    Eigen::Matrix3d corners;
    for (int k = 0; k < 3; ++k) corners.col(k) = mesh_.rest_positions.col(mesh_.faces(k, face));
    return corners;
  }

  const Mesh& mesh_;
  Eigen::Matrix3Xd centers_;
  Eigen::VectorXd radii_;
};

double MedianEdge(const Mesh& mesh) {
  std::vector<double> lengths;
  for (int face = 0; face < mesh.num_faces(); ++face) {
    for (int k = 0; k < 3; ++k) {
      lengths.push_back(
          (mesh.rest_positions.col(mesh.faces(k, face)) - mesh.rest_positions.col(mesh.faces((k + 1) % 3, face)))
              .norm());
    }
  }
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return *middle;
}

int FrameToPlace(const PointTracks& tracks) {
  int best = 0;
  Eigen::Index most = -1;
  for (int frame = 0; frame < tracks.num_frames(); ++frame) {
    const Eigen::Index num_seen =
        tracks.num_points() -
        tracks.positions.col(frame).reshaped(3, tracks.num_points()).colwise().sum().array().isNaN().count();
    if (num_seen > most) {
      most = num_seen;
      best = frame;
    }
  }
  return best;
}

// Every point's place, after the points [3 x P] are moved onto the rest shape.
template <typename NearestPlace>
std::vector<Place> PlaceAll(Eigen::Matrix3Xd points, const NearestPlace& nearest) {
  const Eigen::Vector3d mean = points.rowwise().mean();  // once, not once for every point
  const double extent = (points.colwise() - mean).colwise().norm().maxCoeff();
  std::vector<Place> places(static_cast<std::size_t>(points.cols()));
  Eigen::Matrix3Xd targets = points;
  for (int i = 0; i < kMaxAlignments; ++i) {
    for (Eigen::Index p = 0; p < points.cols(); ++p) {
      places[p] = nearest(points.col(p));
      targets.col(p) = places[p].position;
    }
    if (points.cols() < 3 || IsCollinear(points, kCollinear) || IsCollinear(targets, kCollinear)) break;
    const Eigen::Matrix3Xd moved = RigidMotion(points, targets) * points;
    const bool aligned = (moved - points).colwise().norm().maxCoeff() <= kAligned * extent;
    points = moved;
    if (aligned) break;
  }
  return places;
}

// Every point's place in a frame; all of them are seen there and near enough.
std::vector<Place> PlaceFrame(const PointTracks& tracks, int frame, const Mesh& mesh, const PlacementOptions& options) {
  const Eigen::Matrix3Xd points = tracks.positions.col(frame).reshaped(3, tracks.num_points());
  for (int p = 0; p < tracks.num_points(); ++p) {
    if (!points.col(p).allFinite()) {
      FailOnData(tracks.name, NameOf(tracks, p) + " is not seen in frame " + std::to_string(frame) +
                                  ", where most are; expected a map from points to places on the mesh");
    }
  }
  const NearestTriangle triangles(mesh);
  const std::vector<Place> places =
      options.on_triangles ? PlaceAll(points, [&](const Eigen::Vector3d& p) { return triangles.At(p); })
                           : PlaceAll(points, [&](const Eigen::Vector3d& p) { return NearestNode(mesh, p); });
  const double limit = options.max_distance > 0.0 ? options.max_distance : 0.5 * MedianEdge(mesh);
  for (int p = 0; p < tracks.num_points(); ++p) {
    const double distance = std::sqrt(places[p].squared_distance);
    if (!(distance <= limit)) {
      FailOnData(tracks.name, NameOf(tracks, p) + " is " + std::to_string(distance) +
                                  " m off the mesh at rest in frame " + std::to_string(frame) + "; expected at most " +
                                  std::to_string(limit) + " m, and a rest shape that lies near the points");
    }
  }
  return places;
}

std::vector<int> AllPoints(const PointTracks& tracks) {
  std::vector<int> points(static_cast<std::size_t>(tracks.num_points()));
  for (std::size_t p = 0; p < points.size(); ++p) points[p] = static_cast<int>(p);
  return points;
}

}  // namespace

PointMap MapToNodes(const PointTracks& tracks, const Mesh& mesh) {
  if (tracks.num_points() != mesh.num_nodes()) {
    FailOnData(tracks.name, "has " + std::to_string(tracks.num_points()) + " points; expected the " +
                                std::to_string(mesh.num_nodes()) +
                                " nodes of the mesh, or a map from points to places on it");
  }
  PointMap map;
  map.points = AllPoints(tracks);
  return map;
}

PointMap MapToNearest(const PointTracks& tracks, const Mesh& mesh, const PlacementOptions& options) {
  const int frame = FrameToPlace(tracks);
  const std::vector<Place> places = PlaceFrame(tracks, frame, mesh, options);
  PointMap map;
  map.points = AllPoints(tracks);
  if (options.on_triangles) map.barycentric.resize(3, tracks.num_points());
  std::map<int, int> taken;
  for (int p = 0; p < tracks.num_points(); ++p) {
    const Place& place = places[p];
    if (options.on_triangles) {
      map.face_index.push_back(place.index);
      map.barycentric.col(p) = place.weights / place.weights.sum();
      continue;
    }
    const auto [other, is_first] = taken.emplace(place.index, p);
    if (!is_first) {
      FailOnData(tracks.name, NameOf(tracks, other->second) + " and " + NameOf(tracks, p) +
                                  " are both nearest to node " + std::to_string(place.index));
    }
    map.node_index.push_back(place.index);
  }
  return map;
}

Mesh MakePointGrid(const std::array<int, 2>& nodes, const std::array<double, 2>& size, bool second_axis_first) {
  GridOptions grid;
  grid.nodes = nodes;
  grid.size = size;
  if (!second_axis_first) return MakeGrid(grid);
  std::swap(grid.nodes[0], grid.nodes[1]);
  std::swap(grid.size[0], grid.size[1]);
  std::swap(grid.axes[0], grid.axes[1]);
  Mesh mesh = MakeGrid(grid);
  mesh.faces.row(1).swap(mesh.faces.row(2));  // its normal along z again
  return mesh;
}

}  // namespace clothid
