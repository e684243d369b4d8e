#include "identify/export/export_constants.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "identify/base/join_words.h"
#include "sim/mesh/mesh.h"
#include "sim/scene/pieces.h"
#include "sim/shell/bending_energy.h"

namespace clothid {
namespace {

constexpr double kGivesWay = 0.82;      // a cloth in equilibrium over a cylinder
constexpr double kRegularFactor = 3.0;  // f of a large right-angled grid
constexpr double kFlat = 1e-6;          // relative to the cloth's size

// By the energy. Of a mesh that is flat at rest and has triangles away from its border; else that of a regular one.
double EdgeFactor(const Mesh& mesh) {
  const Eigen::Matrix3Xd& x = mesh.rest_positions;
  const Eigen::Vector3d origin = x.col(mesh.faces(0, 0));
  std::array<Eigen::Vector3d, 2> sides = {x.col(mesh.faces(1, 0)) - origin, x.col(mesh.faces(2, 0)) - origin};
  const Eigen::Vector3d normal = sides[0].cross(sides[1]).normalized();
  if ((normal.transpose() * (x.colwise() - origin)).cwiseAbs().maxCoeff() > kFlat * ClothSize(mesh)) {
    return kRegularFactor;
  }
  const Eigen::Vector3d first = sides[sides[1].norm() < sides[0].norm() ? 1 : 0].normalized();
  const std::array<Eigen::Vector3d, 2> axes = {first, normal.cross(first)};
  Eigen::VectorXd energies = Eigen::VectorXd::Zero(mesh.num_faces());
  Eigen::VectorXi num_edges = Eigen::VectorXi::Zero(mesh.num_faces());
  for (const BendingElement& edge : EdgeBendingElements(mesh)) {
    double energy = 0.0;
    for (const Eigen::Vector3d& axis : axes) {
      Eigen::VectorXd height(edge.nodes.size());
      for (std::size_t i = 0; i < edge.nodes.size(); ++i) {
        height[static_cast<Eigen::Index>(i)] = 0.5 * std::pow(axis.dot(x.col(edge.nodes[i]) - origin), 2);
      }
      energy += 0.5 * height.dot(edge.block * height);
    }
    for (const int face : edge.faces) {
      energies[face] += 0.5 * energy;
      ++num_edges[face];
    }
  }
  const Eigen::VectorXd areas = TriangleAreas(mesh);
  double sum = 0.0, area = 0.0;
  for (int f = 0; f < mesh.num_faces(); ++f) {
    if (num_edges[f] < 3) continue;
    sum += energies[f];
    area += areas[f];
  }
  return area > 0.0 ? sum / area : kRegularFactor;
}

void SetLengths(const Mesh& mesh, ExportConstants* constants) {
  const Eigen::VectorXd areas = TriangleAreas(mesh);
  constants->area = areas.sum();
  std::map<std::pair<int, int>, std::pair<double, int>> edges;  // area and number of their triangles
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const std::pair<int, int> ends = std::minmax({mesh.faces(k, f), mesh.faces((k + 1) % 3, f)});
      edges[ends].first += areas[f];
      ++edges[ends].second;
    }
  }
  double sum = 0.0, shape = 0.0;
  int num_inner = 0;
  constants->least_edge = std::numeric_limits<double>::infinity();
  for (const auto& [ends, triangles] : edges) {
    const double length = (mesh.rest_positions.col(ends.first) - mesh.rest_positions.col(ends.second)).norm();
    sum += length;
    constants->squared_edges += length * length;
    constants->least_edge = std::min(constants->least_edge, length);
    if (triangles.second < 2) continue;
    shape += 3.0 * length / triangles.first;
    ++num_inner;
  }
  constants->edge_length = sum / static_cast<double>(edges.size());
  constants->edge_shape = num_inner > 0 ? shape / num_inner : 0.0;
}

struct Secant {
  double stiffness = 0.0;  // N/m
  std::string words;       // "412 N/m at 12 %"
};

// At the largest strain of `kind` on the card.
Secant SecantOf(double stiffness, double stiffening, ParameterKind kind, const FabricCard* card) {
  const CardConstant* seen = card == nullptr ? nullptr : card->Find(kind);
  const double strain = seen == nullptr || !(seen->seen_to > 0.0) ? 0.0 : seen->seen_to;
  const double growth = stiffening * strain;
  const double secant = growth > 0.0 ? stiffness * std::expm1(growth) / growth : stiffness;
  return {secant, NumberText(secant, 4) + " N/m at " + NumberText(100.0 * strain, 3) + " %"};
}

void SetMembrane(const Scene& scene, const Material& material, const FabricCard* card, ExportConstants* constants) {
  if (scene.membrane == MembraneLaw::kArap) {
    constants->stiffness = constants->warp = constants->weft = material.stretch_stiffness;
    constants->shear = 0.5 * material.stretch_stiffness;
    return;
  }
  const Secant warp = SecantOf(material.warp_stiffness, material.warp_stiffening, ParameterKind::kWarpStiffness, card);
  const Secant weft = SecantOf(material.weft_stiffness, material.weft_stiffening, ParameterKind::kWeftStiffness, card);
  constants->warp = warp.stiffness;
  constants->weft = weft.stiffness;
  constants->shear = material.shear_stiffness;
  constants->poisson = material.poisson_stiffness;
  constants->stiffness = std::sqrt(constants->warp * constants->weft);
  constants->not_mapped.push_back(
      "warp and weft: an isotropic simulator gets the geometric mean of k_warp and k_weft, and shears as such");
  if (material.warp_stiffening == 0.0 && material.weft_stiffening == 0.0) return;
  constants->not_mapped.push_back(
      "stiffening: in place of curves secants at the largest strains that were seen, k_warp " + warp.words +
      " and k_weft " + weft.words);
}

void SetBending(const Scene& scene, const Material& material, ExportConstants* constants) {
  constants->edge_factor = kGivesWay * EdgeFactor(scene.mesh);
  if (scene.bending.law == BendingLaw::kEdges) {
    constants->edge_bending = material.bending_stiffness;
    constants->rigidity = material.bending_stiffness * constants->edge_factor;
    return;
  }
  constants->rigidity =
      scene.bending.orthotropic ? std::sqrt(material.warp_bending * material.weft_bending) : material.bending_stiffness;
  constants->edge_bending = constants->rigidity / constants->edge_factor;
  if (scene.bending.orthotropic) {
    constants->not_mapped.push_back("bend_warp and bend_weft: their geometric mean bends every edge");
  }
  if (scene.bending.poisson != 0.0) constants->not_mapped.push_back("bend_poisson: edges bend independently");
}

}  // namespace

ExportConstants MakeExportConstants(const Scene& scene, const Parameters& parameters, const FabricCard* card) {
  const Material material = MeanMaterial(parameters, scene.mesh);
  ExportConstants constants;
  constants.density = material.density;
  SetMembrane(scene, material, card, &constants);
  SetBending(scene, material, &constants);
  SetLengths(scene.mesh, &constants);
  constants.damping = material.damping / constants.stiffness;
  constants.drag = material.drag;
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    constants.friction.emplace_back(scene.obstacles[i].name, parameters.friction_coefficients[i]);
    constants.thickness = std::max(constants.thickness, scene.obstacles[i].contact_distance);
  }
  if (scene.self_contact) constants.self_contact = SelfContact{parameters.self_friction, scene.self_contact->thickness};
  if (scene.has_air()) constants.not_mapped.push_back("drag and wind: every simulator has another law of the air");
  if (!scene.pieces.empty())
    constants.not_mapped.push_back("pieces: the means of their constants over the cloth are here");
  if (!scene.fields.empty()) constants.not_mapped.push_back("constants that vary over the cloth: their means are here");
  if (scene.handles.path.num_handles() > 0) {
    constants.not_mapped.push_back("the path of the handles: they stand where the motion starts");
  }
  if (!scene.handles.clamped.empty()) {
    constants.not_mapped.push_back("clamps: handles hold places, not slopes; hold a second row of nodes");
  }
  return constants;
}

}  // namespace clothid
