#include "costs/field/field_request.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/scene/material_field.h"

namespace clothid {
namespace {

std::optional<int> ParseSide(std::string_view text) {
  const std::optional<double> side = ParseNumber(text);
  if (!side || *side < 1.0 || *side > kMaxFieldSide || *side != static_cast<int>(*side)) return std::nullopt;
  return static_cast<int>(*side);
}

FieldRequest ParseRequest(std::string_view item) {
  const std::size_t colon = item.find(':'), cross = item.find('x', colon == item.npos ? 0 : colon);
  const auto rows =
      colon == item.npos || cross == item.npos ? std::nullopt : ParseSide(item.substr(colon + 1, cross - colon - 1));
  const auto columns = cross == item.npos ? std::nullopt : ParseSide(item.substr(cross + 1));
  if (!rows || !columns) {
    throw Error(ErrorKind::kUsage, "--field: expected NAME:ROWSxCOLUMNS, rows and columns from 1 to " +
                                       std::to_string(kMaxFieldSide) + ", got '" + Printable(std::string(item)) + "'");
  }
  FieldRequest request;
  request.name = std::string(item.substr(0, colon));
  request.rows = *rows;
  request.columns = *columns;
  request.kind = ParseFieldKind(request.name, "--field");
  return request;
}

// A constant varies as a field or from piece to piece.
void ExpectNoPieces(const Scene& scene, ParameterId id) {
  double Material::*const constant = RowOf(id.kind).constant;
  for (const Material& piece : scene.pieces) {
    if (piece.*constant == scene.material.*constant) continue;
    throw Error(ErrorKind::kUsage, "--field: '" + ParameterName(id, {}) +
                                       "' differs between the pieces of the scene, so it can be no field");
  }
}

}  // namespace

std::vector<FieldRequest> ParseFieldRequests(const std::string& text) {
  std::vector<FieldRequest> requests;
  if (Trimmed(text).empty()) return requests;
  int size = 0;
  for (const std::string& item : Split(text, ',')) {
    const FieldRequest request = ParseRequest(Trimmed(item));
    for (const FieldRequest& other : requests) {
      if (other.kind == request.kind) throw Error(ErrorKind::kUsage, "--field: '" + request.name + "' is given twice");
    }
    size += request.size();
    requests.push_back(request);
  }
  if (size > kMaxFieldUnknowns) {
    throw Error(ErrorKind::kUsage, "--field: " + std::to_string(size) + " unknowns; expected at most " +
                                       std::to_string(kMaxFieldUnknowns));
  }
  return requests;
}

void SetField(const GridField& field, std::vector<RecordedMotion>* motions) {
  for (RecordedMotion& motion : *motions) {
    Scene& scene = motion.scene;
    const auto known = std::find_if(scene.fields.begin(), scene.fields.end(),
                                    [&](const GridField& other) { return other.kind == field.kind; });
    if (known == scene.fields.end()) {
      scene.fields.push_back(field);
    } else {
      *known = field;
    }
    double level = 0.0;
    FieldOverTriangles(field, scene.mesh, &level);
    const ParameterId id{field.kind};
    ExpectNoPieces(scene, id);
    Parameters parameters{scene.material, {}, nullptr};
    parameters.pieces = scene.pieces;
    SetParameter(id, level, &parameters);
    scene.SetMaterials(parameters);
    const auto range = scene.parameters.find(ParameterName(id, {}));
    if (range != scene.parameters.end() && !std::isnan(range->second.nominal)) range->second.nominal = level;
  }
}

}  // namespace clothid
