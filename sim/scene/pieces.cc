#include "sim/scene/pieces.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <set>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

using Kind = JsonValue::Kind;

constexpr char kTriangles[] = "triangles";

// Names stand in flags ("k_stretch.NAME"), so they must not hold what separates flags.
void CheckName(const JsonNode& piece, const std::string& name) {
  const auto is_allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  if (name.empty() || !std::all_of(name.begin(), name.end(), is_allowed)) {
    piece.Fail("expected a name of letters, digits, '_' and '-'");
  }
}

FaceRange ReadRange(const JsonNode& item, int num_faces) {
  if (!item.is(Kind::kArray)) {
    const int face = item.Integer(0, num_faces - 1);
    return {face, face};
  }
  const std::vector<JsonNode> ends = item.items();
  if (ends.size() != 2) item.Fail("expected a triangle, or the first and the last of some");
  const FaceRange range = {ends[0].Integer(0, num_faces - 1), ends[1].Integer(0, num_faces - 1)};
  if (range[0] > range[1]) item.Fail("expected the first triangle before the last");
  return range;
}

// Those that the piece lists, else those of its group.
FaceRanges ReadTriangles(const JsonNode& piece, const std::string& name, const FaceGroups& groups, int num_faces) {
  FaceRanges ranges;
  if (const auto list = piece.Find(kTriangles)) {
    for (const JsonNode& item : list->items()) ranges.push_back(ReadRange(item, num_faces));
    if (ranges.empty()) list->Fail("expected at least one triangle");
    return ranges;
  }
  if (groups.empty()) piece.Fail("expected \"triangles\": [..] in it, or a mesh from an OBJ file with such a group");
  const auto group = groups.find(name);
  if (group != groups.end() && !group->second.empty()) return group->second;
  std::string names;
  for (const auto& [known, faces] : groups) {
    if (!faces.empty()) names += (names.empty() ? "" : ", ") + known;
  }
  piece.Fail(group != groups.end() ? "no triangle of the mesh is in that group"
                                   : "the mesh has no such group; expected one of " + Printable(names));
}

// What is not given is the scene's.
Material ReadMaterial(const JsonNode& piece, const Scene& scene) {
  Material material = scene.material;
  for (const std::string& key : piece.keys()) {
    if (key == kTriangles) continue;
    const JsonNode node = *piece.Find(key);
    const auto kind = std::find_if(MaterialKinds().begin(), MaterialKinds().end(), [&](ParameterKind other) {
      return RowOf(other).part == ParameterPart::kPiece && ParameterName({other}, {}) == key;
    });
    if (kind == MaterialKinds().end()) node.Fail("expected triangles, or a constant that pieces can have");
    const bool is_field = std::any_of(scene.fields.begin(), scene.fields.end(),
                                      [&](const GridField& field) { return field.kind == *kind; });
    if (is_field) node.Fail("expected none beside 'fields." + key + "'");
    if (!scene.has(*kind)) node.Fail("the scene has no such term");
    if (!IsInDomain(RowOf(*kind).domain, node.Number()))
      node.Fail(std::string("expected ") + DomainWords(RowOf(*kind).domain));
    material.*RowOf(*kind).constant = node.Number();
  }
  return material;
}

// A level that is not 0 where a piece has more than that.
void RaiseLevels(Scene* scene) {
  for (const ParameterKind kind : MaterialKinds()) {
    double& level = scene->material.*RowOf(kind).constant;
    if (level != 0.0 || RowOf(kind).domain == ParameterDomain::kAny) continue;
    for (const Material& material : scene->pieces) level = std::max(level, material.*RowOf(kind).constant);
  }
}

}  // namespace

void ValidatePieces(const Scene& scene, const std::string& source) {
  const auto expect = [&](bool condition, const std::string& key, const std::string& expected) {
    if (!condition) throw Error(ErrorKind::kBadData, source + ": key '" + key + "': expected " + expected);
  };
  const Mesh& mesh = scene.mesh;
  const std::size_t num_pieces = mesh.piece_names.size();
  expect(scene.pieces.size() == (num_pieces == 0 ? 0 : num_pieces + 1), "pieces",
         "a material for every piece of the mesh, and for what is in none");
  if (num_pieces == 0) return;
  expect(mesh.face_pieces.size() == static_cast<std::size_t>(mesh.num_faces()), "pieces", "one of every triangle");
  std::vector<int> sizes(num_pieces + 1);
  for (const int piece : mesh.face_pieces) {
    expect(piece >= 0 && piece <= static_cast<int>(num_pieces), "pieces", "triangles in pieces that are there");
    ++sizes[static_cast<std::size_t>(piece)];
  }
  std::set<std::string> names;
  for (std::size_t i = 0; i < num_pieces; ++i) {
    const std::string& name = mesh.piece_names[i];
    expect(!name.empty() && names.insert(name).second, "pieces", "names that no other piece has");
    expect(sizes[i] > 0, "pieces." + name, "at least one triangle");
  }
}

void ValidatePieceMaterials(const Parameters& parameters, const Scene& scene, const std::string& source) {
  const std::vector<std::string>& names = scene.mesh.piece_names;
  if (parameters.pieces.size() != scene.pieces.size()) {
    throw Error(ErrorKind::kBadData, source + ": expected a material for every piece of the scene");
  }
  for (std::size_t i = 0; i < parameters.pieces.size(); ++i) {
    for (const ParameterKind kind : MaterialKinds()) {
      double Material::*const constant = RowOf(kind).constant;
      const double value = parameters.pieces[i].*constant, level = parameters.material.*constant;
      const auto expect = [&](bool condition, const std::string& expected) {
        if (condition) return;
        const std::string name = ParameterName({kind}, {}) + (i < names.size() ? "." + names[i] : "");
        throw Error(ErrorKind::kBadData,
                    source + ": parameter '" + name + "' is " + std::to_string(value) + "; expected " + expected);
      };
      if (scene.has(kind)) expect(IsInDomain(RowOf(kind).domain, value), DomainWords(RowOf(kind).domain));
      expect(scene.has_of_pieces(kind) || value == level, "that of the whole cloth");
      expect(level != 0.0 || value == 0.0 || RowOf(kind).domain == ParameterDomain::kAny,
             "0, as the material of the scene has it");
    }
  }
}

Eigen::VectorXd PieceWeights(const Parameters& parameters, ParameterKind kind, const Mesh& mesh) {
  double Material::*const constant = RowOf(kind).constant;
  const double level = parameters.material.*constant;
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(mesh.num_faces());
  if (level == 0.0) return weights;
  for (int f = 0; f < mesh.num_faces(); ++f) {
    weights[f] = parameters.pieces[static_cast<std::size_t>(mesh.face_pieces[f])].*constant / level;
  }
  return weights;
}

Material MeanMaterial(const Parameters& parameters, const Mesh& mesh) {
  Material mean = parameters.material;
  if (parameters.pieces.empty()) return mean;
  const Eigen::VectorXd areas = TriangleAreas(mesh);
  for (const ParameterKind kind : MaterialKinds()) {
    double Material::*const constant = RowOf(kind).constant;
    if (RowOf(kind).part != ParameterPart::kPiece) continue;
    double sum = 0.0;
    for (int f = 0; f < mesh.num_faces(); ++f) {
      sum += areas[f] * (parameters.pieces[static_cast<std::size_t>(mesh.face_pieces[f])].*constant);
    }
    mean.*constant = sum / areas.sum();
  }
  return mean;
}

void ReadPieces(const JsonNode& node, const FaceGroups& groups, Scene* scene) {
  Mesh& mesh = scene->mesh;
  mesh.piece_names = node.keys();
  if (mesh.piece_names.empty()) node.Fail("expected at least one piece");
  const int num_pieces = static_cast<int>(mesh.piece_names.size());
  mesh.face_pieces.assign(static_cast<std::size_t>(mesh.num_faces()), num_pieces);
  for (int i = 0; i < num_pieces; ++i) {
    const std::string& name = mesh.piece_names[static_cast<std::size_t>(i)];
    const JsonNode piece = *node.Find(name);
    CheckName(piece, name);
    for (const auto& [first, last] : ReadTriangles(piece, name, groups, mesh.num_faces())) {
      for (int face = first; face <= last; ++face) {
        int& owner = mesh.face_pieces[static_cast<std::size_t>(face)];
        if (owner != num_pieces) {
          piece.Fail("triangle " + std::to_string(face) + " is in piece '" +
                     mesh.piece_names[static_cast<std::size_t>(owner)] + "', too");
        }
        owner = i;
      }
    }
    scene->pieces.push_back(ReadMaterial(piece, *scene));
  }
  scene->pieces.push_back(scene->material);
  RaiseLevels(scene);
}

bool NeedGroups(const JsonNode& pieces) {
  const std::vector<std::string>& names = pieces.keys();
  return std::any_of(names.begin(), names.end(), [&](const std::string& name) {
    const JsonNode piece = *pieces.Find(name);
    return piece.is(Kind::kObject) && !piece.Find(kTriangles);
  });
}

}  // namespace clothid
