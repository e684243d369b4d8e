// What is known of each kind of parameter, a row each: name, unit, values, where a scene keeps it and what it belongs
// to. Whoever reads, names, bounds or lists parameters asks the table.
#ifndef CLOTHID_SIM_SCENE_PARAMETER_TABLE_H_
#define CLOTHID_SIM_SCENE_PARAMETER_TABLE_H_

#include <Eigen/Core>
#include <vector>

#include "sim/air/wind.h"
#include "sim/path/placement.h"
#include "sim/scene/material.h"

namespace clothid {

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
  kWindX,         // the mean, or a knot of the profile
  kWindY,
  kWindZ,
  kGustX,
  kGustY,
  kGustZ,
  kGustFrequency,
  kGustPhase,
  kGustWaveX,
  kGustWaveY,
  kGustWaveZ,
  kWindShearX,
  kWindShearY,
  kWindShearZ,
  kSizeX,  // of the cloth at rest
  kSizeY,
  kPathTimeOffset,  // of an obstacle that moves
  kPathShiftX,
  kPathShiftY,
  kPathShiftZ,
  kPathTurnX,
  kPathTurnY,
  kPathTurnZ,
};

// The part of a scene that a parameter belongs to. What each is derived by: MomentumDerivative and ImpulseDerivative of
// sim/derivative/step_derivative.h, ParameterDerivative of sim/rollout/handle_forces.h.
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
};

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
  const char* name;  // "k_stretch"; of the path of an obstacle what follows its name, ".shift.x"
  const char* unit;  // "N/m"; empty: a number
  ParameterTerm term;
  ParameterNeed need;
  ParameterDomain domain;
  // How far a fit looks for what has bounds of its own kind: friction from 0 to here, what may be negative to both
  // sides of 0, and twice as far as the nominal value; the stiffening of yarns from a thousandth of it; the size of the
  // cloth by this factor up and down. 0: what is measured of fabrics, or how far the start is, says more
  // (costs/prediction/parameter_block.h).
  double range = 0.0;

  // Where it is kept: one of these is there, but for friction, size and what a placement has by its part.
  double Material::*constant = nullptr;
  bool can_be_of_piece = false;  // of the cloth (a `constant`)
  double Wind::*wind_number = nullptr;
  Eigen::Vector3d Wind::*wind_vector = nullptr;
  // Of a wind's vector and of a size: 0, 1, 2 for x, y, z.
  int axis = 0;
  PlacementPart part = PlacementPart::kTimeOffset;

  // Drag by direction in quadratic air, "kg/m^3", has another unit than in linear air.
  const char* UnitIn(AirLaw law) const;
};

// In the order in which lists name them.
const std::vector<ParameterRow>& ParameterTable();
const ParameterRow& RowOf(ParameterKind kind);

// Those of one term, or of the material of the cloth, in that order.
std::vector<ParameterKind> KindsOf(ParameterTerm term);
const std::vector<ParameterKind>& MaterialKinds();

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_PARAMETER_TABLE_H_
