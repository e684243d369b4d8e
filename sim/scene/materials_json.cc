#include "sim/scene/materials_json.h"

#include <cmath>

namespace clothid {
namespace {

using Kind = JsonValue::Kind;

void ReadNonNegative(const JsonNode& object, const char* key, double* value) {
  if (const auto node = object.Find(key)) *value = node->NonNegativeNumber();
}

void ReadPositive(const JsonNode& object, const char* key, double* value) {
  if (const auto node = object.Find(key)) *value = node->PositiveNumber();
}

void ReadBending(const JsonNode& materials, Bending* bending) {
  if (const auto law = materials.Find("bending")) {
    if (!law->is(Kind::kString) || (law->String() != "edges" && law->String() != "patches")) {
      law->Fail("expected \"edges\" or \"patches\"");
    }
    bending->law = law->String() == "edges" ? BendingLaw::kEdges : BendingLaw::kPatches;
  }
  const auto poisson = materials.Find("bend_poisson");
  if (!poisson) return;
  if (!poisson->is(Kind::kNumber) || !(std::abs(poisson->Number()) < 1.0)) {
    poisson->Fail("expected a number between -1 and 1");
  }
  if (bending->law != BendingLaw::kPatches) poisson->Fail("expected \"bending\": \"patches\" beside it");
  bending->poisson = poisson->Number();
}

}  // namespace

void ReadMaterials(const JsonNode& node, Scene* scene) {
  node.ExpectKeys({"density", "k_stretch", "k_bend", "bending", "bend_poisson", "drag", "damping"});
  Material& material = scene->material;
  ReadPositive(node, "density", &material.density);
  ReadPositive(node, "k_stretch", &material.stretch_stiffness);
  ReadNonNegative(node, "k_bend", &material.bending_stiffness);
  ReadNonNegative(node, "drag", &material.drag);
  ReadNonNegative(node, "damping", &material.damping);
  ReadBending(node, &scene->bending);
}

}  // namespace clothid
