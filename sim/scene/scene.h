// All that is held fixed during a fit: cloth, handles, obstacles, air, gravity, solver settings. Read from scene.json
// (see sim/scene/scene_json.h) or built by hand.
#ifndef CLOTHID_SIM_SCENE_SCENE_H_
#define CLOTHID_SIM_SCENE_SCENE_H_

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/air/wind.h"
#include "sim/mesh/clamped_edges.h"
#include "sim/mesh/mesh.h"
#include "sim/obstacle/obstacle.h"
#include "sim/path/handle_path.h"
#include "sim/path/rigid_path.h"
#include "sim/scene/material_field.h"
#include "sim/scene/parameters.h"
#include "sim/scene/warp.h"

namespace clothid {

class SurfaceSequence;  // sim/obstacle/surface_sequence.h

// Bounds that keep a slip of the pen from asking for all memory or time.
inline constexpr int kMaxSceneSteps = 10000000;
inline constexpr std::size_t kMaxObstacles = 1000;

// How a time step is taken: see "One step in time" in sim/README.md.
enum class Integrator {
  kEuler,   // backward Euler, of first order: the paper's
  kSdirk2,  // two implicit stages, of second order but for impacts
};

// "euler", "sdirk2".
const char* IntegratorName(Integrator integrator);

// How a node enters the contact set: see "Two contact modes" in sim/README.md.
enum class ContactMode {
  kGap,       // phi/h + u_N >= 0 for every node: continuous when contacts appear or end
  kVelocity,  // u_N >= 0 for nodes with phi(x_n) <= touch: the paper's
};

// Whose second derivatives the bending energy takes: see "Bending" in sim/README.md.
enum class BendingLaw {
  kEdges,    // those across the edges alone: the paper's; the energy depends on the mesh
  kPatches,  // those of a fit to the nodes around a triangle: k_b is the flexural rigidity of the cloth, on any mesh
};

struct Bending {
  BendingLaw law = BendingLaw::kPatches;
  double poisson = 0.0;          // nu of bending, in (-1, 1); kPatches alone has it
  bool orthotropic = false;      // bend_warp, bend_weft and bend_twist in place of k_b; kPatches alone has it
  bool is_flat_at_rest = false;  // it bends back flat, not to the mesh at rest; kEdges always does
};

// How the cloth resists strain in its surface: see "Stretch" in sim/README.md.
enum class MembraneLaw {
  kArap,         // k_stretch; isotropic: the paper's
  kOrthotropic,  // k_warp, k_weft, k_shear and k_poisson, along warp and weft
  kYarn,         // the same at zero strain, with stiffening_warp and stiffening_weft
};

struct SceneObstacle {
  std::string name;
  std::shared_ptr<const Obstacle> shape;  // in axes of its own where it has a path, else in the world's
  double friction_coefficient = 0.3;      // mu, the nominal value
  double contact_distance = 0.0;          // m; the gap is measured from this distance off the surface (cloth thickness)
  // At most one of them; times on the scene's clock. Without one it stands still.
  std::shared_ptr<const RigidPath> path = nullptr;
  std::shared_ptr<const SurfaceSequence> sequence = nullptr;  // of `shape`, a TriangulatedSurface; in world axes

  bool moves() const { return path != nullptr || sequence != nullptr; }
  // Its shape at `time`, in world axes, where path or sequence are as they were given.
  std::shared_ptr<const Obstacle> ShapeAt(double time) const;
};

// How the cloth meets itself: see "The cloth against itself" in sim/README.md.
struct SelfContact {
  double friction_coefficient = 0.3;  // mu, the nominal value
  double thickness = 0.0;             // > 0, m: the least distance of two of its surfaces
};

// Nodes with an exact prescribed position. An empty path: they stay where they are at the start.
struct Handles {
  std::vector<int> nodes;
  HandlePath path;  // of nodes.size() handles, in the same order; times on the scene's clock
  // Where the cloth also leaves them with a prescribed slope (sim/scene/attached_handles.h): the direction, a unit
  // vector at right angles to the edge, in which it does.
  std::vector<ClampedEdge> clamped = {};
  HandlePath slopes = {};  // of clamped.size() directions, in the same order; 1
  // The paths of bodies that take groups of them along, in the order of the text of the scene; what they do stands
  // above.
  std::vector<std::shared_ptr<const RigidPath>> bodies = {};
};

// What is believed of a parameter before a recording is looked at: that it is normally distributed, or, of a parameter
// that spans decades, that its logarithm is.
struct ParameterPrior {
  double center = std::numeric_limits<double>::quiet_NaN();  // the mean; of a logarithm the median. NaN: none
  double spread =
      std::numeric_limits<double>::quiet_NaN();  // > 0: the standard deviation; of a logarithm its factor > 1

  bool is_given() const { return !std::isnan(center); }
};

// Whether nearly all that is known of such a parameter is a factor, so that fits and priors take its logarithm: every
// one but friction, which may be zero, and k_poisson, which may be negative.
bool IsLogarithmic(ParameterKind kind);

// Properties of a parameter in a fit; absent values mean "not given".
struct ParameterRange {
  double nominal = std::numeric_limits<double>::quiet_NaN();
  double lower_bound = std::numeric_limits<double>::quiet_NaN();
  double upper_bound = std::numeric_limits<double>::quiet_NaN();
  bool frozen = false;
  ParameterPrior prior;  // not of one that is frozen
};

struct SolverOptions {
  double step_tolerance = 1e-8;      // residual of a step, relative to its largest term; at least the rounding floor
  double adjoint_tolerance = 1e-12;  // relative residual of the linear solves of both derivative sweeps
  int max_newton_iterations = 200;   // from one start
  int max_substep_halvings = 6;      // h/2, h/4, .. before a step counts as failed
};

struct Scene {
  double time_step = 0.005;  // h, s
  Integrator integrator = Integrator::kSdirk2;
  double start_time = 0.0;                                     // s, on the clock of wind and handle path
  double duration = 1.0;                                       // s
  Eigen::Vector3d gravity = Eigen::Vector3d(0.0, 0.0, -9.81);  // g_0, m/s^2
  Eigen::Vector3d node_force = Eigen::Vector3d::Zero();        // N, the same on every node
  Wind wind;                                                   // nominal
  AirLaw air_law = AirLaw::kLinear;                            // of drag by direction
  ContactMode contact_mode = ContactMode::kGap;
  double touch = 1e-5;               // velocity mode: the gap that counts as contact, relative to the cloth's size
  double depenetration_speed = 1.0;  // m/s, gap mode: the most with which a start inside an obstacle is pushed out
  Mesh mesh;
  Eigen::VectorXd initial_positions;   // x_0 [3N] m
  Eigen::VectorXd initial_velocities;  // v_0 [3N] m/s
  Handles handles;
  std::vector<SceneObstacle> obstacles;
  std::optional<SelfContact> self_contact;  // none: the cloth goes through itself
  Material material;                        // nominal
  std::string fabric;  // whose measured constants stand in for those that the scene does not give; empty: none
  Bending bending;     // of a cloth with k_b > 0, or with orthotropic bending
  MembraneLaw membrane = MembraneLaw::kArap;
  Warp warp;                      // of a membrane or bending that is orthotropic
  std::vector<GridField> fields;  // constants that vary over the cloth; their levels replace those of `material`
  std::vector<Material> pieces;   // nominal, as `Parameters` has them: the mesh has piece_names
  std::map<std::string, ParameterRange> parameters;  // by parameter name
  SolverOptions solver;

  // Which terms a model of the scene has: those with a constant that is not 0.
  bool has_bending() const;
  bool has_warp() const { return membrane != MembraneLaw::kArap || bending.orthotropic; }
  bool has_drag() const;              // the same in every direction
  bool has_directional_drag() const;  // drag_normal or drag_tangential
  bool has_air() const { return has_drag() || has_directional_drag(); }
  bool has_wind() const { return has_air() && !nominal_parameters().wind.is_still(); }
  bool has_damping() const;
  bool has_moving_obstacles() const;
  // Whether the laws of the scene have such a parameter. k_bend, damping, drag of either kind and wind count as there
  // where their term has the nominal value 0.
  bool has(ParameterKind kind) const;
  // The same, and the obstacle that moves, the knot or the piece that `id` is of. The numbers are those of the scene.
  bool has(ParameterId id) const;
  // Whether a model of the scene has what a constant of the material multiplies.
  bool has_term(ParameterKind kind) const;
  // Whether its pieces have such a parameter each: not of a constant that is a field.
  bool has_of_pieces(ParameterKind kind) const;
  std::vector<ParameterId> piece_parameters() const;  // those, piece by piece, of terms that the scene has

  int num_steps() const;  // the least number of steps that covers `duration`
  std::vector<std::string> obstacle_names() const;
  // `parameters` where they give a nominal value, else the levels of `fields`, `material`, `pieces`, the obstacles' mu
  // and `wind`.
  Parameters nominal_parameters() const;
  // Takes `material` and `pieces` over, so that the scene has the terms that the parameters have.
  void SetMaterials(const Parameters& parameters);
};

// The obstacles of a scene, which must outlive it, at one time.
class SurfacesAt {
 public:
  SurfacesAt(const Scene& scene, double time);
  // The surface of the obstacle that is nearest to `position`, its gap from the contact distance; without obstacles the
  // gap is infinite.
  SurfacePoint Nearest(const Eigen::Vector3d& position) const;

 private:
  const Scene& scene_;
  std::vector<std::shared_ptr<const Obstacle>> shapes_;
};

// Throws `Error` (kBadData), prefixed by `source`, unless mesh, handles, initial state, obstacles and numbers are
// usable.
void ValidateScene(const Scene& scene, const std::string& source);

// Throws `Error` (kBadData) unless every value is in its domain, placements are those of obstacles that move, bending
// stiffness, drag of either kind, damping and the constants of warp and weft are zero where the scene has no such term,
// the elastic energies are positive
// (`Indefinite`), fields are absent or those of the scene, finite, and the wind's profile has the times of the scene's.
void ValidateParameters(const Parameters& parameters, const Scene& scene, const std::string& source);
// The same, whatever the signs of energies are.
void ValidateDomains(const Parameters& parameters, const Scene& scene, const std::string& source);

// Why an elastic energy is negative for some strain: "k_poisson^2 must be below k_warp k_weft, and is ..". Empty where
// none is. No single parameter is out of its domain, so a fit that comes there has to turn back.
std::string Indefinite(const Parameters& parameters, const Scene& scene);

// `ParseParameter` of sim/scene/parameters.h for a parameter of the scene. Throws `Error` (kUsage) that lists those
// that it has.
ParameterId ParseParameter(const std::string& name, const Scene& scene);

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_SCENE_H_
