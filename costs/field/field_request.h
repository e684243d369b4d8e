// What `identify --field k_stretch:8x8` asks for: a constant of the material as a field (sim/scene/material_field.h).
// Its values at the control nodes are unknowns of every recording (costs/field/field_unknowns.h), its level is a
// parameter.
#ifndef CLOTHID_COSTS_FIELD_FIELD_REQUEST_H_
#define CLOTHID_COSTS_FIELD_FIELD_REQUEST_H_

#include <string>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "sim/scene/material_field.h"
#include "sim/scene/parameters.h"

namespace clothid {

struct FieldRequest {
  std::string name;  // "k_stretch"
  ParameterKind kind = ParameterKind::kStretchStiffness;
  int rows = 0, columns = 0;  // of the control grid

  int size() const { return rows * columns; }
};

inline constexpr int kMaxFieldUnknowns = 4096;  // of all fields

// "k_stretch:8x8,density:4x4", NAME:ROWSxCOLUMNS. Throws `Error` (kUsage) naming the item that is none, a name that can
// be no field or is given twice, and more unknowns than kMaxFieldUnknowns.
std::vector<FieldRequest> ParseFieldRequests(const std::string& text);

// Makes `field` one of every scene, in place of the one that it has of that constant, its level and nominal value.
void SetField(const GridField& field, std::vector<RecordedMotion>* motions);

}  // namespace clothid

#endif  // CLOTHID_COSTS_FIELD_FIELD_REQUEST_H_
