// What a fit may change: the constants of the material and the friction of the obstacles, and their names.
#ifndef CLOTHID_SIM_SCENE_PARAMETERS_H_
#define CLOTHID_SIM_SCENE_PARAMETERS_H_

#include <map>
#include <string>
#include <vector>

namespace clothid {

struct Material {
  double density = 0.15;             // rho, kg/m^2
  double stretch_stiffness = 100.0;  // k, N/m
  double bending_stiffness = 0.0;    // k_b, N m; 0: the scene has no bending
  double drag = 0.0;                 // c_d, kg/(m^2 s); 0: the scene has neither drag nor wind
  double damping = 0.0;              // eta, N s/m; 0: the scene has no internal damping. eta/k is a relaxation time
};

struct Parameters {
  Material material;
  std::vector<double> friction_coefficients;  // mu, one per obstacle of the scene
};

enum class ParameterKind { kFriction, kStretchStiffness, kBendingStiffness, kDensity, kDrag, kDamping };

inline constexpr int kAllObstacles = -1;

// One scalar of `Parameters`, or the friction of all obstacles at once.
struct ParameterId {
  ParameterKind kind = ParameterKind::kStretchStiffness;
  int obstacle = kAllObstacles;  // for kFriction: an index into the scene's obstacles, or kAllObstacles

  bool operator==(const ParameterId& other) const { return kind == other.kind && obstacle == other.obstacle; }
};

// "k_stretch", "k_bend", "density", "drag", "damping", "mu" (every obstacle), "mu.NAME" (one of them). `obstacle_names`
// are the scene's, in its order. Throws `Error` (kUsage) that lists the names it would accept.
ParameterId ParseParameter(const std::string& name, const std::vector<std::string>& obstacle_names);
std::string ParameterName(ParameterId id, const std::vector<std::string>& obstacle_names);

// "mu=0.3, k_stretch=300" -> {{"k_stretch", 300}, {"mu", 0.3}}. Empty text: empty map. Throws `Error` (kUsage), naming
// `flag`, unless every item is NAME=NUMBER with a finite number and every name is there once. The names may be any.
std::map<std::string, double> ParseParameterValues(const std::string& text, const std::string& flag);

// The value of `id`. For the friction of all obstacles: that of the first; NaN where there is no obstacle.
double GetParameter(const Parameters& parameters, ParameterId id);
void SetParameter(ParameterId id, double value, Parameters* parameters);

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_PARAMETERS_H_
