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

// SDIRK2 tells forces from impacts by the sign of a change of normal velocity (sim/contact/impact_share.h). A cloth
// that starts to slide on the plane, exactly at rest in its normal direction, stands on that kink: this one arrives.
inline void Land(Scene* scene) {
  const Eigen::Vector3d normal = scene->obstacles[0].shape->Closest(Eigen::Vector3d::Zero()).normal;
  const bool gap_mode = scene->contact_mode == ContactMode::kGap;
  Eigen::VectorXd& state = gap_mode ? scene->initial_positions : scene->initial_velocities;
  state.reshaped(3, scene->mesh.num_nodes()).colwise() += (gap_mode ? 1e-4 : -0.01) * normal;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_SHIPPED_SCENES_H_
