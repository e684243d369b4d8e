// What a fit has found, in the constants that other simulators are written in.
//
// clothid's membrane has, for small strains, the energy k/2 (e_11^2 + e_22^2 + 2 e_12^2) per area: that of a thin sheet
// with Young's modulus times thickness k and Poisson's ratio 0 (sim/shell/stretch_energy.h). Others bend at their
// edges: E = 1/2 K theta^2 per edge, theta the angle between its triangles. For small angles that is the law by edges
// (sim/shell/bending_energy.h) with
//   K = 3 k_edge l^2/(A_1 + A_2),   l the length of the edge, A_1 and A_2 the areas of its triangles.
// The flexural rigidity D, which means the same on any mesh, becomes k_edge = D/f with f = 0.82 times the energy by
// edges of the mesh at hand, bent to a cylinder, over D/2 area/R^2, both for 1 N m: in the mean over two directions,
//   1/2 sum over u of z_u^T Q z_u/area,   z_u = (u . x)^2/2,   Q that of the law by edges,
// over the triangles that are away from the border, each with half of its edges. That is 3 on a right-angled grid; 0.82
// is measured, for a cloth in equilibrium gives way between its edges: with it strips of 20 to 80 elements, clamped by
// four rows, sag within 3 % as by patches, with 1 they sag 14 to 22 % too far.
#ifndef CLOTHID_IDENTIFY_EXPORT_EXPORT_CONSTANTS_H_
#define CLOTHID_IDENTIFY_EXPORT_EXPORT_CONSTANTS_H_

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "datasets/fabric/fabric_card.h"
#include "sim/scene/parameters.h"
#include "sim/scene/scene.h"

namespace clothid {

struct ExportConstants {
  double density = 0.0;                                       // kg/m^2
  double stiffness = 0.0;                                     // k, N/m; of an orthotropic membrane the geometric mean
  double warp = 0.0, weft = 0.0, shear = 0.0, poisson = 0.0;  // C_11, C_22, C_66, C_12, N/m
  double edge_factor = 0.0;                                   // f
  double edge_bending = 0.0;                                  // k_edge, N m
  double rigidity = 0.0;                                      // D, N m
  double damping = 0.0;                                       // eta/k, s
  double drag = 0.0;                                          // kg/(m^2 s), the same in every direction
  double thickness = 0.0;                                     // m: the largest contact distance of an obstacle
  std::vector<std::pair<std::string, double>> friction;       // by obstacle
  std::optional<SelfContact> self_contact;                    // none: the cloth goes through itself
  double area = 0.0, edge_length = 0.0, least_edge = 0.0;     // of the mesh at rest, m^2 and m: mean and shortest edge
  double squared_edges = 0.0;                                 // m^2, the sum of the squares of all edge lengths
  double edge_shape = 0.0;                                    // 1/m, the mean of 3 l/(A_1 + A_2) over the inner edges
  std::map<std::string, std::string> remarks;                 // by the parameter that a constant comes from
  std::vector<std::string> not_mapped;                        // lines: what the numbers leave out
};

// Of yarns that stiffen, which none of them knows, the secants k (exp(b e) - 1)/(b e) at the largest strain e that
// `card` has seen, which may be null: without it, or where it was not strained, k at zero strain.
ExportConstants MakeExportConstants(const Scene& scene, const Parameters& parameters, const FabricCard* card);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_EXPORT_EXPORT_CONSTANTS_H_
