#include "datasets/fabric/scene_with_fabric.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>

#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/fabric/fabric.h"

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

class CardWriter {
 public:
  CardWriter(const FabricCard& card, const Json& scene)
      : card_(card),
        materials_(scene.value("materials", Json::object())),
        parameters_(scene.value("parameters", Json::object())) {}

  void Write(Json* scene) {
    if (!materials_.is_object() || !parameters_.is_object()) return;  // their reader complains
    if (Tells(ParameterTerm::kMembrane)) WriteMembrane();
    if (Tells(ParameterTerm::kBending)) WriteBending();
    for (const CardConstant& constant : card_.constants) {
      const ParameterTerm term = RowOf(constant.kind).term;
      if (term != ParameterTerm::kMembrane && term != ParameterTerm::kBending) WriteConstant(constant);
    }
    (*scene)["materials"] = materials_;
    if (parameters_.empty()) {
      scene->erase("parameters");
    } else {
      (*scene)["parameters"] = parameters_;
    }
  }

 private:
  bool Tells(ParameterTerm term) const {
    return std::any_of(card_.constants.begin(), card_.constants.end(), [&](const CardConstant& constant) {
      return constant.is_told() && RowOf(constant.kind).term == term;
    });
  }

  void WriteMembrane() {
    const std::string law = MembraneName(card_.membrane);
    const Json own = materials_.value("membrane", Json("arap"));
    if (own != law) Erase(ParameterTerm::kMembrane);
    materials_["membrane"] = law;
    WriteTerm(ParameterTerm::kMembrane);
    EraseWarpOfNone();
  }

  void WriteBending() {
    const bool is_orthotropic = card_.Find(ParameterKind::kWarpBending) != nullptr;
    if (materials_.contains("bend_warp") != is_orthotropic || materials_.value("bending", Json()) == "edges") {
      Erase(ParameterTerm::kBending);
    }
    materials_["bending"] = "patches";
    materials_["bend_poisson"] = card_.bend_poisson;
    WriteTerm(ParameterTerm::kBending);
    EraseWarpOfNone();
  }

  void WriteTerm(ParameterTerm term) {
    for (const CardConstant& constant : card_.constants) {
      if (RowOf(constant.kind).term != term) continue;
      const char* name = RowOf(constant.kind).name;
      WriteConstant(constant);
      if (!constant.is_told() && !materials_.contains(name)) materials_[name] = constant.value;
    }
  }

  void WriteConstant(const CardConstant& constant) {
    if (!constant.is_told()) return;
    const char* name = RowOf(constant.kind).name;
    materials_[name] = constant.value;
    Json& parameter = parameters_[name];
    if (parameter.is_null()) parameter = Json::object();
    if (!parameter.is_object()) return;  // its reader complains
    parameter.erase("nominal");
    parameter.erase("prior");
    if (parameter.value("frozen", Json(false)) == true) return;
    const ParameterPrior prior = constant.Prior();
    const bool is_logarithmic = IsLogarithmic(constant.kind);
    parameter["prior"] = {{is_logarithmic ? "median" : "mean", prior.center},
                          {is_logarithmic ? "factor" : "std", prior.spread}};
  }

  void Erase(ParameterTerm term) {
    for (const ParameterRow& row : ParameterTable()) {
      if (row.term != term) continue;
      materials_.erase(row.name);
      parameters_.erase(row.name);
    }
  }

  // Directions of a warp that nothing has any more.
  void EraseWarpOfNone() {
    if (materials_.value("membrane", Json("arap")) != "arap" || materials_.contains("bend_warp")) return;
    materials_.erase("warp_direction");
    materials_.erase("warp_angle");
  }

  const FabricCard& card_;
  Json materials_, parameters_;
};

void ExpectNoField(const Json& scene, const FabricCard& card, const std::string& source) {
  const Json fields = scene.value("fields", Json::object());
  for (const CardConstant& constant : card.constants) {
    const std::string name = RowOf(constant.kind).name;
    if (!constant.is_told() || !fields.is_object() || !fields.contains(name)) continue;
    throw Error(ErrorKind::kUsage, source + ": key 'fields." + name + "': expected none, as the card tells " + name);
  }
}

}  // namespace

bool IsFabricCard(const std::string& fabric) {
  constexpr std::string_view kEnding = ".json";
  if (FindFabric(fabric) != nullptr) return false;
  const bool ends = fabric.size() >= kEnding.size() && fabric.substr(fabric.size() - kEnding.size()) == kEnding;
  std::error_code ignored;
  return ends || std::filesystem::is_regular_file(fabric, ignored);
}

FabricCard ReadToldCard(const std::string& path) {
  FabricCard card = ReadFabricCard(path);
  if (!card.tells_any()) {
    throw Error(ErrorKind::kBadData, path + ": key 'constants': expected one that a fit told, with an interval");
  }
  return card;
}

std::string WithFabricCard(const std::string& scene_text, const FabricCard& card, const std::string& source) {
  if (ParseJson(scene_text, source).kind != JsonValue::Kind::kObject) return scene_text;  // its reader complains
  Json scene = Json::parse(scene_text);
  ExpectNoField(scene, card, source);
  CardWriter(card, scene).Write(&scene);
  return scene.dump();  // on one line: lists may be long
}

std::string WithFabricOrCard(const std::string& scene_text, const std::string& fabric, const std::string& flag,
                             const std::string& source) {
  if (IsFabricCard(fabric)) return WithFabricCard(scene_text, ReadToldCard(fabric), source);
  return WithFabric(scene_text, fabric, flag, source);
}

}  // namespace clothid
