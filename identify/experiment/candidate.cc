#include "identify/experiment/candidate.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <random>
#include <utility>

#include "costs/prediction/alignment.h"
#include "datasets/synthetic/synthetic.h"
#include "identify/problem/problem_blocks.h"
#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"
#include "sim/scene/scene_json.h"

namespace clothid {
namespace {

// Without a prior two thirds of what is believed of a scale lie between its nominal value over this and times this.
constexpr double kDrawFactor = 1.5;
// How far off its bounds a drawn value is, in shares of the range: at a bound a fit gives no interval.
constexpr double kOffBounds = 0.01;

std::vector<std::string> AllNames(const FitOptions& fit) {
  std::vector<std::string> names = ExpandAlignmentNames(fit.parameters);
  for (const std::string& name : ExpandAlignmentNames(fit.each)) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

// Friction says something only where there are obstacles.
bool Tells(const Scene& scene, const std::string& name) {
  return HasParameter(scene, name) && (name != "mu" || !scene.obstacles.empty());
}

template <typename Value>
void KeepNamed(const std::vector<std::string>& names, std::map<std::string, Value>* given) {
  for (auto it = given->begin(); it != given->end();) {
    const bool is_named = std::any_of(names.begin(), names.end(), [&](const std::string& name) {
      const std::vector<std::string> known = OverrideNames(name);
      return std::find(known.begin(), known.end(), it->first) != known.end();
    });
    it = is_named ? std::next(it) : given->erase(it);
  }
}

// Those of `fit` alone that `keeps` tells to keep, with what is said of them.
template <typename Keeps>
FitOptions Restrict(const FitOptions& all, const Keeps& keeps) {
  FitOptions fit;
  fit.overrides = all.overrides;
  std::copy_if(all.parameters.begin(), all.parameters.end(), std::back_inserter(fit.parameters), keeps);
  std::copy_if(all.each.begin(), all.each.end(), std::back_inserter(fit.each), keeps);
  const std::vector<std::string> names = AllNames(fit);
  KeepNamed(names, &fit.overrides.start);
  KeepNamed(names, &fit.overrides.lower_bounds);
  KeepNamed(names, &fit.overrides.upper_bounds);
  KeepNamed(names, &fit.overrides.priors);
  fit.cancel = all.cancel;
  return fit;
}

// What is said of parameters that are not fitted would go unheard.
template <typename Value>
void ExpectNamed(const std::vector<std::string>& names, const std::map<std::string, Value>& given,
                 const std::string& flag) {
  std::map<std::string, Value> named = given;
  KeepNamed(names, &named);
  for (const auto& [name, value] : given) {
    ExpectUsage(named.count(name) > 0, flag + ": '" + name + "' is not among the fitted parameters");
  }
}

void CheckOverrides(const FitOptions& fit) {
  const std::vector<std::string> names = AllNames(fit);
  ExpectNamed(names, fit.overrides.start, "--start");
  ExpectNamed(names, fit.overrides.lower_bounds, "--lower");
  ExpectNamed(names, fit.overrides.upper_bounds, "--upper");
  ExpectNamed(names, fit.overrides.priors, "--prior");
}

// "drape" of "datasets/drape.scene.json".
std::string ShortName(const std::string& path) {
  std::string name = std::filesystem::path(path).filename().string();
  for (const std::string end : {".json", ".scene"}) {
    if (name.size() > end.size() && name.compare(name.size() - end.size(), end.size(), end) == 0) {
      name.resize(name.size() - end.size());
    }
  }
  return name;
}

Candidate ReadCandidate(const std::string& path) {
  Candidate candidate;
  candidate.path = path;
  candidate.name = ShortName(path);
  candidate.text = ReadText(path, kMaxJsonBytes);
  candidate.scene = ParseScene(candidate.text, path, std::filesystem::path(path).parent_path().string());
  return candidate;
}

// Throws where it cannot be recorded as it is planned.
void CheckRecording(const PlanOptions& options, const Candidate& candidate) {
  const Scene& scene = candidate.scene;
  SyntheticOptions sensor;
  sensor.frame_rate = options.frame_rate;
  try {
    CheckSyntheticOptions(sensor, scene, candidate.text);
  } catch (const Error& error) {
    throw Error(error.kind(), candidate.path + ": " + error.what());
  }
  const int num_free = scene.mesh.num_nodes() - static_cast<int>(scene.handles.nodes.size());
  ExpectUsage(options.num_markers <= num_free, "--markers " + std::to_string(options.num_markers) + ": " +
                                                   candidate.path + " has " + std::to_string(num_free) + " free nodes");
  ExpectUsage(!options.has_forces || !scene.handles.nodes.empty(),
              "--forces: " + candidate.path + " has no handles that a gauge could hold");
}

// Where two have the same name, both go by their paths.
void TellApart(std::vector<Candidate>* candidates) {
  std::map<std::string, int> counts;
  for (const Candidate& candidate : *candidates) ++counts[candidate.name];
  for (Candidate& candidate : *candidates) {
    if (counts[candidate.name] > 1) candidate.name = candidate.path;
  }
}

// Stream `name` of the draws of a cloth, the same for all candidates.
double Deviate(const PlanOptions& options, int cloth, const std::string& name) {
  const std::vector<std::string> names = AllNames(options.fit);
  const auto index = std::find(names.begin(), names.end(), name) - names.begin();
  std::seed_seq sequence{static_cast<std::uint32_t>(options.seed), static_cast<std::uint32_t>(options.seed >> 32),
                         static_cast<std::uint32_t>(cloth), static_cast<std::uint32_t>(index)};
  std::mt19937_64 generator(sequence);
  return std::normal_distribution<double>(0.0, 1.0)(generator);
}

double DrawnValue(const ParameterBlock& block, double deviate) {
  double value = block.start * std::pow(kDrawFactor, deviate);
  if (block.prior.is_given()) value = block.ToValue(block.PriorCoordinate() + block.PriorStd() * deviate);
  const double margin = kOffBounds * block.CoordinateRange();
  const double lowest = block.ToCoordinate(block.lower_bound) + margin;
  const double highest = block.ToCoordinate(block.upper_bound) - margin;
  const bool is_positive = block.scale != ParameterScale::kLog || value > 0.0;
  return block.ToValue(is_positive ? std::clamp(block.ToCoordinate(value), lowest, highest) : lowest);
}

// Of the parameters of its fit, but of recordings' own ones.
void AddBlocks(Candidate* candidate) {
  for (const std::string& name : AllNames(candidate->fit)) {
    const std::optional<ParameterId> id = FindParameter(name);
    if (id && IsOfRecording(id->kind)) continue;
    candidate->blocks.push_back(MakeParameterBlock(name, candidate->scene, candidate->fit.overrides));
  }
}

}  // namespace

std::vector<Candidate> ReadCandidates(const PlanOptions& options) {
  std::vector<Candidate> candidates;
  for (const std::string& path : options.scene_paths) candidates.push_back(ReadCandidate(path));
  for (const Candidate& candidate : candidates) CheckRecording(options, candidate);
  TellApart(&candidates);
  CheckOverrides(options.fit);
  for (Candidate& candidate : candidates) {
    candidate.fit = Restrict(options.fit, [&](const std::string& name) {
      const bool anyone_tells = std::any_of(candidates.begin(), candidates.end(),
                                            [&](const Candidate& other) { return Tells(other.scene, name); });
      return !anyone_tells || Tells(candidate.scene, name);
    });
    AddBlocks(&candidate);
  }
  return candidates;
}

Candidate ReadPredicted(const PlanOptions& options) {
  Candidate predicted = ReadCandidate(options.predicted_path);
  predicted.fit = Restrict(options.fit, [&](const std::string& name) { return HasParameter(predicted.scene, name); });
  AddBlocks(&predicted);
  return predicted;
}

FitOptions JointOptions(const PlanOptions& options, const std::vector<const Candidate*>& candidates) {
  return Restrict(options.fit, [&](const std::string& name) {
    return std::any_of(candidates.begin(), candidates.end(), [&](const Candidate* candidate) {
      const FitOptions& fit = candidate->fit;
      return std::find(fit.parameters.begin(), fit.parameters.end(), name) != fit.parameters.end() ||
             std::find(fit.each.begin(), fit.each.end(), name) != fit.each.end();
    });
  });
}

std::map<std::string, double> DrawCloth(const PlanOptions& options, const Candidate& candidate, int cloth) {
  std::map<std::string, double> truth;
  for (const ParameterBlock& block : candidate.blocks) {
    if (!Tells(candidate.scene, block.name)) continue;
    const bool is_drawn = cloth > 0 && !block.is_signed && !block.frozen;
    truth[block.name] = is_drawn ? DrawnValue(block, Deviate(options, cloth, block.name)) : block.start;
  }
  return truth;
}

}  // namespace clothid
