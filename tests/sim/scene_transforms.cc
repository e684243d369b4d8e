#include "tests/sim/scene_transforms.h"

#include <cstddef>

#include "tests/sim/random_numbers.h"

namespace clothid {
namespace {

Shape Moved(Shape shape, const TurnAndShift& motion) {
  shape.point = motion.OfPoints(shape.point);
  shape.end = motion.OfPoints(shape.end);
  shape.normal = motion.OfVectors(shape.normal);
  shape.rotation = motion.rotation * shape.rotation;
  if (shape.surface.vertices.cols() > 0) shape.surface.vertices = motion.OfPoints(shape.surface.vertices);
  return shape;
}

Shape Rescaled(Shape shape, double length) {
  shape.point *= length;
  shape.end *= length;
  shape.radius *= length;
  shape.thickness *= length;
  shape.size *= length;
  shape.surface.vertices *= length;
  return shape;
}

ParameterRange Rescaled(ParameterRange range, double unit) {
  range.nominal *= unit;
  range.lower_bound *= unit;
  range.upper_bound *= unit;
  return range;
}

}  // namespace

Eigen::MatrixXd TurnAndShift::OfVectors(const Eigen::MatrixXd& vectors) const {
  Eigen::MatrixXd result(vectors.rows(), vectors.cols());
  for (Eigen::Index row = 0; row < vectors.rows(); row += 3) {
    result.middleRows<3>(row) = rotation * vectors.middleRows<3>(row);
  }
  return result;
}

Eigen::MatrixXd TurnAndShift::OfPoints(const Eigen::MatrixXd& points) const {
  const Eigen::VectorXd offset = translation.replicate(points.rows() / 3, 1);
  return OfVectors(points).colwise() + offset;
}

Scene Moved(const RandomScene& original, const TurnAndShift& motion, const TurnAndShift& rest) {
  Scene scene = original.scene;
  scene.mesh.rest_positions = rest.OfPoints(scene.mesh.rest_positions);
  scene.wind.wave_vector = rest.OfVectors(scene.wind.wave_vector);
  scene.wind.shear = rest.OfVectors(scene.wind.shear);
  scene.gravity = motion.OfVectors(scene.gravity);
  scene.node_force = motion.OfVectors(scene.node_force);
  scene.wind.mean = motion.OfVectors(scene.wind.mean);
  scene.wind.gust = motion.OfVectors(scene.wind.gust);
  scene.initial_positions = motion.OfPoints(scene.initial_positions);
  scene.initial_velocities = motion.OfVectors(scene.initial_velocities);
  const HandlePath& path = scene.handles.path;
  if (path.num_handles() > 0) scene.handles.path = HandlePath(path.times(), motion.OfPoints(path.positions()));
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    scene.obstacles[i].shape = Moved(original.shapes[i], motion).Make();
  }
  return scene;
}

double Units::Of(ParameterKind kind, AirLaw law) const {
  switch (kind) {
    case ParameterKind::kFriction:
      return 1.0;
    case ParameterKind::kStretchStiffness:
    case ParameterKind::kWarpStiffness:
    case ParameterKind::kWeftStiffness:
    case ParameterKind::kShearStiffness:
    case ParameterKind::kPoissonStiffness:
      return force() / length;
    case ParameterKind::kBendingStiffness:
    case ParameterKind::kWarpBending:
    case ParameterKind::kWeftBending:
    case ParameterKind::kTwistBending:
      return force() * length;
    case ParameterKind::kDensity:
      return mass / (length * length);
    case ParameterKind::kDrag:
      return mass / (length * length * time);
    case ParameterKind::kNormalDrag:
    case ParameterKind::kTangentialDrag:
      return mass / (length * length * (law == AirLaw::kQuadratic ? length : time));
    case ParameterKind::kAddedMass:
      return mass / (length * length);
    case ParameterKind::kDamping:
      return force() / speed();
    default:
      return speed();  // of wind
  }
}

Parameters Rescaled(const Parameters& parameters, const Units& units, AirLaw law) {
  Parameters result = parameters;
  for (const ParameterKind kind : MaterialKinds()) result.material.*RowOf(kind).constant *= units.Of(kind, law);
  return result;
}

Scene Rescaled(const RandomScene& original, const Units& units) {
  Scene scene = original.scene;
  scene.time_step *= units.time;
  scene.start_time *= units.time;
  scene.duration *= units.time;
  scene.gravity *= units.acceleration();
  scene.node_force *= units.force();
  scene.wind.mean *= units.speed();
  scene.wind.gust *= units.speed();
  scene.wind.frequency /= units.time;
  scene.wind.wave_vector /= units.length;
  scene.wind.shear /= units.length;
  scene.depenetration_speed *= units.speed();
  scene.mesh.rest_positions *= units.length;
  scene.initial_positions *= units.length;
  scene.initial_velocities *= units.speed();
  const HandlePath& path = scene.handles.path;
  if (path.num_handles() > 0) {
    scene.handles.path = HandlePath(path.times() * units.time, path.positions() * units.length);
  }
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    scene.obstacles[i].shape = Rescaled(original.shapes[i], units.length).Make();
    scene.obstacles[i].contact_distance *= units.length;
  }
  Parameters parameters;
  parameters.material = scene.material;
  scene.material = Rescaled(parameters, units, scene.air_law).material;
  for (auto& [name, range] : scene.parameters) {
    range = Rescaled(range, units.Of(ParseParameter(name, scene.obstacle_names()).kind));
  }
  return scene;
}

Eigen::VectorXd Renumbered(const Eigen::VectorXd& state, const std::vector<int>& new_index) {
  Eigen::VectorXd result(state.size());
  for (std::size_t i = 0; i < new_index.size(); ++i) {
    result.segment<3>(3 * new_index[i]) = state.segment<3>(3 * static_cast<Eigen::Index>(i));
  }
  return result;
}

Scene Renumbered(const Scene& original, const std::vector<int>& new_index, std::uint64_t seed) {
  RandomNumbers random(seed);
  Scene scene = original;
  scene.mesh.rest_positions =
      Renumbered(original.mesh.rest_positions.reshaped(), new_index).reshaped(3, original.mesh.rest_positions.cols());
  scene.initial_positions = Renumbered(original.initial_positions, new_index);
  scene.initial_velocities = Renumbered(original.initial_velocities, new_index);

  const std::vector<int> faces = random.Permutation(original.mesh.num_faces());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const int turn = random.Integer(0, 2);
    for (int corner = 0; corner < 3; ++corner) {
      scene.mesh.faces(corner, faces[f]) = new_index[original.mesh.faces((corner + turn) % 3, static_cast<int>(f))];
    }
  }

  const std::vector<int>& nodes = original.handles.nodes;
  const std::vector<int> handles = random.Permutation(static_cast<int>(nodes.size()));
  for (std::size_t i = 0; i < nodes.size(); ++i) scene.handles.nodes[handles[i]] = new_index[nodes[i]];
  const HandlePath& path = original.handles.path;
  if (path.num_handles() > 0) {
    Eigen::MatrixXd positions = path.positions();
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      positions.middleRows<3>(3 * handles[i]) = path.positions().middleRows<3>(3 * static_cast<Eigen::Index>(i));
    }
    scene.handles.path = HandlePath(path.times(), positions);
  }
  return scene;
}

}  // namespace clothid
