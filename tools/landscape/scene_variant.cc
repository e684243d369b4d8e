#include "tools/landscape/scene_variant.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

// Numbers up to here are integers exactly; a key that wants an integer accepts no fraction in its text.
constexpr double kMaxInteger = 9007199254740992.0;  // 2^53

[[noreturn]] void FailOnSweep(const std::string& text, const std::string& problem) {
  throw Error(ErrorKind::kUsage, "--sweep: '" + Printable(text) + "': " + problem);
}

// "touch=1e-5,1e-3": one change per value.
std::vector<SceneChange> ParseChanges(const std::string& text) {
  const std::size_t equals = text.find('=');
  const std::string expected = "expected KEY=NUMBER[,NUMBER...]";
  if (equals == 0 || equals == std::string::npos) FailOnSweep(text, expected);
  std::vector<SceneChange> changes;
  std::set<double> values;
  for (const std::string& item : Split(text.substr(equals + 1), ',')) {
    const std::optional<double> value = ParseNumber(item);
    if (!value) FailOnSweep(text, expected);
    if (!values.insert(*value).second) FailOnSweep(text, "has the value " + item + " twice");
    changes.push_back({text.substr(0, equals), *value});
  }
  return changes;
}

Json NumberOf(double value) {
  if (value == std::trunc(value) && std::abs(value) <= kMaxInteger) return static_cast<long long>(value);
  return value;
}

// The element that `segment` picks of an array.
std::size_t IndexOf(const std::string& segment, std::size_t size, const std::string& key) {
  const std::string axes = "xyz";
  const std::optional<long long> number = ParseInteger(segment);
  std::size_t index = size;
  if (segment.size() == 1 && axes.find(segment) != std::string::npos) {
    index = axes.find(segment);
  } else if (number && *number >= 0) {
    index = static_cast<std::size_t>(*number);
  }
  if (index >= size) {
    FailOnSweep(key, "'" + Printable(segment) + "': expected x, y, z or an index below " + std::to_string(size));
  }
  return index;
}

// The value that the path `segments`, from `first` on, leads to in `node`; null where it has to be added. Keys of an
// object may have dots of their own ("mu.ball"): the longest one that is there is meant.
Json* Find(const std::vector<std::string>& segments, std::size_t first, const std::string& key, Json* node) {
  while (first < segments.size()) {
    if (node->is_array()) {
      node = &(*node)[IndexOf(segments[first], node->size(), key)];
      ++first;
      continue;
    }
    if (node->is_null()) *node = Json::object();
    if (!node->is_object()) FailOnSweep(key, "there is nothing below '" + Printable(segments[first - 1]) + "'");
    std::size_t end = segments.size();
    const auto name = [&] {
      std::string joined = segments[first];
      for (std::size_t i = first + 1; i < end; ++i) joined += "." + segments[i];
      return joined;
    };
    while (end > first + 1 && !node->contains(name())) --end;
    node = &(*node)[name()];
    first = end;
  }
  return node;
}

// Throws `Error` (kUsage) for keys of a scene that say nothing about the cost of a recording.
void ExpectHasEffect(const SceneVariant& variant) {
  for (const SceneChange& change : variant) {
    const std::string key = Split(change.key, '.').front();
    if (key == "duration") FailOnSweep(change.key, "has no effect: a recording has its own duration");
    if (key == "parameters") FailOnSweep(change.key, "has no effect: starts and bounds are those of a fit");
  }
}

}  // namespace

std::vector<SceneVariant> ParseSweep(const std::string& text) {
  std::vector<SceneVariant> variants(1);
  if (text.empty()) return variants;
  std::set<std::string> keys;
  for (const std::string& item : Split(text, ';')) {
    const std::vector<SceneChange> changes = ParseChanges(item);
    if (!keys.insert(changes.front().key).second) FailOnSweep(changes.front().key, "is there twice");
    if (keys.size() > kMaxSweepKeys) FailOnSweep(text, "more than " + std::to_string(kMaxSweepKeys) + " keys");
    if (variants.size() * changes.size() > kMaxVariants) {
      FailOnSweep(text, "more than " + std::to_string(kMaxVariants) + " combinations");
    }
    std::vector<SceneVariant> longer;
    for (const SceneVariant& variant : variants) {
      for (const SceneChange& change : changes) {
        longer.push_back(variant);
        longer.back().push_back(change);
      }
    }
    variants = std::move(longer);
  }
  return variants;
}

std::string VariantName(const SceneVariant& variant) {
  std::string name;
  for (const SceneChange& change : variant) {
    name += (name.empty() ? "" : ";") + change.key + "=" + ShortestText(change.value);
  }
  return name;
}

std::string ChangeScene(const std::string& scene_text, const std::vector<std::string>& obstacle_names,
                        const SceneVariant& variant) {
  if (variant.empty()) return scene_text;
  Json scene = Json::parse(scene_text);
  for (const SceneChange& change : variant) {
    const std::vector<std::string> segments = Split(change.key, '.');
    if (segments.size() > kMaxKeyParts)
      FailOnSweep(change.key, "more than " + std::to_string(kMaxKeyParts) + " parts of a key");
    const auto obstacle = std::find(obstacle_names.begin(), obstacle_names.end(), segments.front());
    const bool is_obstacle = obstacle != obstacle_names.end() && segments.size() > 1;
    Json* root = is_obstacle ? &scene["obstacles"][obstacle - obstacle_names.begin()] : &scene;
    Json* value = Find(segments, is_obstacle ? 1 : 0, change.key, root);
    if (!value->is_null() && !value->is_number()) FailOnSweep(change.key, "expected the key of a number");
    *value = NumberOf(change.value);
  }
  // A key that is no UTF-8 becomes one that no scene has.
  return scene.dump(-1, ' ', false, Json::error_handler_t::replace);
}

RecordedMotion ReadMotionVariant(const MotionReader& read, ReadMotionOptions options, const SceneVariant& variant) {
  RecordedMotion motion = read(options);
  if (variant.empty()) return motion;
  ExpectHasEffect(variant);
  options.change_scene = [&](const std::string& text) {
    return ChangeScene(text, motion.scene.obstacle_names(), variant);
  };
  try {
    return read(options);
  } catch (const Error& error) {
    std::string problem = error.what();
    if (problem.rfind("--sweep", 0) == 0) throw;
    if (problem.find("expected an array") != std::string::npos) {
      problem += "; the scene has to have the array that x, y, z or an index picks from";
    }
    FailOnSweep(VariantName(variant), problem);
  }
}

}  // namespace clothid
