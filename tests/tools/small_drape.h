// A small `drape`: hung by its top edge, the lower half falls on a sphere and slides.
#ifndef CLOTHID_TESTS_TOOLS_SMALL_DRAPE_H_
#define CLOTHID_TESTS_TOOLS_SMALL_DRAPE_H_

#include <nlohmann/json.hpp>
#include <string>

namespace clothid {

// The text of the scene with n x n nodes, 0.4 s.
inline std::string SmallDrape(int n) {
  nlohmann::ordered_json scene = nlohmann::ordered_json::parse(R"({
    "clothid_scene": 1,
    "time_step": 0.01,
    "duration": 0.4,
    "mesh": {"grid": {"nodes": [6, 6], "size": [0.5, 0.5], "origin": [-0.25, 0, 0],
                      "axes": [[1, 0, 0], [0, 0.906307787036650, -0.422618261740699]]}},
    "handles": [],
    "obstacles": [{"name": "ball", "type": "sphere", "center": [0.03, 0.25, -0.35], "radius": 0.2, "mu": 0.57}],
    "materials": {"density": 0.2, "k_stretch": 240, "k_bend": 2e-3, "drag": 0.05},
    "solver": {"step_tolerance": 1e-8}
  })");
  scene["mesh"]["grid"]["nodes"] = {n, n};
  for (int i = 0; i < n; ++i) scene["handles"].push_back(i);
  return scene.dump(2);
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_TOOLS_SMALL_DRAPE_H_
