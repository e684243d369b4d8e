#include "sim/cloth/cloth_pieces.h"

#include <cstddef>
#include <memory>

namespace clothid {

std::vector<MembranePart> MembraneParts(MembraneLaw law, const TriangleElements& triangles,
                                        const std::vector<int>& face_pieces, const std::vector<Material>& materials) {
  std::vector<std::vector<int>> faces(materials.size());
  for (std::size_t f = 0; f < face_pieces.size(); ++f) {
    faces[static_cast<std::size_t>(face_pieces[f])].push_back(static_cast<int>(f));
  }
  std::vector<MembranePart> parts;
  for (std::size_t i = 0; i < materials.size(); ++i) {
    auto own = std::make_shared<const TriangleElements>(SelectTriangles(triangles, faces[i]));
    parts.push_back({Membrane(law, std::move(own)), materials[i]});
  }
  return parts;
}

Eigen::VectorXd PieceMask(int piece, const std::vector<int>& face_pieces) {
  Eigen::VectorXd mask(static_cast<Eigen::Index>(face_pieces.size()));
  for (std::size_t f = 0; f < face_pieces.size(); ++f) {
    mask[static_cast<Eigen::Index>(f)] = piece == kWholeCloth || face_pieces[f] == piece ? 1.0 : 0.0;
  }
  return mask;
}

ClothPieces::ClothPieces(const Scene& scene, const std::vector<WeightedBending>& bending) {
  const Mesh& mesh = scene.mesh;
  const int num_pieces = static_cast<int>(mesh.piece_names.size());
  for (int i = 0; i <= num_pieces; ++i) {
    const Eigen::VectorXd mask = PieceMask(i < num_pieces ? i : kWholeCloth, mesh.face_pieces);
    areas_.push_back(WeightedNodeAreas(mesh, mask));
    std::vector<BendingMatrix>& terms = bending_.emplace_back();
    for (const WeightedBending& term : bending) terms.push_back(term.Of(mask));
  }
}

}  // namespace clothid
