#include "tests/sim/random_scene.h"

#include <algorithm>
#include <limits>
#include <sstream>

#include "sim/obstacle/box.h"
#include "sim/obstacle/round_shapes.h"
#include "sim/obstacle/triangulated_surface.h"
#include "tests/sim/random_numbers.h"

namespace clothid {
namespace {

constexpr int kMaxNodes = 60;

// Each node of a grid moved within its plane, by less than would turn a triangle over, and each diagonal either way.
void MakeIrregular(const GridOptions& grid, RandomNumbers* random, Mesh* mesh) {
  constexpr double kMostShift = 0.2;  // of the spacing
  const auto [columns, rows] = grid.nodes;
  for (auto position : mesh->rest_positions.colwise()) {
    const Eigen::VectorXd shift = kMostShift * random->InCube(2);
    position.x() += shift[0] * grid.size[0] / (columns - 1);
    position.y() += shift[1] * grid.size[1] / (rows - 1);
  }
  for (Eigen::Index quad = 0; 2 * quad < mesh->faces.cols(); ++quad) {
    const int a = static_cast<int>(quad % (columns - 1) + columns * (quad / (columns - 1)));
    const int b = a + 1, c = a + columns, d = c + 1;
    const bool rising = random->Chance(0.5);
    mesh->faces.col(2 * quad) = rising ? Eigen::Vector3i(a, b, d) : Eigen::Vector3i(a, b, c);
    mesh->faces.col(2 * quad + 1) = rising ? Eigen::Vector3i(a, d, c) : Eigen::Vector3i(b, d, c);
  }
}

// One piece in the xy plane, of at most `max_nodes` nodes and about `size`.
Mesh MakePiece(int max_nodes, double size, RandomNumbers* random, std::ostream* words) {
  Mesh mesh;
  if (max_nodes < 4 || random->Chance(0.05)) {
    mesh.rest_positions = size * Eigen::Matrix3d{{0.0, 1.0, 0.3}, {0.0, 0.1, 0.8}, {0.0, 0.0, 0.0}};
    mesh.faces.resize(3, 1);
    mesh.faces << 0, 1, 2;
    *words << "triangle";
    return mesh;
  }
  const bool is_strip = random->Chance(0.2);
  GridOptions grid;
  grid.nodes[0] = random->Integer(2, std::min(8, max_nodes / 2));
  grid.nodes[1] = is_strip ? 2 : random->Integer(2, std::min(8, max_nodes / grid.nodes[0]));
  grid.size[0] = size;
  grid.size[1] = is_strip ? 0.2 * size : random->Uniform(0.5, 1.0) * size;
  mesh = MakeGrid(grid);
  const bool is_irregular = random->Chance(0.5);
  if (is_irregular) MakeIrregular(grid, random, &mesh);
  *words << (is_irregular ? "irregular " : "grid ") << grid.nodes[0] << "x" << grid.nodes[1];
  return mesh;
}

void Append(const Mesh& piece, const Eigen::Vector3d& offset, Mesh* mesh) {
  const Eigen::Index nodes = mesh->rest_positions.cols(), faces = mesh->faces.cols();
  mesh->rest_positions.conservativeResize(3, nodes + piece.rest_positions.cols());
  mesh->rest_positions.rightCols(piece.rest_positions.cols()) = piece.rest_positions.colwise() + offset;
  mesh->faces.conservativeResize(3, faces + piece.faces.cols());
  mesh->faces.rightCols(piece.faces.cols()) = piece.faces.array() + static_cast<int>(nodes);
}

class Builder {
 public:
  Builder(std::uint64_t seed, const RandomSceneOptions& options)
      : random_(seed), options_(options), by_patches_(seed % 2 == 1) {
    words_ << "seed " << seed << ": ";
  }

  RandomScene Build() {
    AddMesh();
    AddTimes();
    AddMaterial();
    AddForces();
    AddStart();
    if (options_.handles && random_.Chance(0.7)) AddHandles();
    if (options_.obstacles) AddObstacles();
    if (options_.air && random_.Chance(0.3)) AddDirectionalDrag();
    result_.description = words_.str();
    return std::move(result_);
  }

 private:
  void AddMesh() {
    size_ = random_.OverOctaves(0.1, 4);
    const bool two_pieces = random_.Chance(0.2);
    Mesh& mesh = scene_.mesh;
    mesh = MakePiece(two_pieces ? kMaxNodes / 2 : kMaxNodes, size_, &random_, &words_);
    if (two_pieces) {
      words_ << " + ";
      const Mesh second = MakePiece(kMaxNodes / 2, 0.7 * size_, &random_, &words_);
      Append(second, size_ * Eigen::Vector3d(0.1, 0.2, 0.4), &mesh);
    }
    const Eigen::Vector3d offset = size_ * random_.InCube(3);
    mesh.rest_positions = (random_.Rotation() * mesh.rest_positions).eval().colwise() + offset;
    words_ << " of " << size_ << " m";
  }

  void AddTimes() {
    const int num_steps = random_.Integer(4, 14);
    scene_.integrator = Integrator::kEuler;
    scene_.time_step = random_.OverOctaves(1e-3, 4);
    scene_.duration = num_steps * scene_.time_step;
    scene_.start_time = random_.Chance(0.5) ? 0.0 : random_.Uniform(-1.0, 1.0);
    words_ << ", " << num_steps << " steps of " << scene_.time_step << " s";
  }

  void AddMaterial() {
    Material& material = scene_.material;
    material.density = random_.OverOctaves(0.02, 7);
    material.stretch_stiffness = random_.OverOctaves(1.0, 13);
    if (random_.Chance(0.7)) {
      material.bending_stiffness = material.stretch_stiffness * size_ * size_ * random_.OverOctaves(1e-6, 13);
      scene_.bending = by_patches_ ? Bending{BendingLaw::kPatches, 0.3} : Bending{BendingLaw::kEdges};
    }
    if (random_.Chance(0.3)) {
      material.damping = material.stretch_stiffness * scene_.time_step * random_.OverOctaves(0.05, 6);
    }
    words_ << ", density " << material.density << ", k " << material.stretch_stiffness << ", k_b "
           << material.bending_stiffness << (by_patches_ ? " by patches" : "") << ", damping " << material.damping;
  }

  void AddForces() {
    scene_.gravity = random_.Chance(0.15) ? Eigen::Vector3d::Zero() : Eigen::Vector3d(9.81 * random_.Direction());
    if (random_.Chance(0.2)) scene_.node_force = 0.01 * random_.InCube(3);
    if (!options_.air || random_.Chance(0.5)) return;
    scene_.material.drag = random_.OverOctaves(0.01, 7);
    words_ << ", drag " << scene_.material.drag;
    if (random_.Chance(0.5)) scene_.wind.mean = 3.0 * random_.InCube(3);
    if (random_.Chance(0.5)) {
      scene_.wind.gust = 3.0 * random_.InCube(3);
      scene_.wind.frequency = random_.Uniform(-50.0, 50.0);
      scene_.wind.wave_vector = (3.0 / size_) * random_.InCube(3);
      words_ << ", gusts";
    }
  }

  void AddDirectionalDrag() {
    Material& material = scene_.material;
    scene_.air_law = random_.Chance(0.5) ? AirLaw::kQuadratic : AirLaw::kLinear;
    material.normal_drag = random_.OverOctaves(0.05, 5);
    material.tangential_drag = random_.Chance(0.5) ? 0.0 : random_.OverOctaves(0.02, 4);
    material.added_mass = random_.Chance(0.5) ? 0.0 : random_.OverOctaves(0.02, 5);
    words_ << ", drag " << material.normal_drag << " across and " << material.tangential_drag << " along the cloth"
           << (scene_.air_law == AirLaw::kQuadratic ? ", quadratic" : "") << ", added mass " << material.added_mass;
  }

  // Turned, strained by up to a tenth, and shaken.
  void AddStart() {
    const Mesh& mesh = scene_.mesh;
    const Eigen::Vector3d stretch = Eigen::Vector3d::Ones() + 0.1 * random_.InCube(3);
    const Eigen::Vector3d offset = size_ * random_.InCube(3);
    const Eigen::Matrix3d turn = random_.Rotation() * stretch.asDiagonal();
    Eigen::Matrix3Xd positions = (turn * mesh.rest_positions).eval().colwise() + offset;
    positions +=
        0.02 * size_ / std::sqrt(mesh.num_nodes()) * random_.InCube(positions.size()).reshaped(3, mesh.num_nodes());
    const Eigen::Vector3d drift = random_.InCube(3), spin = 3.0 * random_.InCube(3);
    const Eigen::Vector3d centre = positions.rowwise().mean();
    Eigen::Matrix3Xd velocities = 0.2 * random_.InCube(positions.size()).reshaped(3, mesh.num_nodes());
    for (int node = 0; node < mesh.num_nodes(); ++node) {
      velocities.col(node) += drift + spin.cross(positions.col(node) - centre);
    }
    scene_.initial_positions = positions.reshaped();
    scene_.initial_velocities = velocities.reshaped();
  }

  void AddHandles() {
    const int num_nodes = scene_.mesh.num_nodes();
    const std::vector<int> nodes = random_.Permutation(num_nodes);
    scene_.handles.nodes.assign(nodes.begin(), nodes.begin() + random_.Integer(1, std::min(4, num_nodes - 1)));
    const int num_handles = static_cast<int>(scene_.handles.nodes.size());
    for (const int node : scene_.handles.nodes) scene_.initial_velocities.segment<3>(3 * node).setZero();
    const bool move = random_.Chance(0.5);
    words_ << ", " << num_handles << (move ? " moving" : " fixed") << " handles";
    if (!move) return;
    const int num_knots = random_.Integer(2, 5);
    const Eigen::VectorXd times =
        Eigen::VectorXd::LinSpaced(num_knots, 0.0, scene_.duration).array() + scene_.start_time;
    Eigen::MatrixXd path(3 * num_handles, num_knots);
    for (int i = 0; i < num_handles; ++i) {
      path.block(3 * i, 0, 3, 1) = scene_.initial_positions.segment<3>(3 * scene_.handles.nodes[i]);
    }
    const double most = 1.5 * scene_.duration / num_knots;  // m, at 1.5 m/s
    for (int knot = 1; knot < num_knots; ++knot) {
      path.col(knot) = path.col(knot - 1) + most * random_.InCube(3).replicate(num_handles, 1);
    }
    scene_.handles.path = HandlePath(times, path);
  }

  void AddObstacles() {
    const bool gap_mode = random_.Chance(0.6);
    scene_.contact_mode = gap_mode ? ContactMode::kGap : ContactMode::kVelocity;
    scene_.touch = random_.OverOctaves(1e-5, 10);
    scene_.depenetration_speed = random_.OverOctaves(0.25, 4);
    const int count = random_.Integer(0, 3);
    for (int i = 0; i < count; ++i) AddObstacle("obstacle" + std::to_string(i));
    words_ << (gap_mode ? ", gap mode" : ", velocity mode");
  }

  void AddObstacle(const std::string& name) {
    SceneObstacle obstacle;
    obstacle.name = name;
    obstacle.friction_coefficient = random_.Chance(0.1) ? 0.0 : random_.OverOctaves(0.05, 5);
    obstacle.contact_distance = random_.Chance(0.5) ? 0.0 : 0.02 * size_;
    // On the side to which the cloth falls or flies, as near to it as it comes in a few steps.
    const Eigen::Vector3d travel =
        scene_.initial_velocities.reshaped(3, scene_.mesh.num_nodes()).rowwise().mean() + 0.05 * scene_.gravity;
    const Eigen::Vector3d direction = (travel.stableNormalized() + 0.5 * random_.InCube(3)).normalized();
    Shape shape = MakeShape(direction);
    const double gap = (random_.Chance(0.3) ? -0.03 : 0.03) * random_.Uniform(0.0, 1.0) * size_;
    const double excess = SmallestGap(shape) - obstacle.contact_distance - gap;
    shape.Shift(-excess * direction);
    obstacle.shape = shape.Make();
    words_ << ", mu " << obstacle.friction_coefficient;
    scene_.obstacles.push_back(obstacle);
    result_.shapes.push_back(shape);
  }

  // Beyond the cloth in `direction`, seen from its middle.
  Shape MakeShape(const Eigen::Vector3d& direction) {
    Shape shape;
    shape.kind = static_cast<Shape::Kind>(random_.Integer(0, 7));
    const Eigen::Vector3d middle = scene_.initial_positions.reshaped(3, scene_.mesh.num_nodes()).rowwise().mean();
    shape.point = middle + 2.0 * size_ * direction;
    shape.radius = random_.Uniform(0.3, 0.8) * size_;
    shape.normal = -direction;
    if (shape.kind == Shape::Kind::kPlane) {
      words_ << ", plane";
    } else if (shape.kind == Shape::Kind::kSphere) {
      words_ << ", sphere";
    } else if (shape.kind == Shape::Kind::kSurface) {
      const bool is_cube = random_.Chance(0.5);
      shape.surface = is_cube ? CubeMesh(shape.radius) : IcosphereMesh(random_.Integer(0, 1), shape.radius);
      shape.surface.vertices = (random_.Rotation() * shape.surface.vertices).eval().colwise() + shape.point;
      words_ << (is_cube ? ", cube" : ", icosphere");
    } else if (shape.kind == Shape::Kind::kBox) {
      shape.size = 2.0 * shape.radius * (Eigen::Vector3d::Ones() + 0.3 * random_.InCube(3));
      shape.rotation = random_.Rotation();
      shape.thickness = random_.Chance(0.3) ? 0.0 : random_.Uniform(0.0, 0.5) * shape.size.minCoeff();
      words_ << (shape.thickness > 0.0 ? ", round box" : ", box");
    } else {
      FinishLongOrHollow(&shape);
    }
    return shape;
  }

  void FinishLongOrHollow(Shape* shape) {
    if (shape->kind == Shape::Kind::kCapsule || shape->kind == Shape::Kind::kCylinder) {
      shape->end = shape->point + size_ * random_.Direction();
      words_ << (shape->kind == Shape::Kind::kCapsule ? ", capsule" : ", cylinder");
      return;
    }
    shape->normal = (shape->normal + 0.3 * random_.InCube(3)).normalized();
    shape->thickness = random_.Uniform(0.1, 0.4) * shape->radius;
    shape->angle = random_.Uniform(0.5, 2.5);
    words_ << (shape->kind == Shape::Kind::kTorus ? ", torus" : ", bowl");
  }

  double SmallestGap(const Shape& shape) const {
    const std::shared_ptr<const Obstacle> obstacle = shape.Make();
    double smallest = std::numeric_limits<double>::infinity();
    for (int node = 0; node < scene_.mesh.num_nodes(); ++node) {
      smallest = std::min(smallest, obstacle->Closest(scene_.initial_positions.segment<3>(3 * node)).gap);
    }
    return smallest;
  }

  RandomNumbers random_;
  const RandomSceneOptions& options_;
  const bool by_patches_;  // the law of bending
  RandomScene result_;
  Scene& scene_ = result_.scene;
  std::ostringstream words_;
  double size_ = 0.0;  // m
};

}  // namespace

void Shape::Shift(const Eigen::Vector3d& offset) {
  point += offset;
  end += offset;
  surface.vertices.colwise() += offset;
}

std::shared_ptr<const Obstacle> Shape::Make() const {
  switch (kind) {
    case Kind::kPlane:
      return std::make_shared<Plane>(point, normal);
    case Kind::kSphere:
      return std::make_shared<Sphere>(point, radius);
    case Kind::kCapsule:
      return std::make_shared<Capsule>(point, end, radius);
    case Kind::kBox:
      return std::make_shared<Box>(point, size, Eigen::Quaterniond(rotation), thickness);
    case Kind::kCylinder:
      return std::make_shared<Cylinder>(point, end, radius);
    case Kind::kTorus:
      return std::make_shared<Torus>(point, normal, radius, thickness);
    case Kind::kBowl:
      return std::make_shared<Bowl>(point, normal, radius, angle, thickness);
    case Kind::kSurface:
      break;
  }
  return std::make_shared<TriangulatedSurface>(surface.vertices, surface.faces);
}

RandomScene MakeRandomScene(std::uint64_t seed, const RandomSceneOptions& options) {
  return Builder(seed, options).Build();
}

}  // namespace clothid
