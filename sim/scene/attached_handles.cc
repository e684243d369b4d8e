#include "sim/scene/attached_handles.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/matrix/dense.h"

namespace clothid {
namespace {

constexpr double kStraight = 1e-3;  // of a row of nodes, relative to its length
constexpr double kAlongRow = 1e-6;  // of a direction

// The ends of the steps and half way.
Eigen::VectorXd StepTimes(const Scene& scene) {
  Eigen::VectorXd times(2 * scene.num_steps() + 1);
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    times[i] = scene.start_time + 0.5 * static_cast<double>(i) * scene.time_step;
  }
  return times;
}

Eigen::Matrix3Xd InitialPlaces(const Scene& scene, const std::vector<int>& nodes) {
  return scene.initial_positions.reshaped(3, scene.mesh.num_nodes())(Eigen::all, nodes);
}

// How a row of nodes is turned from place to place: as a body, or, where it is straight, the shortest way.
class RowTurn {
 public:
  explicit RowTurn(const Eigen::Matrix3Xd& rest) : rest_(rest), is_straight_(IsCollinear(rest, kStraight)) {
    if (is_straight_) along_ = Along(rest);
  }

  // From the rest shape to `places`, which follow those of the call before.
  const Eigen::Matrix3d& To(const Eigen::Matrix3Xd& places) {
    if (is_straight_) {
      const Eigen::Vector3d along = Along(places);
      rotation_ = ShortestTurn(along_, along) * rotation_;
      along_ = along;
    } else {
      rotation_ = RigidMotion(rest_, places).rotation();
    }
    return rotation_;
  }

  // Its direction, as it is now.
  std::optional<Eigen::Vector3d> straight_row() const { return is_straight_ ? std::optional(along_) : std::nullopt; }

 private:
  // From the middle of a row to its far end, in the order of the nodes at rest.
  Eigen::Vector3d Along(const Eigen::Matrix3Xd& places) {
    const Eigen::Vector3d middle = rest_.rowwise().mean();
    Eigen::Index far = 0;
    (rest_.colwise() - middle).colwise().squaredNorm().maxCoeff(&far);
    return (places.col(far) - places.rowwise().mean()).normalized();
  }

  Eigen::Matrix3Xd rest_;
  bool is_straight_;
  Eigen::Vector3d along_ = Eigen::Vector3d::UnitX();
  Eigen::Matrix3d rotation_ = Eigen::Matrix3d::Identity();
};

// Where some of the handles are over time.
class HandlePlaces {
 public:
  HandlePlaces(const Scene& scene, const std::vector<int>& nodes) : scene_(scene), nodes_(nodes) {
    const std::vector<int>& handles = scene.handles.nodes;
    for (const int node : nodes) {
      handles_.push_back(static_cast<int>(std::find(handles.begin(), handles.end(), node) - handles.begin()));
    }
  }

  Eigen::Matrix3Xd At(double time) const {
    const HandlePath& path = scene_.handles.path;
    if (path.num_handles() == 0) return InitialPlaces(scene_, nodes_);
    return path.At(time).reshaped(3, path.num_handles())(Eigen::all, handles_);
  }

 private:
  const Scene& scene_;
  const std::vector<int>& nodes_;
  std::vector<int> handles_;  // their numbers among the scene's
};

// That turns `slopes` until their mean has the direction `to`: about `row`, where it is straight.
Eigen::Matrix3d TurnTo(const Eigen::Vector3d& to, const Eigen::Matrix3Xd& slopes,
                       const std::optional<Eigen::Vector3d>& row) {
  const auto across = [&](const Eigen::Vector3d& vector) {
    return (row ? vector - vector.dot(*row) * *row : vector).eval();
  };
  const Eigen::Vector3d from = across(slopes.rowwise().mean()), target = across(to);
  if (!(target.norm() > kAlongRow * to.norm())) {
    throw Error(ErrorKind::kBadData, "expected a direction that leaves the row of nodes");
  }
  if (!row) return ShortestTurn(from, target);
  const double angle = std::atan2(row->dot(from.cross(target)), from.dot(target));
  return Eigen::AngleAxisd(angle, *row).toRotationMatrix();
}

// The slopes of a clamp at `times` [3C x K]. They are counted from the start or, of a clamp that a body takes along,
// from where that begins, so that a recording of a part of a motion has the slopes of the whole.
Eigen::MatrixXd SlopesOf(const Clamp& clamp, const std::vector<ClampedEdge>& edges, const Eigen::VectorXd& times,
                         const Scene& scene) {
  const HandlePlaces places(scene, clamp.nodes);
  Eigen::Matrix3Xd first_places = places.At(scene.start_time);
  Eigen::Matrix3d body_first = Eigen::Matrix3d::Identity();
  if (clamp.body != nullptr) {
    const AffineMap start = clamp.body->At(scene.start_time).pose, first = clamp.body->At(clamp.body->times()[0]).pose;
    body_first = first.leftCols<3>();
    first_places = start.leftCols<3>().transpose() * (first_places.colwise() - start.col(3)).eval();
    first_places = ((body_first * first_places).colwise() + first.col(3)).eval();
  }
  RowTurn turn(scene.mesh.rest_positions(Eigen::all, clamp.nodes));
  const Eigen::Matrix3d from = turn.To(first_places);
  Eigen::Matrix3Xd slopes = from * RestSlopes(scene.mesh, edges);
  if (clamp.direction) slopes = (TurnTo(*clamp.direction, slopes, turn.straight_row()) * slopes).eval();
  Eigen::MatrixXd all(slopes.size(), times.size());
  for (Eigen::Index k = 0; k < times.size(); ++k) {
    const Eigen::Matrix3d rotation =
        clamp.body == nullptr ? (turn.To(places.At(times[k])) * from.transpose()).eval()
                              : (clamp.body->At(times[k]).pose.leftCols<3>() * body_first.transpose()).eval();
    all.col(k) = (rotation * slopes).reshaped();
  }
  return all;
}

bool Turns(const Clamp& clamp, const Scene& scene) {
  return clamp.body != nullptr || scene.handles.path.times().size() > 1;
}

}  // namespace

HandlePath AttachedPath(const Scene& scene, const std::vector<int>& nodes, const RigidPath& body) {
  const AffineMap start = body.At(scene.start_time).pose;
  // In axes of the body.
  const Eigen::Matrix3Xd places =
      start.leftCols<3>().transpose() * (InitialPlaces(scene, nodes).colwise() - start.col(3));
  const Eigen::VectorXd times = StepTimes(scene);
  Eigen::MatrixXd positions(places.size(), times.size());
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    const AffineMap pose = body.At(times[i]).pose;
    positions.col(i) = ((pose.leftCols<3>() * places).colwise() + pose.col(3)).reshaped();
  }
  return HandlePath(times, positions);
}

HandlePath JoinPaths(const Scene& scene, const std::vector<std::vector<int>>& groups,
                     const std::vector<HandlePath>& paths) {
  if (groups.size() == 1) return paths[0];
  Eigen::VectorXd times;
  Eigen::Index num_rows = 0;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    num_rows += 3 * static_cast<Eigen::Index>(groups[i].size());
    const Eigen::VectorXd& own = paths[i].times();
    const bool is_known = own.size() == 0 || (times.size() == own.size() && times == own);
    if (!is_known) times = times.size() == 0 ? own : StepTimes(scene);
  }
  if (times.size() == 0) return {};
  Eigen::MatrixXd positions(num_rows, times.size());
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const Eigen::Index own_rows = 3 * static_cast<Eigen::Index>(groups[i].size());
    const Eigen::VectorXd stands = InitialPlaces(scene, groups[i]).reshaped();
    for (Eigen::Index k = 0; k < times.size(); ++k) {
      positions.col(k).segment(row, own_rows) = paths[i].num_handles() > 0 ? paths[i].At(times[k]) : stands;
    }
    row += own_rows;
  }
  return HandlePath(times, positions);
}

void ClampHandles(const std::vector<Clamp>& clamps, Scene* scene) {
  Handles& handles = scene->handles;
  handles.clamped.clear();
  handles.slopes = {};
  if (clamps.empty()) return;
  const bool turns =
      std::any_of(clamps.begin(), clamps.end(), [&](const Clamp& clamp) { return Turns(clamp, *scene); });
  const Eigen::VectorXd times = turns ? StepTimes(*scene) : Eigen::VectorXd::Constant(1, scene->start_time);
  Eigen::MatrixXd slopes(0, times.size());
  for (const Clamp& clamp : clamps) {
    const std::vector<ClampedEdge> edges = ClampedEdges(scene->mesh, clamp.nodes);
    if (edges.empty()) {
      throw Error(ErrorKind::kBadData, "expected two nodes or more that an edge of the cloth joins, beside free nodes");
    }
    handles.clamped.insert(handles.clamped.end(), edges.begin(), edges.end());
    slopes.conservativeResize(3 * static_cast<Eigen::Index>(handles.clamped.size()), Eigen::NoChange);
    slopes.bottomRows(3 * static_cast<Eigen::Index>(edges.size())) = SlopesOf(clamp, edges, times, *scene);
  }
  handles.slopes = HandlePath(times, slopes);
}

}  // namespace clothid
