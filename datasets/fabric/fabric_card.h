// fabric.json, the card of a cloth: what was told of its constants, for the next fit and for other simulators.
//
// It holds constants of the cloth alone: density, stretch, bending by patches (that of edges belongs to the mesh) and
// damping. Friction with an obstacle, air, start and placement are those of a recording.
//
//   {"schema": "clothid.fabric/1", "clothid": "0.4.0 (git ..)",
//    "membrane": "arap" | "orthotropic" | "yarn",
//    "bend_poisson": 0.0,
//    "constants": {"k_warp": {"value": .., "unit": "N/m", "known": "fitted" | "believed" | "assumed", "lower95": ..,
//      "upper95": .., "scatter": .., "seen": {"quantity": "strain" | "curvature_1_m", "from": .., "to": ..}}},
//    "recordings": [{"name": .., "sha256": .., "kind": .., "nodes": .., "edge_m": .., "time_step_s": .., "load_N":
//    ..}],
//    "missing_force": [{"deviation_N_m2": .., "time_s": .., "length_m": .., "factor": ..}]}
//
// "missing_force" is there where the fit found that its simulations lack one; older cards have one alone, no list.
//
// known: "fitted", with an interval; "believed", not fitted, with that of a prior; "assumed": a nominal value that
// nothing tells, without an interval. scatter: the standard deviation between specimens, of the logarithm but for
// k_poisson. What is not known is null.
#ifndef CLOTHID_DATASETS_FABRIC_FABRIC_CARD_H_
#define CLOTHID_DATASETS_FABRIC_FABRIC_CARD_H_

#include <limits>
#include <string>
#include <vector>

#include "sim/base/json_document.h"
#include "sim/scene/parameter_table.h"
#include "sim/scene/scene.h"

namespace clothid {

inline constexpr char kFabricCardName[] = "fabric.json";

enum class KnownBy { kFitted, kBelieved, kAssumed };

// NaN: not known. In the unit of its row of the table of parameters, sim/scene/parameter_table.h.
struct CardConstant {
  ParameterKind kind = ParameterKind::kDensity;
  double value = std::numeric_limits<double>::quiet_NaN();
  KnownBy known_by = KnownBy::kAssumed;
  double lower95 = std::numeric_limits<double>::quiet_NaN(), upper95 = std::numeric_limits<double>::quiet_NaN();
  double scatter = std::numeric_limits<double>::quiet_NaN();  // of the logarithm, where it is logarithmic
  // Strain for what stretches, curvature in 1/m for what bends: where nearly all of the cloth was, all of the time.
  double seen_from = std::numeric_limits<double>::quiet_NaN(), seen_to = std::numeric_limits<double>::quiet_NaN();

  bool is_told() const { return known_by != KnownBy::kAssumed; }
  // Of one that is told: about its value, as wide as interval and scatter together. The cloth of the next fit is
  // another specimen.
  ParameterPrior Prior() const;
  // Takes over what is believed and nothing has narrowed: without scatter its `Prior` is this one again.
  void Believe(const ParameterPrior& prior);
};

// How it was measured.
struct CardRecording {
  std::string name, sha256;
  std::string kind;                                        // "tensile curve", "motion", "motion with forces"
  int num_nodes = 0;                                       // of the mesh of the fit
  double edge_length = 0.0;                                // m, the mean of that mesh
  double time_step = 0.0;                                  // s
  double load = std::numeric_limits<double>::quiet_NaN();  // N, the largest that a gauge read
};

// What its simulations were found to lack, as a random force per area: its deviation is `factor`, of a calibration of
// bands, times what the fitted recordings told.
struct CardForce {
  double deviation = 0.0, time = 0.0, length = 0.0;  // N/m^2, s, m
  double factor = 1.0;
};

struct FabricCard {
  std::string program;  // that wrote it
  MembraneLaw membrane = MembraneLaw::kArap;
  double bend_poisson = 0.0;
  std::vector<CardConstant> constants;  // in the order of the table
  std::vector<CardRecording> recordings;
  std::vector<CardForce> missing_forces;  // which add up

  const CardConstant* Find(ParameterKind kind) const;  // null: it has none
  bool tells_any() const;
};

// "arap", "orthotropic", "yarn".
const char* MembraneName(MembraneLaw law);

// Whether a card may hold it, whatever its law.
bool IsOfFabric(ParameterKind kind);
// "strain", "curvature_1_m"; of density and damping null.
const char* SeenQuantity(ParameterKind kind);

std::string FabricCardJson(const FabricCard& card);

// Whether a JSON text says that it is one.
bool IsFabricCard(const JsonNode& root);

// Throw `Error` (kIo, kBadData), naming file and key and what was expected there.
FabricCard ReadFabricCard(const std::string& path);
FabricCard ParseFabricCard(const JsonNode& root);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FABRIC_FABRIC_CARD_H_
