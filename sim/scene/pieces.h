// Pieces of a cloth: groups of its triangles (Mesh::piece_names, Mesh::face_pieces) with a material each
// (Scene::pieces). Constants that a piece does not give are those of the scene, as is the material of what is in no
// piece.
#ifndef CLOTHID_SIM_SCENE_PIECES_H_
#define CLOTHID_SIM_SCENE_PIECES_H_

#include <Eigen/Core>
#include <string>

#include "sim/base/json_document.h"
#include "sim/mesh/obj_file.h"
#include "sim/scene/scene.h"

namespace clothid {

// Throws `Error` (kBadData), prefixed by `source`, unless every piece has a name of its own, at least one triangle and
// a material, and what is in none has one, too.
void ValidatePieces(const Scene& scene, const std::string& source);

// Throws `Error` (kBadData), prefixed by `source`, unless `parameters` has a material for each piece of `scene`, in its
// domain. It may differ from that of the whole in constants of `Scene::has_of_pieces` alone, where that is not 0.
void ValidatePieceMaterials(const Parameters& parameters, const Scene& scene, const std::string& source);

// Of every triangle [F] the constant of its piece over that of the whole cloth, which is 0 where all are: then 1.
Eigen::VectorXd PieceWeights(const Parameters& parameters, ParameterKind kind, const Mesh& mesh);

// The material of a cloth, of pieces the mean over its area: that of as much mass, and of as much energy in a uniform
// strain.
Material MeanMaterial(const Parameters& parameters, const Mesh& mesh);

// The `pieces` of scene.json: by name, the constants of a piece and its `triangles`, [first, last] or one alone;
// without them, those of that group in `groups`, of an OBJ file. After mesh, `materials` and `fields`, before
// `parameters`. Throws `Error` (kBadData) naming key and line.
void ReadPieces(const JsonNode& node, const FaceGroups& groups, Scene* scene);

// Whether a piece of theirs names no triangles.
bool NeedGroups(const JsonNode& pieces);

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_PIECES_H_
