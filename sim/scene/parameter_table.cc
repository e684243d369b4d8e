#include "sim/scene/parameter_table.h"

#include <algorithm>
#include <cmath>

namespace clothid {
namespace {

using Term = ParameterTerm;
using Need = ParameterNeed;
using Domain = ParameterDomain;
using Part = ParameterPart;

constexpr char kArealDrag[] = "kg/(m^2 s)";

ParameterRow ConstantRow(ParameterKind kind, const char* name, const char* unit, Term term, Need need, Domain domain,
                         double Material::*constant, Part part = Part::kPiece) {
  ParameterRow row{kind, name, unit, term, need, domain};
  row.constant = constant;
  row.part = part;
  return row;
}

ParameterRow FrictionRow(ParameterKind kind, const char* name, Term term, Need need, Part part) {
  ParameterRow row{kind, name, "", term, need, Domain::kNotNegative, kMaxFriction};
  row.part = part;
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
                     Eigen::Vector3d Wind::*vector) {
  ParameterRow row{kind, name, unit, Term::kWind, Need::kNothing, Domain::kAny, range, /*num_axes=*/3};
  row.wind_vector = vector;
  if (vector == &Wind::mean) row.part = Part::kKnot;
  return row;
}

ParameterRow SizeRow() {
  ParameterRow row{ParameterKind::kSize, "size", "", Term::kSize, Need::kNothing, Domain::kPositive, /*range=*/1.25};
  row.num_axes = 2;
  row.prior_spread = 1.03;
  return row;
}

ParameterRow PathRow(ParameterKind kind, const char* name, const char* unit, double range, int num_axes,
                     PlacementPart placement) {
  ParameterRow row{kind, name, unit, Term::kPlacement, Need::kMovingObstacle, Domain::kAny, range, num_axes};
  row.part = Part::kObstacle;
  row.has_whole = false;
  row.placement = placement;
  return row;
}

ParameterRow RecordingRow(ParameterKind kind, const char* name, const char* unit, Term term, double range, int num_axes,
                          double prior_spread = 0.0) {
  ParameterRow row{kind, name, unit, term, Need::kNothing, Domain::kAny, range, num_axes};
  row.prior_spread = prior_spread;
  return row;
}

ParameterRow OfHandleGroups(ParameterRow row, bool has_whole) {
  row.part = Part::kHandleGroup;
  row.has_whole = has_whole;
  return row;
}

std::vector<ParameterRow> MakeTable() {
  const double kSpeed = 10.0, kFrequency = 10.0, kWave = 10.0, kShear = 10.0;  // m/s, rad/s, rad/m, 1/m
  const double kOffset = 0.1, kShift = 0.05, kTurn = 0.2;  // s, m, rad: how far a measured path is off at the most
  const double kStartSpeed = 2.0;                          // m/s
  const double kFrameIntervals = 2.0, kShareOfCloth = 0.25, kHandleShareOfCloth = 0.1;
  // The second moves the fingers of a tool 0.3 m wide by as much as the first. (A depth camera that took the corners of
  // a cloth as its handles placed two handles 0.3 m apart 266 to 302 mm from each other.)
  const double kHandleShiftSpread = 0.01, kHandleTurnSpread = 0.05;  // m, rad
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
                  Domain::kNotNegative, &Material::normal_drag, Part::kNone),
      ConstantRow(ParameterKind::kTangentialDrag, "drag_tangential", kArealDrag, Term::kDirectionalDrag, Need::kNothing,
                  Domain::kNotNegative, &Material::tangential_drag, Part::kNone),
      ConstantRow(ParameterKind::kAddedMass, "added_mass", "kg/m^2", Term::kMass, Need::kNothing, Domain::kNotNegative,
                  &Material::added_mass, Part::kNone),
      PressureRow(ParameterKind::kPressure, "pressure"),
      FrictionRow(ParameterKind::kFriction, "mu", Term::kFriction, Need::kNothing, Part::kObstacle),
      FrictionRow(ParameterKind::kSelfFriction, "mu.self", Term::kSelfFriction, Need::kSelfContact, Part::kNone),
      WindRow(ParameterKind::kWind, "wind", "m/s", kSpeed, &Wind::mean),
      WindRow(ParameterKind::kGust, "gust", "m/s", kSpeed, &Wind::gust),
      WindRow(ParameterKind::kGustFrequency, "gust.frequency", "rad/s", kFrequency, &Wind::frequency),
      WindRow(ParameterKind::kGustPhase, "gust.phase", "rad", M_PI, &Wind::phase),
      WindRow(ParameterKind::kGustWave, "gust.wave", "rad/m", kWave, &Wind::wave_vector),
      WindRow(ParameterKind::kWindShear, "wind.shear", "1/m", kShear, &Wind::shear),
      SizeRow(),
      PathRow(ParameterKind::kPathTimeOffset, ".time_offset", "s", kOffset, 0, PlacementPart::kTimeOffset),
      PathRow(ParameterKind::kPathShift, ".shift", "m", kShift, 3, PlacementPart::kShiftX),
      PathRow(ParameterKind::kPathTurn, ".turn", "rad", kTurn, 3, PlacementPart::kTurnX),
      RecordingRow(ParameterKind::kTimeOffset, "time_offset", "s", Term::kClock, kFrameIntervals, 0),
      RecordingRow(ParameterKind::kShift, "shift", "m", Term::kFrame, kShareOfCloth, 3),
      RecordingRow(ParameterKind::kTurn, "turn", "rad", Term::kFrame, kTurn, 3),
      RecordingRow(ParameterKind::kStartVelocity, "v0", "m/s", Term::kStart, kStartSpeed, 3),
      OfHandleGroups(RecordingRow(ParameterKind::kHandleShift, "handle_shift", "m", Term::kHandles, kHandleShareOfCloth,
                                  3, kHandleShiftSpread),
                     /*has_whole=*/true),
      RecordingRow(ParameterKind::kHandleTurn, "handle_turn", "rad", Term::kHandles, kTurn, 3, kHandleTurnSpread),
      OfHandleGroups(RecordingRow(ParameterKind::kForceBias, "force_bias", "N", Term::kForces, /*range=*/1.0, 3),
                     /*has_whole=*/false),
  };
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

const std::vector<ParameterKind>& MaterialKinds() {
  static const std::vector<ParameterKind> kinds = [] {
    std::vector<ParameterKind> all;
    for (const ParameterRow& row : ParameterTable()) {
      if (row.constant != nullptr) all.push_back(row.kind);
    }
    return all;
  }();
  return kinds;
}

bool Material::operator==(const Material& other) const {
  const std::vector<ParameterKind>& kinds = MaterialKinds();
  return std::all_of(kinds.begin(), kinds.end(),
                     [&](ParameterKind kind) { return this->*RowOf(kind).constant == other.*RowOf(kind).constant; });
}

}  // namespace clothid
