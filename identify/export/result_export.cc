#include "identify/export/result_export.h"

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "datasets/motion/motion_file.h"
#include "identify/base/output_folder.h"
#include "identify/export/export.h"
#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

// The estimates of a result.json by name.
std::map<std::string, double> ReadEstimates(const std::string& path) {
  const std::string text = ReadText(path, kMaxJsonBytes);
  ParseJson(text, path);  // an error names the line
  const nlohmann::json result = nlohmann::json::parse(text);
  const bool is_result = result.is_object() && result.value("schema", nlohmann::json()) == "clothid.result/1";
  if (!is_result || !result.contains("parameters") || !result["parameters"].is_object()) {
    throw Error(ErrorKind::kBadData, path + ": key 'schema': expected \"clothid.result/1\", with 'parameters'");
  }
  std::map<std::string, double> values;
  for (const auto& [name, parameter] : result["parameters"].items()) {
    if (!parameter.is_object() || !parameter.contains("value") || !parameter["value"].is_number()) {
      throw Error(ErrorKind::kBadData, path + ": key 'parameters." + Printable(name) + ".value': expected a number");
    }
    values[name] = parameter["value"].get<double>();
  }
  return values;
}

}  // namespace

void ExportResult(const std::string& result, const std::string& target, const std::string& simulators,
                  const std::string& folder) {
  if (simulators.empty()) throw Error(ErrorKind::kUsage, "--result: expected with --export");
  if (folder.empty()) throw Error(ErrorKind::kUsage, "--output: expected a folder");
  const std::vector<std::string> names = ParseSimulators(simulators, "--export");
  const std::map<std::string, double> values = ReadEstimates(result);
  const std::filesystem::path beside = std::filesystem::path(result).parent_path() / "predicted.bin";
  const Scene scene = ReadMotion(target.empty() ? beside.string() : target).scene;
  const Parameters parameters = ParametersOfEstimates(values, scene);
  ValidateParameters(parameters, scene, result);
  OutputFolder output(folder);
  for (const ExportedFile& file : ExportCloth(scene, parameters, names)) output.Write(file.name, file.text);
  output.Commit();
}

}  // namespace clothid
