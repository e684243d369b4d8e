// Scenes whose cloth has pieces.
#ifndef CLOTHID_TESTS_SIM_PIECES_SCENE_H_
#define CLOTHID_TESTS_SIM_PIECES_SCENE_H_

#include <utility>

#include "sim/scene/scene.h"

namespace clothid {

// The cloth of `scene` with pieces "a" and "b" of a third of its triangles each, in their order. Their constants are
// `a` and `b` times those of the scene, which what is in neither has.
inline Scene InPieces(Scene scene, double a, double b) {
  Mesh& mesh = scene.mesh;
  mesh.piece_names = {"a", "b"};
  mesh.face_pieces.clear();
  for (int f = 0; f < mesh.num_faces(); ++f) mesh.face_pieces.push_back(3 * f / mesh.num_faces());
  Parameters nominal = scene.nominal_parameters();
  nominal.pieces.assign(3, nominal.material);
  for (const ParameterKind kind : MaterialKinds()) {
    if (RowOf(kind).part != ParameterPart::kPiece) continue;
    nominal.pieces[0].*RowOf(kind).constant *= a;
    nominal.pieces[1].*RowOf(kind).constant *= b;
    scene.parameters.erase(ParameterName({kind}, {}));
  }
  scene.SetMaterials(nominal);
  return scene;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_PIECES_SCENE_H_
