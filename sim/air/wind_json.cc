#include "sim/air/wind_json.h"

#include <string>
#include <vector>

namespace clothid {
namespace {

void ReadVector(const JsonNode& object, const char* key, Eigen::Vector3d* value) {
  if (const auto node = object.Find(key)) *value = node->Vector3();
}

WindProfile ReadProfile(const JsonNode& node) {
  node.ExpectKeys({"times", "velocities"});
  const JsonNode times_node = node.Require("times", "a list of times (s)");
  const JsonNode velocities_node = node.Require("velocities", "a list of velocities, one for each of the times (m/s)");
  const std::vector<JsonNode> times = times_node.items(), velocities = velocities_node.items();
  if (times.empty() || times.size() > kMaxWindKnots) {
    times_node.Fail("expected 1 to " + std::to_string(kMaxWindKnots) + " times");
  }
  if (velocities.size() != times.size()) {
    velocities_node.Fail("expected " + std::to_string(times.size()) + " velocities, one for each of the times");
  }
  WindProfile profile;
  profile.times.resize(static_cast<Eigen::Index>(times.size()));
  profile.velocities.resize(3, profile.times.size());
  for (std::size_t k = 0; k < times.size(); ++k) {
    const auto knot = static_cast<Eigen::Index>(k);
    profile.times[knot] = times[k].Number();
    profile.velocities.col(knot) = velocities[k].Vector3();
    if (k > 0 && !(profile.times[knot] > profile.times[knot - 1])) {
      times[k].Fail("expected a time above the one before it");
    }
  }
  return profile;
}

}  // namespace

void ReadWind(const JsonNode& node, Wind* wind) {
  node.ExpectKeys({"mean", "gust", "frequency", "wave_vector", "phase", "shear", "profile"});
  ReadVector(node, "mean", &wind->mean);
  ReadVector(node, "gust", &wind->gust);
  ReadVector(node, "wave_vector", &wind->wave_vector);
  ReadVector(node, "shear", &wind->shear);
  if (const auto frequency = node.Find("frequency")) wind->frequency = frequency->Number();
  if (const auto phase = node.Find("phase")) wind->phase = phase->Number();
  if (const auto profile = node.Find("profile")) wind->profile = ReadProfile(*profile);
}

void ReadAirLaw(const JsonNode& node, AirLaw* law) {
  node.ExpectKeys({"law"});
  const auto name = node.Find("law");
  if (!name) return;
  const std::string text = name->is(JsonValue::Kind::kString) ? name->String() : "";
  if (text != "linear" && text != "quadratic") name->Fail("expected \"linear\" or \"quadratic\"");
  *law = text == "linear" ? AirLaw::kLinear : AirLaw::kQuadratic;
}

}  // namespace clothid
