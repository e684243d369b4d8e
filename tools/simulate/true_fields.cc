#include "tools/simulate/true_fields.h"

#include <algorithm>
#include <limits>
#include <set>
#include <string_view>

#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/scene/material_field.h"
#include "sim/scene/materials_json.h"

namespace clothid {
namespace {

GridField ReadField(const std::string& item) {
  const std::size_t equals = item.find('=');
  const std::string name(Trimmed(std::string_view(item).substr(0, equals)));
  if (equals == std::string::npos) {
    throw Error(ErrorKind::kUsage, "--set_field: expected NAME=FILE, got '" + Printable(item) + "'");
  }
  return {ParseFieldKind(name, "--set_field"),
          ReadFieldValues(std::string(Trimmed(std::string_view(item).substr(equals + 1))))};
}

}  // namespace

void SetTrueFields(const std::string& text, Scene* scene) {
  if (text.empty()) return;
  std::set<ParameterKind> seen;
  for (const std::string& item : Split(text, ',')) {
    const GridField field = ReadField(item);
    const std::string name = ParameterName({field.kind}, {});
    if (!seen.insert(field.kind).second) {
      throw Error(ErrorKind::kUsage, "--set_field: '" + name + "' is given twice");
    }
    double Material::*const constant = RowOf(field.kind).constant;
    for (const Material& piece : scene->pieces) {
      if (piece.*constant == scene->material.*constant) continue;
      throw Error(ErrorKind::kUsage, "--set_field: '" + name + "' differs between the pieces of the scene");
    }
    std::vector<GridField>& fields = scene->fields;
    fields.erase(
        std::remove_if(fields.begin(), fields.end(), [&](const GridField& other) { return other.kind == field.kind; }),
        fields.end());
    fields.push_back(field);
    const auto range = scene->parameters.find(name);
    if (range != scene->parameters.end()) range->second.nominal = std::numeric_limits<double>::quiet_NaN();
  }
  SetLevels(scene);
}

}  // namespace clothid
