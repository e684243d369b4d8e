// The shipped scenes on meshes of any size.
#ifndef CLOTHID_TESTS_SIM_SHIPPED_SCENES_H_
#define CLOTHID_TESTS_SIM_SHIPPED_SCENES_H_

#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <vector>

#include "sim/scene/scene_json.h"

namespace clothid {

// Scene `name` ("drape", "slope", "wind") with n x n nodes, at the parameters that the file gives as nominal, as the
// paper has it, whatever the file says: backward Euler, of which a step is one solve, and bending by edges. Tests of
// two stages and of plates ask for them.
inline Scene ShippedScene(const std::string& name, int n, Integrator integrator = Integrator::kEuler) {
  const std::string path = std::string(CLOTHID_SOURCE_DIR) + "/datasets/" + name + ".scene.json";
  std::ifstream file(path);
  nlohmann::json json = nlohmann::json::parse(file);
  json["mesh"]["grid"]["nodes"] = {n, n};
  if (name == "drape") {
    std::vector<int> top_edge(n);
    std::iota(top_edge.begin(), top_edge.end(), 0);
    json["handles"] = top_edge;
  } else if (name == "wind") {
    json["handles"] = {0, n - 1};
  }
  json["integrator"] = IntegratorName(integrator);
  json["materials"]["bending"] = "edges";
  return ParseScene(json.dump(), path, "");
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_SHIPPED_SCENES_H_
