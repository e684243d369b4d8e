#include "identify/export/export.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <system_error>

#include "costs/prediction/parameter_block.h"
#include "datasets/motion/motion_file.h"
#include "identify/base/fitted_result.h"
#include "identify/base/output_folder.h"
#include "identify/export/simulator_exports.h"
#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

const char* const kSimulators[] = {"mujoco", "newton", "arcsim", "blender", "ppf"};
constexpr char kMeshName[] = "export_cloth.obj";

std::string FileOf(const std::string& simulator) {
  if (simulator == "mujoco") return "export_mujoco.xml";
  return "export_" + simulator + (simulator == "arcsim" ? ".json" : ".py");
}

std::string TextOf(const std::string& simulator, const Scene& scene, const ExportConstants& constants) {
  if (simulator == "mujoco") return MujocoXml(scene, constants);
  if (simulator == "newton") return NewtonScript(constants);
  if (simulator == "arcsim") return ArcsimJson(constants);
  if (simulator == "blender") return BlenderScript(scene, constants);
  return PpfScript(constants);
}

// Of a result.json: in place of estimates the means of what was pooled, and what stands beside them.
ExportedEstimates ReadExported(const std::string& path) {
  ExportedEstimates estimates;
  estimates.values = ReadEstimates(path);
  const JsonValue json = ParseJson(ReadText(path, kMaxJsonBytes), path);
  const auto repetitions = JsonNode(json, path).Find("repetitions");
  if (!repetitions) return estimates;
  const JsonNode parameters = repetitions->Require("parameters", "an object");
  for (const std::string& name : parameters.keys()) {
    const JsonNode parameter = *parameters.Find(name);
    const JsonNode mean = parameter.Require("mean", "a number or null");
    if (mean.is(JsonValue::Kind::kNull)) continue;
    estimates.values[name] = mean.Number();
    estimates.remarks[name] = Printable(parameter.Require("words", "a text").String());
  }
  return estimates;
}

// Of a folder of results; none in those of older fits.
std::optional<FabricCard> ReadCardIn(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / kFabricCardName;
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return std::nullopt;
  return ReadFabricCard(path.string());
}

}  // namespace

void ExportedEstimates::TakeMeans(const Repetitions& repetitions) {
  for (const PooledParameter& parameter : repetitions.parameters) {
    if (parameter.is_pooled()) {
      values[parameter.name] = parameter.mean;
      remarks[parameter.name] = MeanText(parameter);
    } else if (repetitions.is_of_folders) {
      values.erase(parameter.name);
      remarks[parameter.name] = "told by fewer than two recordings; this is the nominal value";
    }
  }
}

std::vector<std::string> ParseSimulators(const std::string& text, const std::string& flag) {
  std::vector<std::string> simulators;
  if (text.empty()) return simulators;
  for (const std::string& item : Split(text, ',')) {
    const std::string name(Trimmed(item));
    if (name == "all") return {std::begin(kSimulators), std::end(kSimulators)};
    if (std::find(std::begin(kSimulators), std::end(kSimulators), name) == std::end(kSimulators)) {
      throw Error(ErrorKind::kUsage, flag + ": expected all or some of mujoco, newton, arcsim, blender, ppf; got '" +
                                         Printable(name) + "'");
    }
    if (std::find(simulators.begin(), simulators.end(), name) == simulators.end()) simulators.push_back(name);
  }
  return simulators;
}

Parameters ParametersOfEstimates(const std::map<std::string, double>& values, const Scene& scene) {
  Parameters parameters = scene.nominal_parameters();
  for (const auto& [name, value] : values) {
    const std::string base = BaseName(name);
    const bool is_of_another = name != base && name != base + "@1";
    const std::optional<ParameterId> id = FindParameter(base);
    const bool is_of_cloth = !id || (!IsWind(id->kind) && !IsOfRecording(id->kind));
    if (!is_of_another && is_of_cloth) SetParameter(ParseParameter(base, scene), value, &parameters);
  }
  return parameters;
}

void ExpectExportable(const Scene& scene, const std::string& source) {
  const Mesh& mesh = scene.mesh;
  if (!mesh.has_corner_rest() && mesh.links.empty() && mesh.folds.empty()) return;
  throw Error(ErrorKind::kUsage, source +
                                     ": expected a cloth without seams whose nodes each have one place at rest, not "
                                     "\"rest\": \"uv\"");
}

std::vector<ExportedFile> ExportCloth(const Scene& scene, const Parameters& parameters,
                                      const std::vector<std::string>& simulators,
                                      const std::map<std::string, std::string>& remarks, const FabricCard* card) {
  ExpectExportable(scene, "export");
  ExportConstants constants = MakeExportConstants(scene, parameters, card);
  constants.remarks = remarks;
  std::vector<ExportedFile> files;
  bool needs_mesh = false;
  for (const std::string& simulator : simulators) {
    files.push_back({FileOf(simulator), TextOf(simulator, scene, constants)});
    needs_mesh = needs_mesh || simulator != "mujoco";
  }
  if (needs_mesh) files.push_back({kMeshName, ClothObj(scene)});
  return files;
}

bool IsExportedFile(const std::string& name) {
  return name == kMeshName || std::any_of(std::begin(kSimulators), std::end(kSimulators),
                                          [&](const char* simulator) { return name == FileOf(simulator); });
}

void ExportResult(const std::string& result, const std::string& target, const std::string& simulators,
                  const std::string& folder) {
  if (simulators.empty()) throw Error(ErrorKind::kUsage, "--result: expected with --export");
  if (folder.empty()) throw Error(ErrorKind::kUsage, "--output: expected a folder");
  const std::vector<std::string> names = ParseSimulators(simulators, "--export");
  const ExportedEstimates estimates = ReadExported(result);
  const std::filesystem::path fit = std::filesystem::path(result).parent_path(), beside = fit / "predicted.bin";
  const std::optional<FabricCard> card = ReadCardIn(fit);
  const Scene scene = ReadMotion(target.empty() ? beside.string() : target).scene;
  const Parameters parameters = ParametersOfEstimates(estimates.values, scene);
  ValidateParameters(parameters, scene, result);
  OutputFolder output(folder);
  for (const ExportedFile& file : ExportCloth(scene, parameters, names, estimates.remarks, card ? &*card : nullptr))
    output.Write(file.name, file.text);
  output.Commit();
}

}  // namespace clothid
