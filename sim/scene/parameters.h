// What a fit may change: the constants of the material and the friction of the obstacles, and their names.
#ifndef CLOTHID_SIM_SCENE_PARAMETERS_H_
#define CLOTHID_SIM_SCENE_PARAMETERS_H_

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace clothid {

struct Material {
  double density = 0.15;             // rho, kg/m^2
  double stretch_stiffness = 100.0;  // k, N/m
  double bending_stiffness = 0.0;    // k_b, N m; 0: the scene has no bending
  double drag = 0.0;                 // c_d, kg/(m^2 s); 0: the scene has neither drag nor wind
  double damping = 0.0;              // eta, N s/m; 0: the scene has no internal damping. eta/k is a relaxation time
  // Of an orthotropic membrane, in place of k: C_11, C_22, C_66 and C_12, N/m (sim/cloth/orthotropic_energy.h).
  double warp_stiffness = 0.0, weft_stiffness = 0.0, shear_stiffness = 0.0, poisson_stiffness = 0.0;
  // Of orthotropic bending, in place of k_b: D_11, D_22 and D_66, N m (sim/cloth/bending_patch.h).
  double warp_bending = 0.0, weft_bending = 0.0, twist_bending = 0.0;

  bool operator==(const Material& other) const;
};

struct FieldFactors;  // sim/scene/material_field.h

struct Parameters {
  Material material;
  std::vector<double> friction_coefficients;  // mu, one per obstacle of the scene
  // How constants of the material vary over the cloth: as many and of the same as the scene has. Null: they do not.
  std::shared_ptr<const std::vector<FieldFactors>> fields;
};

enum class ParameterKind {
  kFriction,
  kStretchStiffness,
  kBendingStiffness,
  kDensity,
  kDrag,
  kDamping,
  kWarpStiffness,
  kWeftStiffness,
  kShearStiffness,
  kPoissonStiffness,
  kWarpBending,
  kWeftBending,
  kTwistBending,
};

// All but kFriction, in the order in which lists name them.
inline constexpr ParameterKind kMaterialKinds[] = {ParameterKind::kStretchStiffness, ParameterKind::kBendingStiffness,
                                                   ParameterKind::kDensity,          ParameterKind::kDrag,
                                                   ParameterKind::kDamping,          ParameterKind::kWarpStiffness,
                                                   ParameterKind::kWeftStiffness,    ParameterKind::kShearStiffness,
                                                   ParameterKind::kPoissonStiffness, ParameterKind::kWarpBending,
                                                   ParameterKind::kWeftBending,      ParameterKind::kTwistBending};

// Values that a parameter can have; finite ones.
enum class ParameterDomain { kPositive, kNotNegative, kAny };
ParameterDomain DomainOf(ParameterKind kind);
bool IsInDomain(ParameterDomain domain, double value);
const char* DomainWords(ParameterDomain domain);  // "a finite number > 0"

inline constexpr int kAllObstacles = -1;

// One scalar of `Parameters`, or the friction of all obstacles at once.
struct ParameterId {
  ParameterKind kind = ParameterKind::kStretchStiffness;
  int obstacle = kAllObstacles;  // for kFriction: an index into the scene's obstacles, or kAllObstacles

  bool operator==(const ParameterId& other) const { return kind == other.kind && obstacle == other.obstacle; }
};

// "k_stretch", "k_bend", "density", "drag", "damping"; "k_warp", "k_weft", "k_shear", "k_poisson"; "bend_warp",
// "bend_weft", "bend_twist"; "mu" (every obstacle), "mu.NAME" (one of them). `obstacle_names` are the scene's, in its
// order. Throws `Error` (kUsage) that lists the names it would accept. `ParseParameter` in sim/scene/scene.h also asks
// whether a scene has the parameter.
ParameterId ParseParameter(const std::string& name, const std::vector<std::string>& obstacle_names);
// The names that are accepted, "k_stretch, k_bend, .., mu.ball", less those of kinds for which `has` is false.
std::string ParameterNames(const std::vector<std::string>& obstacle_names,
                           const std::function<bool(ParameterKind)>& has);
std::string ParameterName(ParameterId id, const std::vector<std::string>& obstacle_names);

// "mu=0.3, k_stretch=300" -> {{"k_stretch", 300}, {"mu", 0.3}}. Empty text: empty map. Throws `Error` (kUsage), naming
// `flag`, unless every item is NAME=NUMBER with a finite number and every name is there once. The names may be any.
std::map<std::string, double> ParseParameterValues(const std::string& text, const std::string& flag);

// The constant of a material that `kind`, any but kFriction, names.
double Material::*MaterialConstant(ParameterKind kind);

// The value of `id`. For the friction of all obstacles: that of the first; NaN where there is no obstacle.
double GetParameter(const Parameters& parameters, ParameterId id);
void SetParameter(ParameterId id, double value, Parameters* parameters);

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_PARAMETERS_H_
