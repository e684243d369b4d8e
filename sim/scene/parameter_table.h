// What is known of each kind of parameter, a row each: name, axes and parts, unit, values, where a scene keeps it and
// what it belongs to. Whoever reads, names, bounds or lists parameters asks the table.
#ifndef CLOTHID_SIM_SCENE_PARAMETER_TABLE_H_
#define CLOTHID_SIM_SCENE_PARAMETER_TABLE_H_

#include <Eigen/Core>
#include <vector>

#include "sim/air/wind.h"
#include "sim/path/placement.h"

namespace clothid {

// The constants of a cloth.
struct Material {
  double density = 0.15;             // rho, kg/m^2
  double stretch_stiffness = 100.0;  // k, N/m
  double bending_stiffness = 0.0;    // k_b, N m; 0: the scene has no bending
  double drag = 0.0;                 // c_d, kg/(m^2 s), the same in every direction; 0: the scene has no such drag
  double damping = 0.0;              // eta, N s/m; 0: the scene has no internal damping. eta/k is a relaxation time
  // Of an orthotropic membrane, in place of k: C_11, C_22, C_66 and C_12, N/m (sim/shell/orthotropic_energy.h). One of
  // yarns has them at zero strain, and stiffens by b_1 and b_2 (sim/shell/yarn_energy.h).
  double warp_stiffness = 0.0, weft_stiffness = 0.0, shear_stiffness = 0.0, poisson_stiffness = 0.0;
  double warp_stiffening = 0.0, weft_stiffening = 0.0;
  // Of orthotropic bending, in place of k_b: D_11, D_22 and D_66, N m (sim/shell/bending_patch.h).
  double warp_bending = 0.0, weft_bending = 0.0, twist_bending = 0.0;

  // c_n and c_t of drag by direction: kg/(m^2 s), or kg/m^3 where the law of the air is quadratic
  // (sim/force/directional_drag.h). Both 0: the scene has none.
  double normal_drag = 0.0, tangential_drag = 0.0;
  double added_mass = 0.0;  // m_a, kg/m^2: air that moves with the cloth; inertia without weight
  double pressure = 0.0;    // p, Pa, of the air on the cloth's back (sim/force/pressure_term.h); 0: the scene has none

  double areal_inertia() const { return density + added_mass; }  // kg/m^2

  bool operator==(const Material& other) const;
};

enum class ParameterKind {
  kStretchStiffness,
  kBendingStiffness,
  kDensity,
  kDrag,
  kDamping,
  kWarpStiffness,
  kWeftStiffness,
  kShearStiffness,
  kPoissonStiffness,
  kWarpStiffening,
  kWeftStiffening,
  kWarpBending,
  kWeftBending,
  kTwistBending,
  kNormalDrag,
  kTangentialDrag,
  kAddedMass,
  kPressure,
  kFriction,
  kSelfFriction,  // of the cloth against itself
  kWind,          // the mean, or a knot of the profile
  kGust,
  kGustFrequency,
  kGustPhase,
  kGustWave,
  kWindShear,
  kSize,            // of the cloth at rest
  kPathTimeOffset,  // of an obstacle that moves
  kPathShift,
  kPathTurn,
  kTimeOffset,  // of a recording (costs/prediction/alignment.h), as all that follow
  kShift,
  kTurn,
  kStartVelocity,
  kHandleShift,
  kHandleTurn,
  kForceBias,
};

// The part of a scene, or of a recording, that a parameter belongs to. What those of a scene are derived by:
// MomentumDerivative and ImpulseDerivative of sim/derivative/step_derivative.h, ParameterDerivative of
// sim/rollout/handle_forces.h.
enum class ParameterTerm {
  kMembrane,
  kBending,
  kMass,
  kDrag,             // the same in every direction
  kDirectionalDrag,  // by direction
  kPressure,
  kDamping,
  kFriction,
  kSelfFriction,
  kWind,
  kSize,
  kPlacement,  // of an obstacle's path
  kClock,      // of a recording, as all that follow
  kFrame,      // of reference
  kStart,
  kHandles,
  kForces,
};

// What a kind has parts of, each a parameter of its own: the obstacles, the knots of the wind's profile, the pieces of
// the cloth, groups of handles.
enum class ParameterPart { kNone, kObstacle, kKnot, kPiece, kHandleGroup };

// What a scene must have for a parameter.
enum class ParameterNeed {
  kNothing,
  kArapMembrane,
  kOrthotropicMembrane,  // or of yarns
  kYarnMembrane,
  kIsotropicBending,
  kOrthotropicBending,
  kSelfContact,
  kMovingObstacle,
};

// Values that a parameter can have; finite ones.
enum class ParameterDomain { kPositive, kNotNegative, kAny };

// The largest friction coefficient that a fit looks for, unless bounds are given.
inline constexpr double kMaxFriction = 2.0;

struct ParameterRow {
  ParameterKind kind;
  const char* name;  // "k_stretch", "wind", before axis and part; of the path of an obstacle what follows it, ".shift"
  const char* unit;  // "N/m"; empty: a number
  ParameterTerm term;
  ParameterNeed need;
  ParameterDomain domain;
  // How far a fit looks for what has bounds of its own kind: friction from 0 to here, what may be negative to both
  // sides of 0, and twice as far as the nominal value; the stiffening of yarns from a thousandth of it; the size of the
  // cloth by this factor up and down; of a recording see `DefaultAlignmentRange`. 0: what is measured of fabrics, or
  // how far the start is, says more (costs/prediction/parameter_block.h).
  double range = 0.0;
  int num_axes = 0;  // 0: it has none, and `ParameterId::axis` is 0; else the first of x, y, z
  ParameterPart part = ParameterPart::kNone;
  bool has_whole = true;  // whether there is one of all parts at once, or beside them
  // What is believed unless a prior is given: of a logarithm the factor about 1, else the standard deviation about 0;
  // 0: nothing.
  double prior_spread = 0.0;

  // Where a scene keeps it: one of these is there, but for friction, size and what a placement has, from `placement`
  // on.
  double Material::*constant = nullptr;
  double Wind::*wind_number = nullptr;
  Eigen::Vector3d Wind::*wind_vector = nullptr;
  PlacementPart placement = PlacementPart::kTimeOffset;

  // Drag by direction in quadratic air, "kg/m^3", has another unit than in linear air.
  const char* UnitIn(AirLaw law) const;
};

// In the order in which lists name them.
const std::vector<ParameterRow>& ParameterTable();
const ParameterRow& RowOf(ParameterKind kind);

// Those of the material of the cloth, in that order.
const std::vector<ParameterKind>& MaterialKinds();

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_PARAMETER_TABLE_H_
