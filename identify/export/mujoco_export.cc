// MuJoCo's flex (measured with MuJoCo 3.14.0): the membrane of a flex of dimension 2 with Poisson's ratio 0 is that of
// St. Venant and Kirchhoff with k = young thickness/4, and it bends by edges with k_edge = young thickness^3/48. So
//   thickness = sqrt(12 k_edge/k),   young = 4 k/thickness,   damping (s) = eta/k.
// Nodes are bodies of their own, for a flexcomp would give all of them the same mass.
#include <algorithm>
#include <cmath>
#include <sstream>

#include "identify/export/flex_order.h"
#include "identify/export/simulator_exports.h"
#include "sim/base/text_file.h"
#include "sim/scene/mesh.h"
#include "sim/scene/obstacle.h"

namespace clothid {
namespace {

constexpr double kThinnest = 1e-4;     // m: of a cloth that does not bend
constexpr double kLongestStep = 1e-3;  // s

struct FlexNumbers {
  double thickness = kThinnest, young = 0.0;  // m, Pa
};

std::string Numbers(const Eigen::Vector3d& vector) {
  return ShortestText(vector[0]) + " " + ShortestText(vector[1]) + " " + ShortestText(vector[2]);
}

// An obstacle as a geom; a comment where MuJoCo has no such shape.
std::string Geom(const SceneObstacle& obstacle, double friction) {
  const std::string tail = " friction=\"" + ShortestText(friction) + " 0.005 0.0001\" condim=\"3\"/>\n";
  if (const auto* plane = dynamic_cast<const Plane*>(obstacle.shape.get())) {
    return "    <geom type=\"plane\" size=\"0 0 1\" pos=\"" + Numbers(plane->point()) + "\" zaxis=\"" +
           Numbers(plane->normal()) + "\"" + tail;
  }
  if (const auto* sphere = dynamic_cast<const Sphere*>(obstacle.shape.get())) {
    return "    <geom type=\"sphere\" size=\"" + ShortestText(sphere->radius()) + "\" pos=\"" +
           Numbers(sphere->center()) + "\"" + tail;
  }
  if (const auto* capsule = dynamic_cast<const Capsule*>(obstacle.shape.get())) {
    return "    <geom type=\"capsule\" size=\"" + ShortestText(capsule->radius()) + "\" fromto=\"" +
           Numbers(capsule->from()) + " " + Numbers(capsule->to()) + "\"" + tail;
  }
  return "    <!-- an obstacle of another shape is left out; its friction is " + ShortestText(friction) + " -->\n";
}

void WriteBodies(const Scene& scene, const ExportConstants& constants, std::ostringstream* out) {
  const Eigen::VectorXd areas = NodeAreas(scene.mesh);
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
    const std::vector<int>& handles = scene.handles.nodes;
    const bool is_held = std::find(handles.begin(), handles.end(), node) != handles.end();
    *out << "    <body name=\"n" << node << "\" pos=\"" << Numbers(scene.initial_positions.segment<3>(3 * node))
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
      << "    radius is the half thickness in contacts; clothid measures gaps from the obstacle.\n-->\n";
  return out.str();
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
      << ShortestText(std::min(kLongestStep, scene.time_step)) << "\" gravity=\"" << Numbers(scene.gravity)
      << "\" integrator=\"discrete\" solver=\"CG\" cone=\"elliptic\"/>\n  <size memory=\"100M\"/>\n  <worldbody>\n";
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    out << Geom(scene.obstacles[i], constants.friction[i].second);
  }
  WriteBodies(scene, constants, &out);
  out << "  </worldbody>\n  <deformable>\n";
  WriteFlex(order, constants, numbers, &out);
  out << "  </deformable>\n</mujoco>\n";
  return out.str();
}

}  // namespace clothid
