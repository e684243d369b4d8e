#include "datasets/motion/scene_text.h"

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/obstacle/surface_sequence.h"
#include "sim/obstacle/triangulated_surface.h"
#include "sim/path/pose_csv.h"

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

Json ParseObject(const std::string& scene_text) {
  Json scene = Json::parse(scene_text, nullptr, /*allow_exceptions=*/false);
  if (!scene.is_object()) throw Error(ErrorKind::kBadData, "scene: expected a JSON object");
  return scene;
}

// [[x0, y0, z0], [x1, y1, z1], ..] of the columns of a matrix, on one line.
template <typename Matrix>
std::string ColumnsText(const Matrix& matrix) {
  Json list = Json::array();
  for (Eigen::Index i = 0; i < matrix.cols(); ++i) list.push_back({matrix(0, i), matrix(1, i), matrix(2, i)});
  return list.dump();
}

// [[time, x, y, z, qx, qy, qz, qw], ..] of a path, on one line.
std::string PathText(const RigidPath& path) {
  const Eigen::MatrixXd table = TableOfPath(path);
  Json list = Json::array();
  for (Eigen::Index i = 0; i < table.cols(); ++i) {
    list.push_back(std::vector<double>(table.col(i).begin(), table.col(i).end()));
  }
  return list.dump();
}

// Gives the first `key` that is null the value `list`: long lists are not to be indented number by number.
void FillFirst(const std::string& key, const std::string& list, std::string* text) {
  const std::string member = "\"" + key + "\": ", null = "null";
  text->replace(text->find(member + null) + member.size(), null.size(), list);
}

// Whether the directions of the warp are from a file.
bool NamesWarp(const Json& json) {
  return json.contains("materials") && json["materials"].contains("warp_direction") &&
         json["materials"]["warp_direction"].is_string();
}

// Whether a piece of the cloth is a group of a file.
bool NamesGroups(const Json& json) {
  const Json pieces = json.value("pieces", Json::object());
  return std::any_of(pieces.begin(), pieces.end(), [](const Json& piece) { return !piece.contains("triangles"); });
}

// [[first, last], ..] of the triangles of a piece, on one line.
std::string TrianglesText(const Mesh& mesh, int piece) {
  Json list = Json::array();
  for (int face = 0; face < mesh.num_faces(); ++face) {
    if (mesh.face_pieces[static_cast<std::size_t>(face)] != piece) continue;
    if (!list.empty() && list.back()[1] == face - 1) {
      list.back()[1] = face;
    } else {
      list.push_back({face, face});
    }
  }
  return list.dump();
}

// Whether something of it may stand in a file.
bool HasLists(const SceneObstacle& obstacle) {
  return obstacle.path != nullptr || dynamic_cast<const TriangulatedSurface*>(obstacle.shape.get()) != nullptr;
}

// The handles of a recording, whose paths are in its tensors: nodes, and clamps with what turns them.
Json HandlesText(const Json& handles) {
  const bool is_list = handles.is_array() && !handles.empty() && handles[0].is_object();
  const Json groups = is_list ? handles : Json::array({handles});
  Json nodes = Json::array(), kept = Json::array();
  bool is_clamped = false;
  for (const Json& group : groups) {
    const Json& own = group.is_object() ? group["nodes"] : group;
    nodes.insert(nodes.end(), own.begin(), own.end());
    Json& held = kept.emplace_back(Json{{"nodes", own}});
    for (const char* key : {"clamp", "attach", "poses"}) {
      if (group.is_object() && group.contains(key)) held[key] = group[key];
    }
    is_clamped = is_clamped || (held.contains("clamp") && held["clamp"] != false);
  }
  return is_clamped ? kept : nodes;
}

// Makes keys null, in the place of what they name, and collects the lists that belong there, in the order of the text.
class InlineLists {
 public:
  InlineLists(const Scene& scene, Json* json) {
    for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
      if (HasLists(scene.obstacles[i])) AddObstacle(scene.obstacles[i], &json->at("obstacles").at(i));
    }
    if (json->contains("handles")) AddHandles(scene.handles, &json->at("handles"));
    if (scene.warp.directions.cols() > 0 && NamesWarp(*json)) {
      (*json)["materials"]["warp_direction"] = nullptr;
      lists_.emplace_back("warp_direction", ColumnsText(scene.warp.directions));
    }
    if (!scene.mesh.piece_names.empty() && NamesGroups(*json)) AddPieces(scene.mesh, &(*json)["pieces"]);
  }

  bool empty() const { return lists_.empty(); }
  void Fill(std::string* text) const {
    for (const auto& [key, list] : lists_) FillFirst(key, list, text);
  }

 private:
  void AddObstacle(const SceneObstacle& obstacle, Json* json) {
    if (const auto* surface = dynamic_cast<const TriangulatedSurface*>(obstacle.shape.get())) {
      json->erase("obj");
      for (const char* key : {"vertices", "faces"}) (*json)[key] = nullptr;
      lists_.emplace_back("vertices", ColumnsText(surface->vertices()));
      lists_.emplace_back("faces", ColumnsText(surface->faces()));
    }
    if (obstacle.sequence != nullptr) {
      (*json)["sequence"] = {{"times", nullptr}};
      const Eigen::VectorXd& times = obstacle.sequence->times();
      lists_.emplace_back("times", Json(std::vector<double>(times.begin(), times.end())).dump());
    }
    if (obstacle.path == nullptr || !(*json)["path"].is_string()) return;
    (*json)["path"] = nullptr;
    lists_.emplace_back("path", PathText(*obstacle.path));
  }

  void AddHandles(const Handles& handles, Json* json) {
    std::size_t number = 0;
    const auto add = [&](Json* group) {
      if (!group->is_object() || !group->contains("poses")) return;
      const RigidPath& path = *handles.bodies.at(number++);
      if (!group->at("poses").is_string()) return;
      group->at("poses") = nullptr;
      lists_.emplace_back("poses", PathText(path));
    };
    if (!json->is_array()) return add(json);
    for (Json& group : *json) add(&group);
  }

  void AddPieces(const Mesh& mesh, Json* json) {
    for (std::size_t piece = 0; piece < mesh.piece_names.size(); ++piece) {
      (*json)[mesh.piece_names[piece]]["triangles"] = nullptr;
      lists_.emplace_back("triangles", TrianglesText(mesh, static_cast<int>(piece)));
    }
  }

  std::vector<std::pair<std::string, std::string>> lists_;
};

}  // namespace

std::string WithInlineLists(const std::string& scene_text, const Scene& scene) {
  const bool is_plain = scene.obstacles.empty() && scene.warp.directions.cols() == 0 &&
                        scene.mesh.piece_names.empty() && scene.handles.bodies.empty();
  if (is_plain) return scene_text;
  Json json = Json::parse(scene_text);
  const InlineLists lists(scene, &json);
  if (lists.empty()) return scene_text;
  std::string text = json.dump(2);
  lists.Fill(&text);
  // For its limits.
  ParseJson(text, "scene with the surfaces of its obstacles, their paths, the directions of its warp and its pieces");
  return text;
}

RecordedSequences SequencesOf(const Scene& scene) {
  RecordedSequences sequences;
  for (const SceneObstacle& obstacle : scene.obstacles) {
    if (obstacle.sequence != nullptr) sequences[obstacle.name] = obstacle.sequence->positions();
  }
  return sequences;
}

std::string WithRecordedHandles(const std::string& scene_text) {
  Json scene = ParseObject(scene_text);
  if (!scene.contains("handles")) return scene_text;
  const Json handles = HandlesText(scene["handles"]);
  if (handles == scene["handles"]) return scene_text;
  scene["handles"] = handles;
  return scene.dump(2);
}

std::string SelfContainedText(const Scene& original, const std::string& scene_text, bool* start_is_first_frame) {
  Json scene = ParseObject(scene_text);
  if (scene.contains("mesh") && scene["mesh"].contains("obj")) scene.erase("mesh");
  if (scene.contains("handles")) scene["handles"] = HandlesText(scene["handles"]);
  Json& initial = scene["initial"];
  *start_is_first_frame = initial.contains("positions") && initial["positions"] != "rest";
  if (!*start_is_first_frame) {
    initial["positions"] = "rest";
  } else {
    initial.erase("positions");
    if (initial.empty()) scene.erase("initial");
  }
  return WithInlineLists(scene.dump(2), original);
}

}  // namespace clothid
