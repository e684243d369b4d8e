#include "sim/scene/parameter_table.h"

#include <algorithm>
#include <cmath>

namespace clothid {
namespace {

using Term = ParameterTerm;
using Need = ParameterNeed;
using Domain = ParameterDomain;
using Part = PlacementPart;

constexpr char kArealDrag[] = "kg/(m^2 s)";

ParameterRow ConstantRow(ParameterKind kind, const char* name, const char* unit, Term term, Need need, Domain domain,
                         double Material::*constant, bool can_be_of_piece = true) {
  ParameterRow row{kind, name, unit, term, need, domain};
  row.constant = constant;
  row.can_be_of_piece = can_be_of_piece;
  return row;
}

ParameterRow StiffeningRow(ParameterKind kind, const char* name, double Material::*constant) {
  ParameterRow row = ConstantRow(kind, name, "", Term::kMembrane, Need::kYarnMembrane, Domain::kNotNegative, constant);
  row.range = 50.0;
  return row;
}

ParameterRow PressureRow(ParameterKind kind, const char* name) {
  ParameterRow row{kind, name, "Pa", Term::kPressure, Need::kNothing, Domain::kAny, /*range=*/50.0};
  row.constant = &Material::pressure;
  return row;
}

ParameterRow WindRow(ParameterKind kind, const char* name, const char* unit, double range, double Wind::*number) {
  ParameterRow row{kind, name, unit, Term::kWind, Need::kNothing, Domain::kAny, range};
  row.wind_number = number;
  return row;
}

ParameterRow WindRow(ParameterKind kind, const char* name, const char* unit, double range,
                     Eigen::Vector3d Wind::*vector, int axis) {
  ParameterRow row{kind, name, unit, Term::kWind, Need::kNothing, Domain::kAny, range};
  row.wind_vector = vector;
  row.axis = axis;
  return row;
}

ParameterRow SizeRow(ParameterKind kind, const char* name, int axis) {
  ParameterRow row{kind, name, "", Term::kSize, Need::kNothing, Domain::kPositive, /*range=*/1.25};
  row.axis = axis;
  return row;
}

ParameterRow PathRow(ParameterKind kind, const char* name, const char* unit, double range, Part part) {
  ParameterRow row{kind, name, unit, Term::kPlacement, Need::kMovingObstacle, Domain::kAny, range};
  row.part = part;
  return row;
}

ParameterRow FrictionRow(ParameterKind kind, const char* name, Term term, Need need) {
  return {kind, name, "", term, need, Domain::kNotNegative, kMaxFriction};
}

std::vector<ParameterRow> MakeTable() {
  const double kSpeed = 10.0, kFrequency = 10.0, kWave = 10.0, kShear = 10.0;  // m/s, rad/s, rad/m, 1/m
  const double kOffset = 0.1, kShift = 0.05, kTurn = 0.2;  // s, m, rad: how far a measured path is off at the most
  return {
      ConstantRow(ParameterKind::kStretchStiffness, "k_stretch", "N/m", Term::kMembrane, Need::kArapMembrane,
                  Domain::kPositive, &Material::stretch_stiffness),
      ConstantRow(ParameterKind::kBendingStiffness, "k_bend", "N m", Term::kBending, Need::kIsotropicBending,
                  Domain::kNotNegative, &Material::bending_stiffness),
      ConstantRow(ParameterKind::kDensity, "density", "kg/m^2", Term::kMass, Need::kNothing, Domain::kPositive,
                  &Material::density),
      ConstantRow(ParameterKind::kDrag, "drag", kArealDrag, Term::kDrag, Need::kNothing, Domain::kNotNegative,
                  &Material::drag),
      ConstantRow(ParameterKind::kDamping, "damping", "N s/m", Term::kDamping, Need::kNothing, Domain::kNotNegative,
                  &Material::damping),
      ConstantRow(ParameterKind::kWarpStiffness, "k_warp", "N/m", Term::kMembrane, Need::kOrthotropicMembrane,
                  Domain::kPositive, &Material::warp_stiffness),
      ConstantRow(ParameterKind::kWeftStiffness, "k_weft", "N/m", Term::kMembrane, Need::kOrthotropicMembrane,
                  Domain::kPositive, &Material::weft_stiffness),
      ConstantRow(ParameterKind::kShearStiffness, "k_shear", "N/m", Term::kMembrane, Need::kOrthotropicMembrane,
                  Domain::kPositive, &Material::shear_stiffness),
      ConstantRow(ParameterKind::kPoissonStiffness, "k_poisson", "N/m", Term::kMembrane, Need::kOrthotropicMembrane,
                  Domain::kAny, &Material::poisson_stiffness),
      StiffeningRow(ParameterKind::kWarpStiffening, "stiffening_warp", &Material::warp_stiffening),
      StiffeningRow(ParameterKind::kWeftStiffening, "stiffening_weft", &Material::weft_stiffening),
      ConstantRow(ParameterKind::kWarpBending, "bend_warp", "N m", Term::kBending, Need::kOrthotropicBending,
                  Domain::kPositive, &Material::warp_bending),
      ConstantRow(ParameterKind::kWeftBending, "bend_weft", "N m", Term::kBending, Need::kOrthotropicBending,
                  Domain::kPositive, &Material::weft_bending),
      ConstantRow(ParameterKind::kTwistBending, "bend_twist", "N m", Term::kBending, Need::kOrthotropicBending,
                  Domain::kPositive, &Material::twist_bending),
      ConstantRow(ParameterKind::kNormalDrag, "drag_normal", kArealDrag, Term::kDirectionalDrag, Need::kNothing,
                  Domain::kNotNegative, &Material::normal_drag, /*can_be_of_piece=*/false),
      ConstantRow(ParameterKind::kTangentialDrag, "drag_tangential", kArealDrag, Term::kDirectionalDrag, Need::kNothing,
                  Domain::kNotNegative, &Material::tangential_drag, /*can_be_of_piece=*/false),
      ConstantRow(ParameterKind::kAddedMass, "added_mass", "kg/m^2", Term::kMass, Need::kNothing, Domain::kNotNegative,
                  &Material::added_mass, /*can_be_of_piece=*/false),
      PressureRow(ParameterKind::kPressure, "pressure"),
      FrictionRow(ParameterKind::kFriction, "mu", Term::kFriction, Need::kNothing),
      FrictionRow(ParameterKind::kSelfFriction, "mu.self", Term::kSelfFriction, Need::kSelfContact),
      WindRow(ParameterKind::kWindX, "wind.x", "m/s", kSpeed, &Wind::mean, 0),
      WindRow(ParameterKind::kWindY, "wind.y", "m/s", kSpeed, &Wind::mean, 1),
      WindRow(ParameterKind::kWindZ, "wind.z", "m/s", kSpeed, &Wind::mean, 2),
      WindRow(ParameterKind::kGustX, "gust.x", "m/s", kSpeed, &Wind::gust, 0),
      WindRow(ParameterKind::kGustY, "gust.y", "m/s", kSpeed, &Wind::gust, 1),
      WindRow(ParameterKind::kGustZ, "gust.z", "m/s", kSpeed, &Wind::gust, 2),
      WindRow(ParameterKind::kGustFrequency, "gust.frequency", "rad/s", kFrequency, &Wind::frequency),
      WindRow(ParameterKind::kGustPhase, "gust.phase", "rad", M_PI, &Wind::phase),
      WindRow(ParameterKind::kGustWaveX, "gust.wave.x", "rad/m", kWave, &Wind::wave_vector, 0),
      WindRow(ParameterKind::kGustWaveY, "gust.wave.y", "rad/m", kWave, &Wind::wave_vector, 1),
      WindRow(ParameterKind::kGustWaveZ, "gust.wave.z", "rad/m", kWave, &Wind::wave_vector, 2),
      WindRow(ParameterKind::kWindShearX, "wind.shear.x", "1/m", kShear, &Wind::shear, 0),
      WindRow(ParameterKind::kWindShearY, "wind.shear.y", "1/m", kShear, &Wind::shear, 1),
      WindRow(ParameterKind::kWindShearZ, "wind.shear.z", "1/m", kShear, &Wind::shear, 2),
      SizeRow(ParameterKind::kSizeX, "size.x", 0),
      SizeRow(ParameterKind::kSizeY, "size.y", 1),
      PathRow(ParameterKind::kPathTimeOffset, ".time_offset", "s", kOffset, Part::kTimeOffset),
      PathRow(ParameterKind::kPathShiftX, ".shift.x", "m", kShift, Part::kShiftX),
      PathRow(ParameterKind::kPathShiftY, ".shift.y", "m", kShift, Part::kShiftY),
      PathRow(ParameterKind::kPathShiftZ, ".shift.z", "m", kShift, Part::kShiftZ),
      PathRow(ParameterKind::kPathTurnX, ".turn.x", "rad", kTurn, Part::kTurnX),
      PathRow(ParameterKind::kPathTurnY, ".turn.y", "rad", kTurn, Part::kTurnY),
      PathRow(ParameterKind::kPathTurnZ, ".turn.z", "rad", kTurn, Part::kTurnZ),
  };
}

template <typename Condition>
std::vector<ParameterKind> KindsThat(const Condition& condition) {
  std::vector<ParameterKind> kinds;
  for (const ParameterRow& row : ParameterTable()) {
    if (condition(row)) kinds.push_back(row.kind);
  }
  return kinds;
}

}  // namespace

const char* ParameterRow::UnitIn(AirLaw law) const {
  return term == Term::kDirectionalDrag && law == AirLaw::kQuadratic ? "kg/m^3" : unit;
}

const std::vector<ParameterRow>& ParameterTable() {
  static const std::vector<ParameterRow> table = MakeTable();
  return table;
}

// The rows stand in the order of the enumeration: tests/sim/scene/parameter_table_test.cc.
const ParameterRow& RowOf(ParameterKind kind) { return ParameterTable()[static_cast<std::size_t>(kind)]; }

std::vector<ParameterKind> KindsOf(ParameterTerm term) {
  return KindsThat([term](const ParameterRow& row) { return row.term == term; });
}

const std::vector<ParameterKind>& MaterialKinds() {
  static const std::vector<ParameterKind> kinds =
      KindsThat([](const ParameterRow& row) { return row.constant != nullptr; });
  return kinds;
}

bool Material::operator==(const Material& other) const {
  const std::vector<ParameterKind>& kinds = MaterialKinds();
  return std::all_of(kinds.begin(), kinds.end(),
                     [&](ParameterKind kind) { return this->*RowOf(kind).constant == other.*RowOf(kind).constant; });
}

}  // namespace clothid
