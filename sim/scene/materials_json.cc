#include "sim/scene/materials_json.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "sim/fabric/fabric.h"
#include "sim/mesh/mesh_json.h"

namespace clothid {
namespace {

using Kind = JsonValue::Kind;

void ReadNonNegative(const JsonNode& object, const char* key, double* value) {
  if (const auto node = object.Find(key)) *value = node->NonNegativeNumber();
}

void ReadPositive(const JsonNode& object, const char* key, double* value) {
  if (const auto node = object.Find(key)) *value = node->PositiveNumber();
}

// One that no law of the scene decides about.
void ReadFreeConstant(const JsonNode& materials, const ParameterRow& row, Material* material) {
  const auto node = materials.Find(row.name);
  if (row.need != ParameterNeed::kNothing || !node) return;
  material->*row.constant = row.domain == ParameterDomain::kPositive      ? node->PositiveNumber()
                            : row.domain == ParameterDomain::kNotNegative ? node->NonNegativeNumber()
                                                                          : node->Number();
}

void ReadBendRest(const JsonNode& node, Bending* bending) {
  if (!node.is(Kind::kString) || (node.String() != "mesh" && node.String() != "flat")) {
    node.Fail("expected \"mesh\" or \"flat\"");
  }
  bending->is_flat_at_rest = node.String() == "flat";
  if (!bending->is_flat_at_rest && bending->law != BendingLaw::kPatches) {
    node.Fail("expected \"bending\": \"patches\" beside it");
  }
}

void ReadBending(const JsonNode& materials, Bending* bending) {
  if (const auto law = materials.Find("bending")) {
    if (!law->is(Kind::kString) || (law->String() != "edges" && law->String() != "patches")) {
      law->Fail("expected \"edges\" or \"patches\"");
    }
    bending->law = law->String() == "edges" ? BendingLaw::kEdges : BendingLaw::kPatches;
  }
  if (const auto rest = materials.Find("bend_rest")) ReadBendRest(*rest, bending);
  const auto poisson = materials.Find("bend_poisson");
  if (!poisson) return;
  if (!poisson->is(Kind::kNumber) || !(std::abs(poisson->Number()) < 1.0)) {
    poisson->Fail("expected a number between -1 and 1");
  }
  if (bending->law != BendingLaw::kPatches) poisson->Fail("expected \"bending\": \"patches\" beside it");
  bending->poisson = poisson->Number();
}

// Either the keys of `several`, all of them, or `one`, or none: whether it is `several`.
bool HasSeveral(const JsonNode& materials, const char* one, const std::vector<const char*>& several) {
  const auto is_there = [&](const char* key) { return materials.Find(key).has_value(); };
  if (std::none_of(several.begin(), several.end(), is_there)) return false;
  if (is_there(one)) {
    const auto found = std::find_if(several.begin(), several.end(), is_there);
    materials.Find(one)->Fail(std::string("expected none beside '") + *found + "'");
  }
  for (const char* key : several) materials.Require(key, "a number > 0");
  return true;
}

void SetMeasured(const MeasuredConstant& constant, double* value) {
  if (!std::isnan(constant.typical)) *value = constant.typical;
}

// What was measured of the scene's fabric along warp and weft. False: nothing.
bool SetWarpAndWeft(Scene* scene) {
  const Fabric* fabric = FindFabric(scene->fabric);
  if (fabric == nullptr || std::isnan(fabric->k_warp.typical)) return false;
  Material& material = scene->material;
  SetMeasured(fabric->k_warp, &material.warp_stiffness);
  SetMeasured(fabric->k_weft, &material.weft_stiffness);
  SetMeasured(fabric->k_shear, &material.shear_stiffness);
  if (scene->membrane != MembraneLaw::kYarn) return true;
  SetMeasured(fabric->stiffening_warp, &material.warp_stiffening);
  SetMeasured(fabric->stiffening_weft, &material.weft_stiffening);
  return true;
}

void ReadMembrane(const JsonNode& materials, Scene* scene) {
  if (const auto law = materials.Find("membrane")) {
    const std::map<std::string, MembraneLaw> laws = {
        {"arap", MembraneLaw::kArap}, {"orthotropic", MembraneLaw::kOrthotropic}, {"yarn", MembraneLaw::kYarn}};
    const auto known = law->is(Kind::kString) ? laws.find(law->String()) : laws.end();
    if (known == laws.end()) law->Fail("expected \"arap\", \"orthotropic\" or \"yarn\"");
    scene->membrane = known->second;
  }
  const bool has_constants = HasSeveral(materials, "k_stretch", {"k_warp", "k_weft", "k_shear"});
  const auto poisson = materials.Find("k_poisson");
  for (const char* key : {"stiffening_warp", "stiffening_weft"}) {
    const auto node = materials.Find(key);
    if (node && scene->membrane != MembraneLaw::kYarn) node->Fail("expected \"membrane\": \"yarn\" beside it");
  }
  if (scene->membrane == MembraneLaw::kArap) {
    for (const char* key : {"k_warp", "k_poisson"}) {
      const auto node = materials.Find(key);
      if (node) node->Fail("expected \"membrane\": \"orthotropic\" or \"yarn\" beside it");
    }
    ReadPositive(materials, "k_stretch", &scene->material.stretch_stiffness);
    return;
  }
  const bool is_measured = !has_constants && SetWarpAndWeft(scene);
  if (!has_constants && !is_measured) {
    materials.Require("k_warp", "a number > 0 (N/m), as the membrane has warp and weft");
  }
  ReadPositive(materials, "k_warp", &scene->material.warp_stiffness);
  ReadPositive(materials, "k_weft", &scene->material.weft_stiffness);
  ReadPositive(materials, "k_shear", &scene->material.shear_stiffness);
  if (poisson) scene->material.poisson_stiffness = poisson->Number();
  ReadNonNegative(materials, "stiffening_warp", &scene->material.warp_stiffening);
  ReadNonNegative(materials, "stiffening_weft", &scene->material.weft_stiffening);
}

void ReadRigidities(const JsonNode& materials, Scene* scene) {
  scene->bending.orthotropic = HasSeveral(materials, "k_bend", {"bend_warp", "bend_weft", "bend_twist"});
  const bool has_rigidity = scene->bending.law == BendingLaw::kPatches && !scene->bending.orthotropic;
  if (!has_rigidity) scene->material.bending_stiffness = 0.0;  // that of a fabric
  ReadNonNegative(materials, "k_bend", &scene->material.bending_stiffness);
  if (!scene->bending.orthotropic) return;
  if (scene->bending.law != BendingLaw::kPatches) {
    materials.Find("bend_warp")->Fail("expected \"bending\": \"patches\" beside it");
  }
  ReadPositive(materials, "bend_warp", &scene->material.warp_bending);
  ReadPositive(materials, "bend_weft", &scene->material.weft_bending);
  ReadPositive(materials, "bend_twist", &scene->material.twist_bending);
}

// [[x, y, z], ..], one per triangle.
Eigen::Matrix3Xd ReadVectorList(const std::vector<JsonNode>& list) {
  Eigen::Matrix3Xd vectors(3, static_cast<Eigen::Index>(list.size()));
  for (std::size_t i = 0; i < list.size(); ++i) vectors.col(static_cast<Eigen::Index>(i)) = list[i].Vector3();
  return vectors;
}

void ReadWarpDirection(const JsonNode& node, const std::string& folder, Scene* scene) {
  Warp& warp = scene->warp;
  if (node.is(Kind::kString)) {
    if (node.String() != kWarpByUv) {
      warp.directions = ReadNpyVectors(node, folder, scene->mesh.num_faces());
    } else if (warp.directions.cols() == 0 && !scene->mesh.has_corner_rest()) {
      node.Fail("expected a mesh from an OBJ file beside it, whose UV map it is to follow");
    }
    return;
  }
  const std::vector<JsonNode> items = node.items();
  const bool is_list = !items.empty() && items[0].is(Kind::kArray);
  if (is_list) {
    warp.directions = ReadVectorList(items);
  } else {
    warp.direction = node.Vector3();
  }
}

void ReadWarp(const JsonNode& materials, const std::string& folder, Scene* scene) {
  for (const char* key : {"warp_direction", "warp_angle"}) {
    const auto node = materials.Find(key);
    if (node && !scene->has_warp()) node->Fail("expected an orthotropic membrane, or bend_warp, beside it");
  }
  if (const auto direction = materials.Find("warp_direction")) ReadWarpDirection(*direction, folder, scene);
  if (const auto angle = materials.Find("warp_angle")) scene->warp.angle = angle->Number();
}

Eigen::MatrixXd ReadControlGrid(const JsonNode& node) {
  const std::string expected = "expected 1 to " + std::to_string(kMaxFieldSide) + " rows of as many numbers > 0 each";
  const std::vector<JsonNode> rows = node.items();
  if (rows.empty() || rows.size() > kMaxFieldSide) node.Fail(expected);
  const std::size_t num_columns = rows.front().items().size();
  if (num_columns == 0 || num_columns > kMaxFieldSide) node.Fail(expected);
  Eigen::MatrixXd values(rows.size(), num_columns);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const std::vector<JsonNode> row = rows[r].items();
    if (row.size() != num_columns) rows[r].Fail("expected " + std::to_string(num_columns) + " numbers");
    for (std::size_t c = 0; c < num_columns; ++c) {
      values(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) = row[c].PositiveNumber();
    }
  }
  return values;
}

}  // namespace

bool WarpFollowsUv(const JsonNode& materials) {
  const auto direction = materials.Find("warp_direction");
  return direction && direction->is(Kind::kString) && direction->String() == kWarpByUv;
}

ParameterPrior ReadPrior(const JsonNode& node, ParameterKind kind) {
  ParameterPrior prior;
  if (!IsLogarithmic(kind)) {
    node.ExpectKeys({"mean", "std"});
    const JsonNode mean = node.Require("mean", "a number");
    prior.center = RowOf(kind).domain == ParameterDomain::kAny ? mean.Number() : mean.NonNegativeNumber();
    prior.spread = node.Require("std", "a standard deviation > 0").PositiveNumber();
    return prior;
  }
  node.ExpectKeys({"median", "factor"});
  prior.center = node.Require("median", "a number > 0").PositiveNumber();
  const JsonNode factor = node.Require("factor", "a number > 1");
  if (!factor.is(Kind::kNumber) || !(factor.Number() > 1.0)) factor.Fail("expected a number > 1");
  prior.spread = factor.Number();
  return prior;
}

void ReadFabric(const JsonNode& node, Scene* scene) {
  const Fabric* fabric = node.is(Kind::kString) ? FindFabric(node.String()) : nullptr;
  if (fabric == nullptr) node.Fail("expected one of " + FabricNames());
  scene->fabric = fabric->name;
  SetMeasured(fabric->density, &scene->material.density);
  SetMeasured(fabric->k_stretch, &scene->material.stretch_stiffness);
  // Bending by edges has another k_bend, which belongs to the mesh.
  if (scene->bending.law == BendingLaw::kPatches) SetMeasured(fabric->k_bend, &scene->material.bending_stiffness);
}

void ReadMaterials(const JsonNode& node, const std::string& folder, Scene* scene) {
  std::vector<const char*> keys;
  for (const ParameterKind kind : MaterialKinds()) keys.push_back(RowOf(kind).name);
  keys.insert(keys.end(), {"membrane", "bending", "bend_poisson", "bend_rest", "warp_direction", "warp_angle"});
  node.ExpectKeys(keys);
  for (const ParameterKind kind : MaterialKinds()) ReadFreeConstant(node, RowOf(kind), &scene->material);
  ReadMembrane(node, scene);
  ReadBending(node, &scene->bending);
  ReadRigidities(node, scene);
  ReadWarp(node, folder, scene);
}

std::vector<GridField> ReadFields(const JsonNode& node) {
  std::vector<const char*> keys;
  for (const ParameterRow& row : ParameterTable()) {
    if (CanBeField(row.kind)) keys.push_back(row.name);
  }
  node.ExpectKeys(keys);
  std::vector<GridField> fields;
  for (const std::string& name : node.keys()) {
    fields.push_back({ParseFieldKind(name, "fields"), ReadControlGrid(*node.Find(name))});
  }
  return fields;
}

void SetLevels(Scene* scene) {
  Parameters parameters{scene->material, {}, nullptr};
  parameters.pieces = scene->pieces;
  for (const GridField& field : scene->fields) {
    double level = 0.0;
    FieldOverTriangles(field, scene->mesh, &level);
    SetParameter({field.kind}, level, &parameters);
  }
  scene->SetMaterials(parameters);
}

}  // namespace clothid
