// MuJoCo's flex (measured with MuJoCo 3.14.0): the membrane of a flex of dimension 2 with Poisson's ratio 0 is that of
// St. Venant and Kirchhoff with k = young thickness/4, and it bends by edges with k_edge = young thickness^3/48. So
//   thickness = sqrt(12 k_edge/k),   young = 4 k/thickness,   damping (s) = eta/k.
// Nodes are bodies of their own, for a flexcomp would give all of them the same mass.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <sstream>
#include <utility>

#include "identify/export/mujoco_geom.h"
#include "identify/export/simulator_exports.h"
#include "sim/base/text_file.h"
#include "sim/mesh/mesh.h"
#include "sim/obstacle/obstacle.h"

namespace clothid {
namespace {

constexpr double kThinnest = 1e-4;     // m: of a cloth that does not bend
constexpr double kLongestStep = 1e-3;  // s
constexpr int kNumDirections = 12;     // along which nodes are ordered
constexpr double kEqualWeights = 1e-6;

// An order of nodes and triangles in which MuJoCo bends every edge as it should.
//
// MuJoCo 3.14.0 keeps the ends of an edge in the order of their numbers, but computes its bending weights in the order
// in which its first triangle runs along it: where that is from the higher number to the lower one the weights of both
// ends are swapped. With its nodes in rising order, a triangle does so along the edge from its lowest to its highest
// node alone. Across that edge lies a triangle that spans more numbers, unless it is the longest edge of both: so
// triangles come by falling span, and what is left to choose is the numbers of the nodes.
struct FlexOrder {
  std::vector<int> nodes;  // [N] of the mesh, by their number in the flex
  Eigen::Matrix3Xi faces;  // [3 x F] of these numbers
  int num_swapped = 0;     // inner edges whose weights MuJoCo swaps and that differ
};

double Cotangent(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a.dot(b) / a.cross(b).norm(); }

// An inner edge and the nodes across it.
struct InnerEdge {
  int ends[2];
  int opposite[2];
  bool is_symmetric;  // both ends have the same weight
};

std::vector<InnerEdge> InnerEdges(const Mesh& mesh) {
  std::map<std::pair<int, int>, std::vector<int>> opposite;
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const std::pair<int, int> ends = std::minmax({mesh.faces(k, f), mesh.faces((k + 1) % 3, f)});
      opposite[ends].push_back(mesh.faces((k + 2) % 3, f));
    }
  }
  const auto x = [&](int node) -> Eigen::Vector3d { return mesh.rest_positions.col(node); };
  std::vector<InnerEdge> edges;
  for (const auto& [ends, nodes] : opposite) {
    if (nodes.size() < 2) continue;
    double first = 0.0, second = 0.0;  // the weight of an end: the sum of the cotangents at the other
    for (const int node : nodes) {
      first += Cotangent(x(ends.first) - x(ends.second), x(node) - x(ends.second));
      second += Cotangent(x(ends.second) - x(ends.first), x(node) - x(ends.first));
    }
    const bool is_symmetric = std::abs(first - second) < kEqualWeights * (1.0 + std::abs(first) + std::abs(second));
    edges.push_back({{ends.first, ends.second}, {nodes[0], nodes[1]}, is_symmetric});
  }
  return edges;
}

int CountSwapped(const std::vector<InnerEdge>& edges, const std::vector<int>& numbers) {
  return static_cast<int>(std::count_if(edges.begin(), edges.end(), [&](const InnerEdge& edge) {
    const auto [low, high] = std::minmax({numbers[edge.ends[0]], numbers[edge.ends[1]]});
    const auto lies_between = [&, low = low, high = high](int node) {
      return numbers[node] > low && numbers[node] < high;
    };
    return !edge.is_symmetric && lies_between(edge.opposite[0]) && lies_between(edge.opposite[1]);
  }));
}

std::vector<int> NodesAlong(const Mesh& mesh, const Eigen::Vector3d& direction) {
  const Eigen::VectorXd heights = mesh.rest_positions.transpose() * direction;
  std::vector<int> nodes(static_cast<std::size_t>(mesh.num_nodes()));
  std::iota(nodes.begin(), nodes.end(), 0);
  std::stable_sort(nodes.begin(), nodes.end(), [&](int a, int b) { return heights[a] < heights[b]; });
  return nodes;
}

std::vector<int> Inverse(const std::vector<int>& nodes) {
  std::vector<int> numbers(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) numbers[static_cast<std::size_t>(nodes[i])] = static_cast<int>(i);
  return numbers;
}

// Nodes rising in every triangle, triangles by falling span.
Eigen::Matrix3Xi OrderFaces(const Mesh& mesh, const std::vector<int>& numbers) {
  std::vector<Eigen::Vector3i> faces;
  for (int f = 0; f < mesh.num_faces(); ++f) {
    Eigen::Vector3i face = mesh.faces.col(f).unaryExpr([&](int node) { return numbers[node]; });
    std::sort(face.data(), face.data() + 3);
    faces.push_back(face);
  }
  std::stable_sort(faces.begin(), faces.end(),
                   [](const Eigen::Vector3i& a, const Eigen::Vector3i& b) { return a[2] - a[0] > b[2] - b[0]; });
  Eigen::Matrix3Xi result(3, mesh.num_faces());
  for (int f = 0; f < mesh.num_faces(); ++f) result.col(f) = faces[static_cast<std::size_t>(f)];
  return result;
}

// The best of the mesh's own order and of orders along some directions.
FlexOrder OrderFlex(const Mesh& mesh) {
  const std::vector<InnerEdge> edges = InnerEdges(mesh);
  FlexOrder best;
  best.nodes.resize(static_cast<std::size_t>(mesh.num_nodes()));
  std::iota(best.nodes.begin(), best.nodes.end(), 0);
  best.num_swapped = CountSwapped(edges, best.nodes);
  const Eigen::Vector3d first = mesh.rest_positions.col(mesh.faces(1, 0)) - mesh.rest_positions.col(mesh.faces(0, 0));
  const Eigen::Vector3d other = mesh.rest_positions.col(mesh.faces(2, 0)) - mesh.rest_positions.col(mesh.faces(0, 0));
  const Eigen::Vector3d u = first.normalized(), v = first.cross(other).cross(first).normalized();
  for (int i = 0; i < kNumDirections && best.num_swapped > 0; ++i) {
    const double angle = M_PI * (i + 0.25) / kNumDirections;  // along no edge of a grid
    const std::vector<int> nodes = NodesAlong(mesh, std::cos(angle) * u + std::sin(angle) * v);
    const int num_swapped = CountSwapped(edges, Inverse(nodes));
    if (num_swapped < best.num_swapped) best = {nodes, {}, num_swapped};
  }
  best.faces = OrderFaces(mesh, Inverse(best.nodes));
  return best;
}

struct FlexNumbers {
  double thickness = kThinnest, young = 0.0;  // m, Pa
};

void WriteBodies(const Scene& scene, const ExportConstants& constants, std::ostringstream* out) {
  const Eigen::VectorXd areas = NodeAreas(scene.mesh);
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
    const std::vector<int>& handles = scene.handles.nodes;
    const bool is_held = std::find(handles.begin(), handles.end(), node) != handles.end();
    *out << "    <body name=\"n" << node << "\" pos=\"" << MujocoNumbers(scene.initial_positions.segment<3>(3 * node))
         << "\">";
    if (!is_held) {
      *out << "<inertial pos=\"0 0 0\" mass=\"" << ShortestText(constants.density * areas[node])
           << "\" diaginertia=\"1e-9 1e-9 1e-9\"/><joint type=\"slide\" axis=\"1 0 0\"/>"
           << "<joint type=\"slide\" axis=\"0 1 0\"/><joint type=\"slide\" axis=\"0 0 1\"/>";
    }
    *out << "</body>\n";
  }
}

void WriteFlex(const FlexOrder& order, const ExportConstants& constants, const FlexNumbers& numbers,
               std::ostringstream* out) {
  *out << "    <flex name=\"cloth\" dim=\"2\" radius=\"" << ShortestText(std::max(constants.thickness, 1e-3))
       << "\" body=\"";
  for (std::size_t i = 0; i < order.nodes.size(); ++i) *out << (i > 0 ? " n" : "n") << order.nodes[i];
  *out << "\" element=\"";
  for (Eigen::Index i = 0; i < order.faces.size(); ++i) *out << (i > 0 ? " " : "") << order.faces.data()[i];
  *out << "\">\n      <elasticity young=\"" << ShortestText(numbers.young) << "\" poisson=\"0\" thickness=\""
       << ShortestText(numbers.thickness) << "\" damping=\"" << ShortestText(constants.damping) << "\" elastic2d=\""
       << (constants.edge_bending > 0.0 ? "both" : "stretch")
       << "\"/>\n"
       // Of a pair the larger friction counts; that of the obstacle has to be it.
       << "      <contact selfcollide=\"none\" internal=\"false\" friction=\"0 0.005 0.0001\" condim=\"3\"/>\n"
       << "    </flex>\n";
}

std::string Comment(const ExportConstants& constants, const FlexNumbers& numbers, const FlexOrder& order) {
  std::ostringstream out;
  out << "<!--\n"
      << Preamble(constants, "  ") << "\n  Numbers of MuJoCo, measured with 3.14.0 (poisson = 0):\n"
      << "    k = young thickness/4 (N/m), k_edge = young thickness^3/48 (N m), so\n"
      << "    thickness = sqrt(12 k_edge/k) = " << ShortestText(numbers.thickness)
      << " m, young = 4 k/thickness = " << ShortestText(numbers.young)
      << " Pa: constants of the model, not of the cloth\n"
      << "    damping = eta/k = " << ShortestText(constants.damping) << " s\n"
      << "    mass of a node = density times its area, kg\n"
      << "    Nodes and triangles stand in an order of their own (body n5 is node 5 of the cloth): 3.14.0 swaps the\n"
      << "    bending weights of an edge whose first triangle runs along it from a later node to an earlier one.\n"
      << "    Edges that are left with swapped weights: " << order.num_swapped << "\n"
      << "  Not mapped: of a pair MuJoCo takes the larger friction, and it is no Coulomb friction of contacts that "
         "are\n"
      << "    exactly hard: solref and solimp soften them. At most 50 contacts per geom and flex are kept.\n"
      << "    Steps of 1 ms damp a swinging cloth: take shorter ones for a motion. It starts at rest.\n"
      << "    radius is the half thickness in contacts; clothid measures gaps from the obstacle.\n";
  if (constants.self_contact) {
    out << "    The cloth goes through itself (selfcollide is none): a flex has one friction, so that mu.self would "
           "count\n"
        << "    at obstacles, too.\n";
  }
  out << "-->\n";
  return out.str();
}

// MuJoCo takes a mocap body for still in contacts, so that its friction carries nothing. So what moves is a body of its
// own, welded to the mocap body; planes cannot be.
bool IsWelded(const SceneObstacle& obstacle) {
  return obstacle.path != nullptr && dynamic_cast<const Plane*>(obstacle.shape.get()) == nullptr;
}

// Where its path has it first.
void WriteMovingObstacle(const SceneObstacle& obstacle, const std::string& geom, double start_time,
                         std::ostringstream* out) {
  const AffineMap pose = obstacle.path->At(start_time).pose;
  const Eigen::Quaterniond turn(Eigen::Matrix3d(pose.leftCols<3>()));
  const std::string place = "pos=\"" + MujocoNumbers(pose.col(3)) + "\" quat=\"" + ShortestText(turn.w()) + " " +
                            MujocoNumbers(turn.vec()) + "\"";
  *out << "    <!-- " << obstacle.name
       << " follows the path of the scene: set data.mocap_pos and data.mocap_quat at every step";
  if (IsWelded(obstacle)) {
    *out
        << ". It is welded to the mocap body, 4 steps behind, for friction of a mocap body itself carries nothing -->\n"
        << "    <body name=\"" << obstacle.name << ".path\" mocap=\"true\" " << place << "/>\n    <body name=\""
        << obstacle.name << "\" gravcomp=\"1\" " << place
        << ">\n    <freejoint/>\n    <inertial pos=\"0 0 0\" mass=\"10\" diaginertia=\"1 1 1\"/>\n";
  } else {
    *out << ". MuJoCo takes it for still in contacts: its friction carries nothing, that of a box would -->\n"
         << "    <body name=\"" << obstacle.name << "\" mocap=\"true\" " << place << ">\n";
  }
  *out << geom << "    </body>\n";
}

void WriteObstacles(const Scene& scene, const ExportConstants& constants, std::ostringstream* out) {
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    const SceneObstacle& obstacle = scene.obstacles[i];
    const std::string geom = MujocoGeom(obstacle, constants.friction[i].second);
    if (obstacle.path == nullptr) {
      *out << geom;
    } else {
      WriteMovingObstacle(obstacle, geom, scene.start_time, out);
    }
  }
}

// As stiff as MuJoCo allows: it raises the time constant to two steps. Obstacles do not touch each other.
void WriteWelds(const Scene& scene, std::ostringstream* out) {
  if (std::none_of(scene.obstacles.begin(), scene.obstacles.end(), IsWelded)) return;
  *out << "  <default>\n    <geom contype=\"0\"/>\n  </default>\n  <equality>\n";
  for (const SceneObstacle& obstacle : scene.obstacles) {
    if (!IsWelded(obstacle)) continue;
    *out << "    <weld body1=\"" << obstacle.name << ".path\" body2=\"" << obstacle.name << "\" solref=\"1e-6 1\"/>\n";
  }
  *out << "  </equality>\n";
}

}  // namespace

std::string MujocoXml(const Scene& scene, const ExportConstants& constants) {
  FlexNumbers numbers;
  if (constants.edge_bending > 0.0) {
    numbers.thickness = std::sqrt(12.0 * constants.edge_bending / constants.stiffness);
  }
  numbers.young = 4.0 * constants.stiffness / numbers.thickness;
  const FlexOrder order = OrderFlex(scene.mesh);
  std::ostringstream out;
  out << Comment(constants, numbers, order) << "<mujoco model=\"cloth\">\n  <option timestep=\""
      << ShortestText(std::min(kLongestStep, scene.time_step)) << "\" gravity=\"" << MujocoNumbers(scene.gravity)
      << "\" integrator=\"discrete\" solver=\"CG\" cone=\"elliptic\"/>\n  <size memory=\"100M\"/>\n";
  WriteWelds(scene, &out);
  out << "  <worldbody>\n";
  WriteObstacles(scene, constants, &out);
  WriteBodies(scene, constants, &out);
  out << "  </worldbody>\n  <deformable>\n";
  WriteFlex(order, constants, numbers, &out);
  out << "  </deformable>\n</mujoco>\n";
  return out.str();
}

}  // namespace clothid
