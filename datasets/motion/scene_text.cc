#include "datasets/motion/scene_text.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>

#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/obstacle/triangulated_surface.h"

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

// [[x0, y0, z0], [x1, y1, z1], ..] of the columns of a matrix, on one line.
template <typename Matrix>
std::string ColumnsText(const Matrix& matrix) {
  Json list = Json::array();
  for (Eigen::Index i = 0; i < matrix.cols(); ++i) list.push_back({matrix(0, i), matrix(1, i), matrix(2, i)});
  return list.dump();
}

// Gives the first `key` that is null the value `list`: long lists are not to be indented number by number.
void Fill(const std::string& key, const std::string& list, std::string* text) {
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

}  // namespace

std::string WithInlineLists(const std::string& scene_text, const Scene& scene) {
  std::map<std::size_t, const TriangulatedSurface*> surfaces;  // by obstacle
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    const auto* surface = dynamic_cast<const TriangulatedSurface*>(scene.obstacles[i].shape.get());
    if (surface != nullptr) surfaces[i] = surface;
  }
  const bool has_directions = scene.warp.directions.cols() > 0;
  const bool has_pieces = !scene.mesh.piece_names.empty();
  if (surfaces.empty() && !has_directions && !has_pieces) return scene_text;
  Json json = Json::parse(scene_text);
  const bool names_warp = has_directions && NamesWarp(json);
  const bool names_groups = has_pieces && NamesGroups(json);
  if (surfaces.empty() && !names_warp && !names_groups) return scene_text;
  if (names_warp) json["materials"]["warp_direction"] = nullptr;
  for (const auto& [i, surface] : surfaces) {
    Json& obstacle = json.at("obstacles").at(i);
    obstacle.erase("obj");
    for (const char* key : {"vertices", "faces"}) obstacle[key] = nullptr;
  }
  for (const std::string& name : scene.mesh.piece_names) {
    if (names_groups) json["pieces"][name]["triangles"] = nullptr;
  }
  std::string text = json.dump(2);
  for (const auto& [i, surface] : surfaces) {
    Fill("vertices", ColumnsText(surface->vertices()), &text);
    Fill("faces", ColumnsText(surface->faces()), &text);
  }
  if (names_warp) Fill("warp_direction", ColumnsText(scene.warp.directions), &text);
  for (int piece = 0; names_groups && piece < static_cast<int>(scene.mesh.piece_names.size()); ++piece) {
    Fill("triangles", TrianglesText(scene.mesh, piece), &text);
  }
  // For its limits.
  ParseJson(text, "scene with the surfaces of its obstacles, the directions of its warp and its pieces");
  return text;
}

std::string SelfContainedText(const Scene& original, const std::string& scene_text, bool* start_is_first_frame) {
  Json scene = Json::parse(scene_text, nullptr, /*allow_exceptions=*/false);
  if (!scene.is_object()) throw Error(ErrorKind::kBadData, "scene: expected a JSON object");
  if (scene.contains("mesh") && scene["mesh"].contains("obj")) scene.erase("mesh");
  if (scene.contains("handles") && scene["handles"].is_object()) scene["handles"] = scene["handles"]["nodes"];
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
