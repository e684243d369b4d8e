// Newton, ARCSim, Blender and ppf-contact-solver; the sources of their formulas stand in the texts.
#include <algorithm>
#include <sstream>

#include "identify/export/simulator_exports.h"
#include "sim/base/text_file.h"
#include "sim/mesh/mesh.h"

namespace clothid {
namespace {

// BEND_SCALE of crates/ppf-cts-solver/src/cpp/energy/energy.cu.
constexpr double kPpfBendScale = 1.28e-5;

std::string T(double value) { return ShortestText(value); }

// Lines of what was remarked of parameters `names`, to follow the constant that they make.
std::string Remarks(const ExportConstants& constants, const std::string& comment,
                    const std::vector<std::string>& names) {
  std::string lines;
  for (const std::string& name : names) {
    const auto it = constants.remarks.find(name);
    if (it != constants.remarks.end()) lines += comment + "    " + Printable(name) + ": " + it->second + "\n";
  }
  return lines;
}

double FirstFriction(const ExportConstants& constants) {
  return constants.friction.empty() ? 0.0 : constants.friction.front().second;
}

// Each a line or two about the cloth with itself, in comments of the target; empty where it does not meet itself.
std::string NewtonSelfContact(const ExportConstants& constants) {
  if (!constants.self_contact) return "";
  return "# The cloth with itself: friction soft_contact_mu, which counts at shapes as sqrt(soft_contact_mu mu of the "
         "shape):\n#   give those MU**2/MU_SELF. SolverVBD(model, **SELF_CONTACT) keeps the cloth apart.\nMU_SELF = " +
         T(constants.self_contact->friction_coefficient) +
         "\nSELF_CONTACT = {\"particle_enable_self_contact\": True, \"particle_self_contact_radius\": " +
         T(constants.self_contact->thickness) +
         ",\n                \"particle_self_contact_margin\": " + T(1.5 * constants.self_contact->thickness) +
         "}  # m\n";
}

std::string ArcsimSelfContact(const ExportConstants& constants) {
  if (!constants.self_contact) return "";
  return "\n// The cloth with itself: \"friction\" " + T(constants.self_contact->friction_coefficient) +
         "; not mapped: its thickness, for \"repulsion_thickness\" is one number";
}

std::string BlenderSelfContact(const ExportConstants& constants) {
  if (!constants.self_contact) return "";
  return "cloth.collision_settings.use_self_collision = True\ncloth.collision_settings.self_distance_min = " +
         T(constants.self_contact->thickness) + "  # m; not mapped: mu.self, for self_friction is not Coulomb's\n";
}

std::string PpfSelfContact(const ExportConstants& constants) {
  if (!constants.self_contact) return "";
  const bool is_larger = constants.self_contact->friction_coefficient >= FirstFriction(constants);
  return "# \"friction\" is mu.self: contacts combine that of both objects, so give obstacles their own mu and the "
         "scene "
         "the\n#   friction mode \"" +
         std::string(is_larger ? "min" : "max") +
         "\". Not mapped: thickness, for a contact-gap holds for all contacts.\n";
}

// The rest of the script; what stands for `soft_contact_mu` follows.
constexpr char kNewtonFunctions[] = R"(

def read_obj(path="export_cloth.obj"):
    lines = [line.split() for line in open(path, encoding="ascii")]
    vertices = [wp.vec3(*map(float, line[1:4])) for line in lines if line and line[0] == "v"]
    return vertices, [int(i) - 1 for line in lines if line and line[0] == "f" for i in line[1:4]]


def add_cloth(builder: newton.ModelBuilder, path="export_cloth.obj"):
    vertices, indices = read_obj(path)
    builder.add_cloth_mesh(
        pos=wp.vec3(0.0, 0.0, 0.0), rot=wp.quat_identity(), scale=1.0, vel=wp.vec3(0.0, 0.0, 0.0), vertices=vertices,
        indices=indices, density=DENSITY, tri_ke=TRI_KE, tri_ka=TRI_KA, tri_kd=TRI_KD, edge_ke=EDGE_KE,
        edge_kd=EDGE_KD, particle_radius=RADIUS)


def set_friction(model: newton.Model):
    model.particle_mu = MU
    model.soft_contact_mu = )";

}  // namespace

std::string Preamble(const ExportConstants& constants, const std::string& comment) {
  std::ostringstream out;
  out << comment << "Cloth constants by clothid, SI units:\n"
      << comment << "  density " << T(constants.density) << " kg/m^2\n"
      << Remarks(constants, comment, {"density"}) << comment << "  k " << T(constants.stiffness)
      << " N/m: Young's modulus times thickness of the membrane, Poisson's ratio 0\n"
      << Remarks(constants, comment, {"k_stretch", "k_warp", "k_weft", "k_shear", "k_poisson"}) << comment << "  D "
      << T(constants.rigidity) << " N m: flexural rigidity;  k_edge = D/" << T(constants.edge_factor) << " = "
      << T(constants.edge_bending) << " N m: of bending by edges on this mesh\n"
      << Remarks(constants, comment, {"k_bend", "bend_warp", "bend_weft", "bend_twist"}) << comment << "  eta/k "
      << T(constants.damping) << " s: internal damping\n"
      << Remarks(constants, comment, {"damping"});
  for (const auto& [name, mu] : constants.friction) {
    out << comment << "  mu " << T(mu) << " of " << Printable(name) << ", Coulomb friction of cloth and obstacle\n"
        << Remarks(constants, comment, {"mu", "mu." + name});
  }
  if (constants.self_contact) {
    out << comment << "  mu.self " << T(constants.self_contact->friction_coefficient)
        << ", Coulomb friction of the cloth with itself;  thickness " << T(constants.self_contact->thickness) << " m\n"
        << Remarks(constants, comment, {"mu.self"});
  }
  out << comment << "  contact distance " << T(constants.thickness) << " m\n";
  for (const std::string& line : constants.not_mapped) out << comment << "Not mapped: " << line << "\n";
  return out.str();
}

std::string NewtonScript(const ExportConstants& constants) {
  std::ostringstream out;
  out << Preamble(constants, "# ") << R"(#
# For NVIDIA Newton's SolverVBD (newton/_src/solvers/vbd/particle_vbd_kernels.py, commit 41a5392c):
#   tri_ke = mu, tri_ka = lambda, the Lame constants of the membrane, N/m: k/2 and 0 for Poisson's ratio 0
#     (SolverSemiImplicit takes lambda + mu for tri_ka: k/2). Not exactly 0: ModelBuilder.color() leaves out triangles
#     whose tri_ke * tri_ka is 0, and vertices of the same triangle would then be moved at once
#   edge_ke, N: E = edge_ke l theta^2/2 per edge, so edge_ke = k_edge mean of 3 l/(A1 + A2) over the inner edges
#   tri_kd, N s/m: the force is tri_kd area dC/dt : dC/dx with C = F^T F, clothid's eta/4 of it
# Not mapped: contacts are penalties (soft_contact_ke), so friction is Coulomb's only where they are stiff; Newton
#   combines the friction of both bodies: both get that of the pair. Particles have the mass of a third of their
#   triangles, as nodes have here.
import newton
import warp as wp

DENSITY = )"
      << T(constants.density) << "  # kg/m^2\nTRI_KE = " << T(0.5 * constants.stiffness)
      << "  # N/m, k/2\nTRI_KA = 1e-06 * TRI_KE  # N/m\nTRI_KD = " << T(0.25 * constants.damping * constants.stiffness)
      << "  # N s/m, eta/4\nEDGE_KE = " << T(constants.edge_bending * constants.edge_shape) << "  # N, k_edge * "
      << T(constants.edge_shape) << " 1/m\nEDGE_KD = 0.0\nMU = " << T(FirstFriction(constants))
      << "  # of cloth and obstacle\nRADIUS = " << T(0.5 * std::max(constants.thickness, 1e-3))
      << "  # m, half the contact distance, at least 1 mm\n"
      << NewtonSelfContact(constants) << kNewtonFunctions << (constants.self_contact ? "MU_SELF" : "MU") << "\n";
  return out.str();
}

std::string ArcsimJson(const ExportConstants& constants) {
  std::ostringstream out;
  const std::string row = "[" + T(0.5 * constants.warp) + ", " + T(0.5 * constants.poisson) + ", " +
                          T(0.5 * constants.weft) + ", " + T(constants.shear) + "]";
  const double bending = 12.0 * constants.edge_bending;
  out << Preamble(constants, "// ") << R"(//
// A material of ARCSim (src/physics.cpp, src/dde.cpp, src/conf.cpp as of lijieumn/libarcsim, commit d4bfe61a):
//   stretching, N/m: six rows, small strain and five angles of large strain, of half the constants of
//     C_11 e_11^2/2 + C_12 e_11 e_22 + C_22 e_22^2/2 + 2 C_66 e_12^2: C_11/2, C_12/2, C_22/2, 2 C_66/2
//   bending, N m: E = ke l^2/(A1 + A2) theta^2/8 per edge, so ke = 12 k_edge; three angles by five curvatures
// In the configuration of the cloth: "materials": [{"data": "export_arcsim.json", "damping": )"
      << T(constants.damping) << R"(}], s, eta/k.
// Not mapped: strain stiffening (the same constants stand in every row); "obs_friction" of the configuration is
//   one number for all obstacles, Coulomb's: )"
      << T(FirstFriction(constants)) << "; \"repulsion_thickness\" " << T(constants.thickness) << " m"
      << ArcsimSelfContact(constants) << "\n{\n  \"density\": " << T(constants.density) << ",\n  \"stretching\": [";
  for (int i = 0; i < 6; ++i) out << (i > 0 ? ",\n                 " : "") << row;
  out << "],\n  \"bending\": [";
  for (int i = 0; i < 3; ++i) {
    out << (i > 0 ? ",\n              [" : "[");
    for (int j = 0; j < 5; ++j) out << (j > 0 ? ", " : "") << T(bending);
    out << "]";
  }
  out << "]\n}\n";
  return out.str();
}

std::string BlenderScript(const Scene& scene, const ExportConstants& constants) {
  const double tension =
      8.0 / 3.0 * constants.stiffness * constants.edge_length * constants.area / constants.squared_edges;
  std::ostringstream out;
  out << Preamble(constants, "# ") << R"(#
# For Blender's cloth modifier (cloth_calc_spring_force of SIM_mass_spring): every edge is a spring with the force
# tension (l - l0)/mean edge length. A mesh of such springs has, in the mean over all directions,
#   k = 3/8 tension/mean edge length * sum of l^2/area   (exact along the axes of a right-angled grid)
# and Poisson's ratio 1/3, not 0.
#   mass, kg: of a vertex, the same for all: density area/number of vertices
# Not mapped: bending_stiffness has no formula in physical units (it scales with edge lengths); it is left as it is.
#   friction (0 to 80) is not Coulomb's; damping and air_damping are factors per spring and per step.
import bpy

cloth = bpy.context.object.modifiers.new("Cloth", "CLOTH") if "Cloth" not in bpy.context.object.modifiers \
    else bpy.context.object.modifiers["Cloth"]
settings = cloth.settings
settings.mass = )"
      << T(constants.density * constants.area / scene.mesh.num_nodes()) << "  # kg, " << T(constants.density) << " * "
      << T(constants.area) << "/" << scene.mesh.num_nodes() << "\nsettings.tension_stiffness = " << T(tension)
      << "  # N, 8/3 k * " << T(constants.edge_length) << " * " << T(constants.area) << "/"
      << T(constants.squared_edges) << "\nsettings.compression_stiffness = " << T(tension)
      << "\nsettings.shear_stiffness = 0.0  # of quads; triangles have edges instead\n"
      << "cloth.collision_settings.distance_min = " << T(std::max(constants.thickness, 1e-3)) << "  # m\n"
      << BlenderSelfContact(constants);
  return out.str();
}

std::string PpfScript(const ExportConstants& constants) {
  std::ostringstream out;
  out << Preamble(constants, "# ") << R"(#
# For ppf-contact-solver, commit f23b3565 (docs/blender_addon/workflow/params/material.md; energy.cu, hinge):
#   young-mod, m^2/s^2: Young's modulus times thickness over the density: k/density; poiss-rat 0; arap is clothid's law
#   bend: E = 1.28e-5 bend density l^2/(A1 + A2) theta^2/2 per edge, so bend = 3 k_edge/(1.28e-5 density)
#   contact-gap, m: the contact distance
# Not mapped: contacts are a barrier; "friction" is Coulomb's, lagged. Damping of the cloth is of its own kind.
)" << PpfSelfContact(constants)
      << R"(PARAMETERS = {
    "model": "arap",
    "density": )"
      << T(constants.density) << ",  # kg/m^2\n    \"young-mod\": " << T(constants.stiffness / constants.density)
      << ",  # k/density\n    \"poiss-rat\": 0.0,\n    \"bend\": "
      << T(3.0 * constants.edge_bending / (kPpfBendScale * constants.density))
      << ",  # 3 k_edge/(1.28e-5 density)\n    \"friction\": "
      << T(constants.self_contact ? constants.self_contact->friction_coefficient : FirstFriction(constants))
      << ",\n    \"contact-gap\": " << T(std::max(constants.thickness, 1e-3)) << R"(,  # m
}


def read_obj(path="export_cloth.obj"):
    lines = [line.split() for line in open(path, encoding="ascii")]
    vertices = [[float(x) for x in line[1:4]] for line in lines if line and line[0] == "v"]
    return vertices, [[int(i) - 1 for i in line[1:4]] for line in lines if line and line[0] == "f"]


def set_parameters(cloth):
    """cloth: what scene.add(..) of the frontend gives."""
    for key, value in PARAMETERS.items():
        cloth.param.set(key, value)
)";
  return out.str();
}

std::string ClothObj(const Scene& scene) {
  std::ostringstream out;
  for (int i = 0; i < scene.mesh.num_nodes(); ++i) {
    const Eigen::Vector3d x = scene.mesh.rest_positions.col(i);
    out << "v " << T(x[0]) << " " << T(x[1]) << " " << T(x[2]) << "\n";
  }
  for (int f = 0; f < scene.mesh.num_faces(); ++f) {
    const Eigen::Vector3i face = scene.mesh.faces.col(f);
    out << "f " << face[0] + 1 << " " << face[1] + 1 << " " << face[2] + 1 << "\n";
  }
  return out.str();
}

}  // namespace clothid
